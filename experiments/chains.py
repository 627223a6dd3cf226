"""A policy of balance carried from the cart-pole to a humanoid that stands free on a skateboard.

Six hops, each of few transitions; with `--robots` a seventh, to the real Poppy Humanoid, put on the
same board. Only the cart-pole's simulator is ours: each hop starts from what the one before was
told. Told of every body: its transitions near rest, noise and period, the bounds of its commands,
what its task looks at; of humanoids, from the description, which servos turn in the plane that
the board rolls in. Beside the last hop stand one straight from the cart-pole, the chain's maps
composed without making the policy anew, shuffled and flipped maps, what fits the last body
without any source, holding still, and the oracle on the true model.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from align.maps.affine_map import AffineMap
from align.samples import Transitions
from experiments.interval import interval, iqm
from experiments.kept import finished, seeds_of
from experiments.morphologies.methods import sourceless
from morph.arrays import JSON, Array
from morph.body.load import load
from morph.files import write_whole
from morph.transfer.balancers import balancer
from morph.transfer.body import Body, linear_law, still_law
from morph.transfer.mapped.belief import read
from morph.transfer.mapped.feedback import plain
from morph.transfer.relay import as_believed, carry, relay, through_map, tried
from morph.transfer.riders import RIDERS, rider, riding

EXAMPLE = """example:
  python -m experiments.chains --seeds 0:10 --robots ../shared/robots --json out/chains.json \\
      --kept out/chains.jsonl
  python -m experiments.chains --seeds 100:102 --quick"""

CHAIN = (
    "cartpole", "rider_rigid_driven", "rider_rigid_passive", "rider_two_links_passive",
    "humanoid_driven", "humanoid_passive", "humanoid_free",
)  # fmt: skip
"""From the cart-pole to a humanoid on a free skateboard."""

TRANSITIONS = (30, 30, 60, 120, 60, 60)
"""Of each body after the first."""

REAL = "poppy"
"""The real humanoid, after the last."""

REAL_FILE = "poppy_humanoid/robots/Poppy_Humanoid.URDF"
"""Its description in the folder of real robots."""

REAL_FEET = ("l_foot", "r_foot")
"""Its feet."""

REAL_TRANSITIONS = 60
"""Of it."""

GRID = (15, 30, 60, 120, 240, 480)
"""Transitions from which learning without a source is tried."""

ALONE = ("ridge", "structured")
"""What fits the last body without any source."""

ENOUGH = 0.95
"""Share of the oracle's score that counts as balanced."""

ROWS = 2
"""Judged runs of every feedback."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """One chain under one seed."""

    seed: int
    """Of all chance."""
    robots: str
    """The folder of real robots; without it the chain ends before the real one."""
    quick: bool
    """Whether only a short chain and few counts are tried."""


def bodies_of(case: Case) -> tuple[dict[str, Body], tuple[int, ...]]:
    """Return the chain's bodies by name, and how many transitions each but the first gives."""
    names: tuple[str, ...] = CHAIN
    counts: tuple[int, ...] = TRANSITIONS
    if case.quick:
        names, counts = (CHAIN[0], CHAIN[1], *CHAIN[-2:]), (20, 30, 20)
    bodies = {name: rider(name) if name in RIDERS else balancer(name) for name in names}
    if case.robots:
        folder = Path(case.robots)
        path = folder / REAL_FILE
        real = load(path, base="floating", folder=path.parent.parent)
        bodies[REAL] = riding(real, REAL_FEET, "free")
        counts = (*counts, REAL_TRANSITIONS)
    return bodies, counts


def work(case: Case) -> JSON:
    """Return what a chain shows: scores on every body, and what stands beside the last hops."""
    bodies, counts = bodies_of(case)
    rows = 1 if case.quick else ROWS
    names, chain = list(bodies), list(bodies.values())
    oracle, still = {}, {}
    for name, body in bodies.items():
        optimum = linear_law(plain(read(body), body))
        oracle[name] = body.score(optimum, rows=rows, seed=case.seed)
        none = still_law(len(body.bounds[0]))
        still[name] = body.score(none, rows=rows, seed=case.seed)
    found = relay(chain, counts=counts, seed=case.seed, rows=rows)
    hops = {name: dict(hop.scores) for name, hop in zip(names[1:], found.hops, strict=True)}
    said: JSON = {"names": names, "counts": list(counts), "oracle": oracle, "hold_still": still}
    said["hops"] = hops
    first = plain(read(chain[0]), chain[0])
    said["ends"] = {}
    for end in [at for at, name in enumerate(names) if name in (CHAIN[-1], REAL)]:
        target = chain[end]
        gains = beside(chain[: end + 1], counts[:end], seed=case.seed)
        maps = [each.map for each in found.hops[:end]]
        gains["composed"] = composed(first, maps, chain[1 : end + 1])
        scores = {
            name: target.score(linear_law(gain), rows=rows, seed=case.seed)
            for name, gain in gains.items()
        }
        said["ends"][names[end]] = {
            "samples": int(sum(counts[:end])),
            "controls": scores,
            "sourceless": curves(target, case, rows),
        }
    return said


def beside(chain: Sequence[Body], counts: Sequence[int], *, seed: int) -> dict[str, Array]:
    """Return feedback of a chain's last body by a hop from the first, and by wrong maps."""
    source = as_believed(chain[-2], relay(chain[:-1], counts=counts[:-1], seed=seed).last.step)
    target, count = chain[-1], counts[-1]
    # The last hop of the relay had this seed: wrong maps see the same transitions.
    own = seed + 1000 * (len(chain) - 2)
    order = tuple(np.roll(np.arange(len(target.bounds[0])), 2).tolist())
    return {
        "direct": carry(chain[0], target, count, seed=own)[0].gain,
        "flipped": carry(source, target, count, seed=own, spoil=flipped)[0].gain,
        "shuffled": carry(source, target, count, seed=own, spoil=Shuffled(order))[0].gain,
    }


def flipped(right: AffineMap) -> AffineMap:
    """Return a map with every command turned round."""
    return replace(right, action_law=-right.action_law, read_law=-right.read_law)


@dataclass(frozen=True)
class Shuffled:
    """Makes a map one with the target's commands in another order."""

    order: tuple[int, ...]
    """Which command takes whose place."""

    def __call__(self, right: AffineMap) -> AffineMap:
        """Return the wrong map."""
        order = list(self.order)
        return replace(right, action_law=right.action_law[order], read_law=right.read_law[:, order])


def composed(gain: Array, maps: Sequence[object], bodies: Sequence[Body]) -> Array:
    """Return the first body's feedback through all maps, made anew nowhere."""
    for each, body in zip(maps, bodies, strict=True):
        assert isinstance(each, AffineMap)
        gain = through_map(each, gain, body)
    return gain


def curves(target: Body, case: Case, rows: int) -> JSON:
    """Return the scores of what fits the target alone, by its name and the transitions."""
    grid = GRID[:2] if case.quick else GRID
    stream = tried(target, max(grid), np.random.default_rng([case.seed, 41]))
    said: dict[str, dict[str, float]] = {name: {} for name in ALONE}
    for count in grid:
        seen = Transitions(
            state=stream.state[:count],
            command=stream.command[:count],
            after=stream.after[:count],
            turns=stream.turns,
        )
        gains = sourceless(target, seen)
        for name in ALONE:
            score = target.score(linear_law(gains[name]), rows=rows, seed=case.seed)
            said[name][str(count)] = score
    return said


def summary(found: Sequence[JSON]) -> JSON:
    """Return the figures, with intervals over seeds."""
    names = found[0]["names"]
    said: JSON = {"seeds": len(found), "hops": {}, "ends": {}}
    for name in names[1:]:
        kept = [each["hops"][name]["zero_shot"] / each["oracle"][name] for each in found]
        said["hops"][name] = {
            "kept": figure(kept),
            "solved": float(np.mean(np.array(kept) >= ENOUGH)),
            "hold_still": iqm(np.array([each["hold_still"][name] for each in found])),
            "oracle": iqm(np.array([each["oracle"][name] for each in found])),
        }
    for name in found[0]["ends"]:
        ends = [each["ends"][name] for each in found]
        optimum = [each["oracle"][name] for each in found]
        controls = {
            control: figure(
                [end["controls"][control] / best for end, best in zip(ends, optimum, strict=True)]
            )
            for control in ends[0]["controls"]
        }
        times = {
            way: [
                first(end["sourceless"][way], best) for end, best in zip(ends, optimum, strict=True)
            ]
            for way in ALONE
        }
        quickest = min(times, key=lambda way: float(np.mean(np.minimum(times[way], 2 * GRID[-1]))))
        took = np.minimum(times[quickest], 2 * GRID[-1])
        said["ends"][name] = {
            "samples": ends[0]["samples"],
            "controls": controls,
            "best_sourceless": quickest,
            "direct_samples": figure(list(took)),
            "direct_solved": float(np.isfinite(times[quickest]).mean()),
            "samples_over_direct": ends[0]["samples"] / iqm(took),
        }
    return said


def first(curve: dict[str, float], optimum: float) -> float:
    """Return from how many transitions on a score stays enough; infinity if it never does."""
    took = np.inf
    for count in sorted(curve, key=int, reverse=True):
        if curve[count] < ENOUGH * optimum:
            break
        took = float(count)
    return took


def figure(values: Sequence[float]) -> JSON:
    """Return the interquartile mean with its interval."""
    low, high = interval(np.array(values))
    return {"iqm": iqm(np.array(values)), "low": low, "high": high}


def main(argv: Sequence[str] | None = None) -> int:
    """Run the study."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.chains", description=__doc__, epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    parser.add_argument("--seeds", type=seeds_of, default=range(10), metavar="A:B")
    parser.add_argument("--robots", default="", metavar="DIR", help="folder of real robots")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures")
    parser.add_argument("--kept", type=Path, metavar="FILE", help="finished cases, to resume from")
    parser.add_argument("--workers", type=int, default=2, help="processes (default: 2)")
    parser.add_argument("--quick", action="store_true", help="one seed, a short chain")
    told = parser.parse_args(argv)
    seeds = told.seeds[:1] if told.quick else told.seeds
    cases = [Case(seed=seed, robots=told.robots, quick=told.quick) for seed in seeds]
    figures = summary(finished(cases, work, kept=told.kept, workers=told.workers))
    text = json.dumps(figures, indent=1)
    print(text)
    if told.json is not None:
        write_whole(told.json, text + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
