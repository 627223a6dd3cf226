"""A policy of balance carried from the cart-pole to a humanoid that stands free on a skateboard.

Six hops, each of few transitions, and a seventh to the real Poppy Humanoid, put on the same board
(left out by `--without-real`). Only the cart-pole's simulator is ours: each hop starts from what
the one before was told. Told of every body: its transitions near rest, noise and period, the bounds
of its commands, what its task looks at; of humanoids, from the description, which servos turn in
the plane that the board rolls in. Beside the last hop stand one straight from the cart-pole, the
chain's maps composed without making the policy anew, shuffled and flipped maps (made anew, and the
map alone), what fits the last body without any source, learning it from nothing, holding still,
and the oracle on the true model.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from experiments.balance_chained.summary import ALONE, ENOUGH, GRID, summary
from experiments.engine_options import add_engine_options, rows_of, seeds_of
from experiments.figures.result_file import flat
from experiments.figures.save_options import parse_and_save
from experiments.morphologies.methods import flipped, sourceless
from experiments.morphologies.scratch import SIZES, scratch
from experiments.needs import need_robots
from morph.alignment.maps.affine_map import AffineMap
from morph.alignment.samples import Transitions
from morph.arrays import JSON, Array
from morph.body.load import load
from morph.errors import MorphError
from morph.files import write_whole
from morph.policy_transfer.balancers import balancer, seen_with
from morph.policy_transfer.body import Body, linear_law, still_law
from morph.policy_transfer.mapped.belief import read
from morph.policy_transfer.mapped.feedback import plain
from morph.policy_transfer.relay import Relayed, as_believed, carry, relay, through_map, tried
from morph.policy_transfer.riders import RIDERS, rider, riding
from morph.study.cell import cells_of

EXAMPLE = """example:
  python -m experiments.chains --seeds 0:10 --json out/chains.json
  python -m experiments.chains --seeds 100:102 --quick"""

CHAIN = (
    "cartpole", "rider_rigid_driven", "rider_rigid_passive", "rider_two_links_passive",
    "rider_three_links_passive", "humanoid_passive", "humanoid_free",
)  # fmt: skip
"""From the cart-pole to a humanoid on a free skateboard.

`humanoid_driven` is left out: after its push of 3.85 N s holding still scores .30, its oracle .93.
"""

TRANSITIONS = (10, 10, 60, 60, 40, 40)
"""Of each body after the first."""

REAL = "poppy"
"""The real humanoid, after the last."""

REAL_FILE = "poppy_humanoid/robots/Poppy_Humanoid.URDF"
"""Its description in the folder of real robots."""

REAL_FEET = ("l_foot", "r_foot")
"""Its feet."""

REAL_TRANSITIONS = 40
"""Of it."""

GENERATIONS = 3
"""Generations of learning from nothing, 16 runs each, with each of three sizes of moves."""

ROWS = 2
"""Judged runs of every feedback."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """One chain under one seed."""

    seed: int
    """Of all chance."""
    robots: str
    """The folder of real robots; without it the chain ends before the real one."""
    noise: float
    """Standard deviation of every reading."""
    quick: bool
    """Whether only a short chain and few counts are tried."""


def bodies_of(case: Case) -> tuple[dict[str, Body], tuple[int, ...]]:
    """Return the chain's bodies by name, and how many transitions each but the first gives."""
    names: tuple[str, ...] = CHAIN
    counts: tuple[int, ...] = TRANSITIONS
    if case.quick:
        names, counts = (CHAIN[0], CHAIN[1], CHAIN[-1]), (20, 40)
    bodies = {name: rider(name) if name in RIDERS else balancer(name) for name in names}
    if case.robots:
        folder = Path(case.robots)
        path = folder / REAL_FILE
        real = load(path, base="floating", folder=path.parent.parent)
        bodies[REAL] = riding(real, REAL_FEET, "free")
        counts = (*counts, REAL_TRANSITIONS)
    return {name: seen_with(body, case.noise) for name, body in bodies.items()}, counts


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
    said["ends"] = {}
    for end in [at for at, name in enumerate(names) if name in (CHAIN[-1], REAL)]:
        name, target = names[end], chain[end]
        gains = beside(chain, found, end, seed=case.seed)
        controls = {
            control: target.score(linear_law(gain), rows=rows, seed=case.seed)
            for control, gain in gains.items()
        }
        said["ends"][name] = {
            "samples": int(sum(counts[:end])),
            "controls": controls,
            "sourceless": curves(target, case, rows),
            "scratch": searched(target, case, ENOUGH * oracle[name]) if name == CHAIN[-1] else {},
        }
    return said


def beside(chain: Sequence[Body], found: Relayed, end: int, *, seed: int) -> dict[str, Array]:
    """Return feedback of a body of a chain by a hop from the first, and by wrong maps."""
    target, count = chain[end], found.hops[end - 1].samples
    source, gain = chain[0], plain(read(chain[0]), chain[0])
    maps = [hop.map for hop in found.hops[:end]]
    gains = {"composed": composed(gain, maps, chain[1 : end + 1])}
    # The hop of the relay had this seed: all see the same transitions.
    own = seed + 1000 * (end - 1)
    gains["direct"] = carry(source, target, count, seed=own)[0].gain
    if end > 1:
        source = as_believed(chain[end - 1], found.beliefs[end - 2].step)
        gain = found.hops[end - 2].gain
    order = tuple(np.roll(np.arange(len(target.bounds[0])), 2).tolist())
    wrong: dict[str, Callable[[AffineMap], AffineMap]]
    wrong = {"flipped": flipped, "shuffled": Shuffled(order)}
    for name, spoil in wrong.items():
        hop, _ = carry(source, target, count, seed=own, source_gain=gain, spoil=spoil)
        seen_as = hop.map
        assert isinstance(seen_as, AffineMap)
        gains[name] = hop.gain
        gains[f"{name}_map_only"] = through_map(seen_as, gain, target)
    return gains


def searched(target: Body, case: Case, enough: float) -> JSON:
    """Return the transitions that learning from nothing took, by the size of its moves."""
    said = {}
    for size in SIZES[:1] if case.quick else SIZES:
        spent, solved = scratch(
            target, size=size, generations=1 if case.quick else GENERATIONS, enough=enough,
            seed=case.seed,
        )  # fmt: skip
        said[str(size)] = {"spent": spent, "solved": solved}
    return said


@dataclass(frozen=True)
class Shuffled:
    """Makes a map one with the target's commands in another order."""

    order: tuple[int, ...]
    """Which command takes whose place."""

    def __call__(self, right: AffineMap) -> AffineMap:
        """Return the wrong map."""
        order = list(self.order)
        return replace(
            right,
            action_law=right.action_law[order],
            action_state=right.action_state[order],
            read_law=right.read_law[:, order],
        )


def composed(gain: Array, maps: Sequence[object], bodies: Sequence[Body]) -> Array:
    """Return the first body's feedback through all maps, made anew nowhere."""
    for each, body in zip(maps, bodies, strict=True):
        assert isinstance(each, AffineMap)
        gain = through_map(each, gain, body)
    return gain


def curves(target: Body, case: Case, rows: int) -> JSON:
    """Return the scores of what fits the target alone, by its name and the transitions."""
    grid = GRID[2:3] if case.quick else GRID
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


def main(argv: Sequence[str] | None = None) -> int:
    """Run the study."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.chains", description=__doc__, epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    parser.add_argument("--seeds", type=seeds_of, default=range(10), metavar="A:B")
    parser.add_argument("--without-real", action="store_true", help="leave out the real Poppy")
    parser.add_argument(
        "--noise", type=float, default=0.001, help="deviation of every reading (default: 0.001)"
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures")
    parser.add_argument("--quick", action="store_true", help="one seed, a short chain, no Poppy")
    add_engine_options(parser, out="out/chains")
    told, save = parse_and_save(parser, argv, module="experiments.chains")
    seeds = told.seeds[:1] if told.quick else told.seeds
    robots = ""
    if not (told.without_real or told.quick):
        try:
            robots = str(need_robots("poppy_humanoid"))
        except MorphError as error:
            print(f"error: {error}", file=sys.stderr)
            return 2
    cases = [Case(seed=seed, robots=robots, noise=told.noise, quick=told.quick) for seed in seeds]
    figures = summary(rows_of(cells_of(work, cases), told, name="chains"))
    if save:
        controls = {name: end["controls"] for name, end in figures["ends"].items()}
        save(figures=flat(figures), controls=controls, seeds=seeds)
    text = json.dumps(figures, indent=1)
    print(text)
    if told.json is not None:
        write_whole(told.json, text + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
