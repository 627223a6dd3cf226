"""Real tosses of a cube, simulated open loop: what friction and softness of the floor explain."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from experiments.cube_tosses import (
    DESCRIPTION,
    flights,
    on,
    position_errors,
    rotation_errors,
    shuffled,
    tosses,
)
from experiments.data import data_root
from experiments.openloop import from_mjcf
from morph.arrays import JSON, Array
from morph.body.robot import Robot
from morph.errors import MorphError
from morph.physics.contact.contact_friction import ContactFriction
from morph.physics.contact.contact_softness import ContactSoftness
from morph.physics.effect import Effect
from morph.physics.world.ground import Ground
from morph.sim.rollout import Variant

EXAMPLE = """example:
  python -m experiments.cube
  python -m experiments.cube --json --seed 2
"""
PUBLISHED = 0.18
"""Friction coefficient of cube and table, of Pfrommer, Halm and Posa 2020 (ContactNets)."""
LEAST = (0.1, 500.0, 20.0)
"""The least friction, stiffness, N/m, and damping, N s/m, that the fit tries."""
MOST = (1.0, 10_000.0, 150.0)
"""The most: a step of 1.7 ms takes 219 N s/m from a cube of 0.37 kg (`spring.settle`)."""


@dataclass(frozen=True, kw_only=True)
class Floor:
    """Friction and softness of the floor."""

    mu: float
    """Sliding friction coefficient."""
    stiffness: float
    """N/m."""
    damping: float
    """N s/m."""

    def effects(self) -> tuple[Effect, ...]:
        """Return the effects that make this floor."""
        return (
            Ground(),
            ContactFriction(contact="cube+floor", mu=self.mu),
            ContactSoftness(contact="cube+floor", stiffness=self.stiffness, damping=self.damping),
        )


def fitted(
    robot: Robot,
    real: Sequence[Array],
    rng: np.random.Generator,
    *,
    rounds: int = 15,
    tries: int = 16,
) -> Floor:
    """Return the floor whose simulated tosses come nearest to the real ones.

    The cross-entropy method (Rubinstein 1999, Methodology and Computing in Applied
    Probability 1): draw floors, keep the best third, draw about those. Numbers are logarithms
    of friction, stiffness and damping, within `LEAST` and `MOST`.
    """
    low, high = np.log(LEAST), np.log(MOST)
    middle, spread = 0.5 * (low + high), 0.35 * (high - low)
    best, least = middle, np.inf
    for _ in range(rounds):
        drawn = middle + spread * rng.standard_normal((tries, 3))
        drawn = np.clip(drawn, low, high)
        variants = [on(robot, floor_at(row).effects()) for row in drawn]
        score = position_errors(flights(variants, real), real).mean(axis=1)
        kept = drawn[np.argsort(score)[: tries // 3]]
        if score.min() < least:
            best, least = drawn[int(np.argmin(score))], float(score.min())
        # Some of the old spread stays, so that few tries do not end the search early.
        middle, spread = kept.mean(axis=0), 0.4 * spread + 0.6 * kept.std(axis=0)
    return floor_at(best)


def floor_at(logarithms: Array) -> Floor:
    """Return the floor at logarithms of friction, stiffness and damping."""
    mu, stiffness, damping = (float(value) for value in np.exp(logarithms))
    return Floor(mu=mu, stiffness=stiffness, damping=damping)


def controls(robot: Robot, floor: Floor) -> dict[str, Variant]:
    """Return the fitted floor and the simpler ones it is held against."""
    friction = ContactFriction(contact="cube+floor", mu=floor.mu)
    pyramid = ContactFriction(contact="cube+floor", mu=floor.mu, pyramid=1.0)
    softness = floor.effects()[2]
    return {
        "fitted": on(robot, floor.effects()),
        "fitted, friction a pyramid": on(robot, (Ground(), pyramid, softness)),
        "friction alone": on(robot, (Ground(), friction)),
        "friction alone, a pyramid": on(robot, (Ground(), pyramid)),
        "softness alone": on(robot, (Ground(), softness)),
        "as MuJoCo comes": on(robot, (Ground(),)),
    }


def studied(root: Path, *, train: Sequence[int], test: Sequence[int], seed: int) -> JSON:
    """Return the study: the floor fitted, and errors on tosses that it has not seen."""
    robot = from_mjcf(DESCRIPTION)
    floor = fitted(robot, tosses(root, train), np.random.default_rng(seed))
    real = tosses(root, test)
    variants = controls(robot, floor)
    simulated = flights(list(variants.values()), real)
    rows = dict(
        zip(
            variants,
            zip(position_errors(simulated, real), rotation_errors(simulated, real), strict=True),
            strict=True,
        )
    )
    best = [flight[:1] for flight in simulated]
    still = [np.repeat(toss[None, :1, :7], len(toss), axis=1) for toss in real]
    for name, other in (
        ("fitted, of another toss", shuffled(best, real)),
        ("does not move", still),
    ):
        rows[name] = (position_errors(other, real)[0], rotation_errors(other, real)[0])
    return {
        "schema": "morph.cube/1",
        "seed": seed,
        "train": [min(train), max(train)],
        "test": [min(test), max(test)],
        "floor": {"mu": floor.mu, "stiffness": floor.stiffness, "damping": floor.damping},
        "errors": {name: summary(*found) for name, found in rows.items()},
    }


def summary(position: Array, rotation: Array) -> Mapping[str, float]:
    """Return means over tosses, and the standard error of the first: widths and degrees."""
    return {
        "position_widths": float(position.mean()),
        "standard_error": float(position.std() / np.sqrt(len(position))),
        "median_widths": float(np.median(position)),
        "rotation_deg": float(rotation.mean()),
    }


def report(result: JSON) -> None:
    """Print the study as a table."""
    floor = result["floor"]
    print(
        f"fitted on tosses {result['train'][0]} to {result['train'][1]}: friction "
        f"{floor['mu']:.4f} (published {PUBLISHED}), {floor['stiffness']:.0f} N/m, "
        f"{floor['damping']:.0f} N s/m"
    )
    print(f"open loop over all of tosses {result['test'][0]} to {result['test'][1]}:")
    print(f"{'model':28}{'position, % of width':>22}{'median':>9}{'rotation, deg':>15}")
    for name, row in result["errors"].items():
        mean, error = 100.0 * row["position_widths"], 100.0 * row["standard_error"]
        print(
            f"{name:28}{mean:14.1f} +-{error:5.1f}{100.0 * row['median_widths']:9.1f}"
            f"{row['rotation_deg']:15.1f}"
        )


def main(arguments: list[str] | None = None) -> int:
    """Run the study and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.cube",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--seed", type=int, default=1, help="of the fit (default: 1)")
    parser.add_argument(
        "--train", type=int, default=100, help="fit on this many tosses from 0 (default: 100)"
    )
    parser.add_argument(
        "--test", type=int, default=100, help="score on this many tosses from 300 (default: 100)"
    )
    parser.add_argument("--json", action="store_true", help="print JSON instead of a table")
    asked = parser.parse_args(arguments)
    if not (1 <= asked.train <= 300 and 1 <= asked.test <= 100 and asked.seed >= 0):
        parser.error("there are 300 tosses to fit on and 100 to score on, and seeds from 0")
    try:
        result = studied(
            data_root(),
            train=range(asked.train),
            test=range(300, 300 + asked.test),
            seed=asked.seed,
        )
    except MorphError as error:
        print(error, file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    if asked.json:
        print(json.dumps(result, indent=1))
    else:
        report(result)
    return 0


if __name__ == "__main__":
    sys.exit(main())
