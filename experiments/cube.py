"""Real tosses of a cube, simulated open loop: what friction and softness of the floor explain."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
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
from experiments.figures.result_file import figure_name
from experiments.figures.save_options import parse_and_save
from experiments.needs import need_recordings
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
SETS = {"judged, opened once": range(100, 300), "development": range(300, 400)}
"""Tosses that no fit sees. What to fit was chosen by looking at the second set."""
FITTED, RIVAL = "fitted", "friction alone, fitted for itself"
LEAST = (0.1, 500.0, 20.0)
"""The least friction, stiffness, N/m, and damping, N s/m, that the fit tries."""
MOST = (1.0, 10_000.0, 150.0)
"""The most: a step of 1.7 ms takes 219 N s/m from a cube of 0.37 kg (`spring.settle`)."""


@dataclass(frozen=True, kw_only=True)
class Floor:
    """Friction and softness of the floor."""

    mu: float
    """Sliding friction coefficient."""
    stiffness: float | None = None
    """N/m; None for MuJoCo's own softness."""
    damping: float | None = None
    """N s/m; None together with the stiffness."""

    def effects(self) -> tuple[Effect, ...]:
        """Return the effects that make this floor."""
        friction = (Ground(), ContactFriction(contact="cube+floor", mu=self.mu))
        if self.stiffness is None or self.damping is None:
            return friction
        softness = ContactSoftness(
            contact="cube+floor", stiffness=self.stiffness, damping=self.damping
        )
        return (*friction, softness)


def fitted(
    robot: Robot,
    real: Sequence[Array],
    rng: np.random.Generator,
    *,
    rounds: int = 15,
    tries: int = 16,
    hard: bool = False,
) -> Floor:
    """Return the floor whose simulated tosses come nearest to the real ones.

    With `hard` the floor has MuJoCo's own softness and friction alone is fitted.

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
        floors = [floor_at(row, hard=hard) for row in drawn]
        variants = [on(robot, floor.effects()) for floor in floors]
        score = position_errors(flights(variants, real), real).mean(axis=1)
        kept = drawn[np.argsort(score)[: tries // 3]]
        if score.min() < least:
            best, least = drawn[int(np.argmin(score))], float(score.min())
        # Some of the old spread stays, so that few tries do not end the search early.
        middle, spread = kept.mean(axis=0), 0.4 * spread + 0.6 * kept.std(axis=0)
    return floor_at(best, hard=hard)


def floor_at(logarithms: Array, *, hard: bool = False) -> Floor:
    """Return the floor at logarithms of friction, stiffness and damping."""
    mu, stiffness, damping = (float(value) for value in np.exp(logarithms))
    return Floor(mu=mu) if hard else Floor(mu=mu, stiffness=stiffness, damping=damping)


def controls(robot: Robot, floor: Floor, plain: Floor) -> dict[str, Variant]:
    """Return the fitted floor and the simpler ones it is held against.

    Args:
        robot: The cube.
        floor: Friction and softness, fitted together.
        plain: Friction alone, fitted for itself.
    """
    pyramid = ContactFriction(contact="cube+floor", mu=floor.mu, pyramid=1.0)
    softness = floor.effects()[2]
    return {
        FITTED: on(robot, floor.effects()),
        RIVAL: on(robot, plain.effects()),
        "friction alone, of the whole fit": on(robot, Floor(mu=floor.mu).effects()),
        "friction alone, as published": on(robot, Floor(mu=PUBLISHED).effects()),
        "fitted, friction a pyramid": on(robot, (Ground(), pyramid, softness)),
        "friction alone, a pyramid": on(robot, (Ground(), pyramid)),
        "softness alone": on(robot, (Ground(), softness)),
        "as MuJoCo comes": on(robot, (Ground(),)),
    }


def studied(root: Path, *, train: int, test: int, seed: int) -> JSON:
    """Return the study: floors fitted, and errors on tosses that no fit has seen.

    Args:
        root: Folder of the recordings.
        train: How many tosses to fit, from the first.
        test: How many of each set to score, from its first.
        seed: Of the fits.
    """
    robot = from_mjcf(DESCRIPTION)
    seen = tosses(root, range(train))
    floor, plain = (
        fitted(robot, seen, np.random.default_rng(seed), hard=hard) for hard in (False, True)
    )
    variants = controls(robot, floor, plain)
    return {
        "schema": "morph.cube/2",
        "seed": seed,
        "train": [0, train - 1],
        "floor": asdict(floor),
        "friction_alone": plain.mu,
        "sets": [_scored(root, variants, title, each[:test]) for title, each in SETS.items()],
    }


def _scored(root: Path, variants: Mapping[str, Variant], title: str, which: range) -> JSON:
    """Return the errors of every floor on some tosses, and those of the rival above ours."""
    real = tosses(root, which)
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
    more = rows[RIVAL][0] - rows[FITTED][0]
    return {
        "set": title,
        "tosses": [which[0], which[-1]],
        "errors": {name: summary(*found) for name, found in rows.items()},
        "rival_costs_more": {
            "widths": float(more.mean()),
            "standard_error": float(more.std() / np.sqrt(len(more))),
            "of_tosses": float(np.mean(more > 0.0)),
        },
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
    """Print the study as a table for each set of tosses."""
    floor = result["floor"]
    print(
        f"fitted on tosses {result['train'][0]} to {result['train'][1]}: friction "
        f"{floor['mu']:.4f} (published {PUBLISHED}), {floor['stiffness']:.0f} N/m, "
        f"{floor['damping']:.0f} N s/m; friction alone {result['friction_alone']:.4f}"
    )
    for scored in result["sets"]:
        first, last = scored["tosses"]
        print(f"\nopen loop over all of tosses {first} to {last} ({scored['set']}):")
        print(f"{'model':34}{'position, % of width':>22}{'median':>9}{'rotation, deg':>15}")
        for name, row in scored["errors"].items():
            mean, error = 100.0 * row["position_widths"], 100.0 * row["standard_error"]
            print(
                f"{name:34}{mean:14.1f} +-{error:5.1f}{100.0 * row['median_widths']:9.1f}"
                f"{row['rotation_deg']:15.1f}"
            )
        more = scored["rival_costs_more"]
        print(
            f"toss by toss {RIVAL} errs by {100.0 * more['widths']:.1f} "
            f"+- {100.0 * more['standard_error']:.1f} % more than the whole fit, "
            f"and is worse on {more['of_tosses']:.0%}"
        )


def headline(result: JSON) -> JSON:
    """Return what a result file holds: errors in percent of the cube's width."""
    figures = {
        "friction": result["floor"]["mu"],
        "friction_alone": result["friction_alone"],
        "published_friction": PUBLISHED,
        "stiffness": result["floor"]["stiffness"],
        "damping": result["floor"]["damping"],
    }
    controls: JSON = {}
    rows = []
    for scored in result["sets"]:
        label = scored["set"].partition(",")[0]
        for name, row in scored["errors"].items():
            figures[f"{label}_{figure_name(name)}_percent"] = 100.0 * row["position_widths"]
            rows.append({"set": label, "model": name, **row})
        controls |= {f"{label}: {k}": v for k, v in scored["errors"].items() if k != FITTED}
        more = scored["rival_costs_more"]
        figures[f"{label}_rival_costs_more_percent"] = 100.0 * more["widths"]
        figures[f"{label}_rival_costs_more_error_percent"] = 100.0 * more["standard_error"]
    return {"figures": figures, "controls": controls, "rows": rows, "seeds": [result["seed"]]}


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
        "--test", type=int, default=200, help="score on this many of each set (default: all)"
    )
    parser.add_argument("--json", action="store_true", help="print JSON instead of a table")
    asked, save = parse_and_save(parser, arguments, module="experiments.cube")
    if not (1 <= asked.train <= 100 and asked.test >= 1 and asked.seed >= 0):
        parser.error("there are 100 tosses to fit on, at least one to score on, and seeds from 0")
    try:
        root = need_recordings("contactnets_cube")
        result = studied(root, train=asked.train, test=asked.test, seed=asked.seed)
        if save:
            save(**headline(result))
    except MorphError as error:
        print(f"error: {error}", file=sys.stderr)
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
