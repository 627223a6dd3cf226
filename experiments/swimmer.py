"""The thesis' swimmer: it swims, turns and holds its depth by patterns, and walks on a floor.

Every row is one run of the same body, most with a control beside it: no stroke, no thrust, the
stroke run backward, no feedback, no friction. `--policies` writes the gaits as folders, and the
worlds beside them as files, that `morph simulate` takes.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path

from rich.console import Console
from rich.table import Table

from experiments.figures.save_options import parse_and_save
from experiments.swim.gaits import begun, row, straight, tripod
from experiments.swim.mean_thrust import of_aqua, of_theory
from experiments.swim.steer import Depth, attitude, steered
from experiments.swim.water import PADDLE, PADDLE_MIDDLE, aqua_water
from morph.arrays import JSON
from morph.body.load import load
from morph.body.robot import Robot
from morph.body.vary import Heavier, vary
from morph.errors import MorphError
from morph.files import write_whole
from morph.physics.contact.contact_friction import ContactFriction
from morph.physics.store import effects_text
from morph.physics.world.ground import Ground
from morph.policy.pattern import Pattern, pattern
from morph.policy.store import write_policy
from morph.record.recording import Recording
from morph.sim.simulator import Simulator

EXAMPLE = """example:
  python -m experiments.swimmer
  python -m experiments.swimmer --policies out/gaits
  morph simulate hexapod_swimmer --policy out/gaits/straight --effects out/gaits/water.toml"""

STEP = 0.002
"""Seconds a step."""

DROP = 0.2
"""Height from which the body is let fall on the floor, m."""

TOO_HEAVY = 0.1
"""Mass that is added to show that depth is held, kg: 0.98 N."""

STROKES = ((0.25, 2.0), (0.5, 1.0), (0.5, 2.0), (0.5, 3.0), (0.8, 2.0))
"""Amplitudes, rad, and frequencies, Hz, at which mean thrusts are told."""


@dataclass(frozen=True, kw_only=True)
class Row:
    """What one run came to."""

    world: str
    """`water`, `floor` and so on, as `Swimmer.worlds` has them."""
    gait: str
    """What the paddles did."""
    seconds: float
    """How long."""
    forward: float
    """Where the hull came to along x, m."""
    left: float
    """Along y, m."""
    up: float
    """Along z, from where it began, m."""
    deepest: float
    """Farthest below where it began, m."""
    yaw_deg: float
    """How far it turned to the left, degrees."""
    pitch_deg: float
    """Greatest pitch of the nose, up or down, degrees."""


@dataclass(frozen=True)
class Swimmer:
    """The body, and the worlds it is put into."""

    robot: Robot
    """The hexapod swimmer."""

    @cached_property
    def worlds(self) -> Mapping[str, Simulator]:
        """The simulators by the names of their worlds."""
        ground = Ground(height=0.0)
        effects = {
            "water": aqua_water(self.robot),
            "water without thrust": aqua_water(self.robot, thrust=0.0),
            "perfect fluid": aqua_water(self.robot, thrust=0.0, drag=False),
            "floor": (ground, ContactFriction(contact="any+floor", mu=0.8)),
            "floor without friction": (ground, ContactFriction(contact="any+floor", mu=0.0)),
        }
        worlds = {name: Simulator(self.robot, each, step=STEP) for name, each in effects.items()}
        heavy = vary(self.robot, Heavier(link="hull", add=TOO_HEAVY))
        return worlds | {"water, 100 g too heavy": Simulator(heavy, effects["water"], step=STEP)}

    def run(self, world: str, said: str, gait: Pattern, seconds: float) -> Row:
        """Return what a gait comes to in a world, begun where the gait begins."""
        start = dict(begun(gait, self.robot))
        if world.startswith("floor"):
            start["hull.position.z"] = DROP
        run = self.worlds[world].run(seconds=seconds, start=start, command=gait.commands())
        return summed(world, said, run)


def summed(world: str, said: str, run: Recording) -> Row:
    """Return what a run came to."""
    turned = attitude(run)
    x, y, z = (run[f"hull.position.{axis}"] for axis in "xyz")
    return Row(
        world=world,
        gait=said,
        seconds=round(run.seconds, 3),
        forward=float(x[-1] - x[0]),
        left=float(y[-1] - y[0]),
        up=float(z[-1] - z[0]),
        deepest=float((z - z[0]).min()),
        yaw_deg=math.degrees(turned[-1, 2] - turned[0, 2]),
        pitch_deg=math.degrees(abs(turned[:, 1]).max()),
    )


def gaits(robot: Robot) -> Mapping[str, Pattern]:
    """Return every gait by its name."""
    return {
        "rest": pattern(robot, {}),
        "straight": straight(robot),
        "straight_reversed": straight(robot, phase=math.pi),
        "left": straight(robot, left=0.5),
        "row": row(robot),
        "row_reversed": row(robot, sense=-1),
        "tripod": tripod(robot),
    }


def rows(swimmer: Swimmer, *, seconds: float = 8.0, told: Callable[[Row], None]) -> list[Row]:
    """Return every row of the study, each told as it comes.

    Args:
        swimmer: The body and its worlds.
        seconds: How long the open-loop runs last; those that hold a depth take 30 s.
        told: What to do with each row once it is there.
    """
    every = gaits(swimmer.robot)
    wanted = [
        ("water", "no stroke", "rest"),
        ("water, 100 g too heavy", "no stroke", "rest"),
        ("water", "symmetric stroke", "straight"),
        ("water", "the same reversed", "straight_reversed"),
        ("water without thrust", "symmetric stroke", "straight"),
        ("water without thrust", "the same reversed", "straight_reversed"),
        ("perfect fluid", "symmetric stroke", "straight"),
        ("water without thrust", "rowing, fast as it pushes", "row"),
        ("water without thrust", "the same reversed", "row_reversed"),
        ("water", "half the stroke on the left", "left"),
        ("floor", "tripod", "tripod"),
        ("floor", "symmetric stroke", "straight"),
        ("floor", "no step", "rest"),
        ("floor without friction", "tripod", "tripod"),
        ("water", "tripod", "tripod"),
    ]
    found = []
    for world, said, name in wanted:
        found.append(swimmer.run(world, said, every[name], seconds))
        told(found[-1])
    long = 30.0 * seconds / 8.0
    found.append(swimmer.run("water", "symmetric stroke, left alone", every["straight"], long))
    told(found[-1])
    for world, said, depth in (
        ("water", "depth held by leaning paddles", Depth()),
        ("water", "and 0.5 m deeper", Depth(height=-0.5)),
        ("water without thrust", "and 0.5 m deeper", Depth(height=-0.5)),
        ("water, 100 g too heavy", "depth held by leaning paddles", Depth()),
    ):
        found.append(summed(world, said, steered(swimmer.worlds[world], depth, long)))
        told(found[-1])
    return found


def headline(found: list[Row]) -> JSON:
    """Return what a result file holds: where each stroke came to, m, and what opposes it."""
    by = {(row.world, row.gait): row for row in found}
    figures = {
        "straight": by["water", "symmetric stroke"].forward,
        "straight_reversed": by["water", "the same reversed"].forward,
        "straight_without_thrust": by["water without thrust", "symmetric stroke"].forward,
        "rowing_without_thrust": by["water without thrust", "rowing, fast as it pushes"].forward,
        "turn_deg": by["water", "half the stroke on the left"].yaw_deg,
        "walk": by["floor", "tripod"].forward,
        "depth_error": abs(by["water", "depth held by leaning paddles"].up),
    }
    opposite = (
        ("water", "no stroke"),
        ("perfect fluid", "symmetric stroke"),
        ("floor without friction", "tripod"),
        ("floor", "symmetric stroke"),
        ("water", "symmetric stroke, left alone"),
    )
    controls = {f"{world}: {gait}": asdict(by[world, gait]) for world, gait in opposite}
    return {"figures": figures, "controls": controls, "rows": [asdict(row) for row in found]}


def main(arguments: list[str] | None = None) -> int:
    """Run the study and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.swimmer",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--seconds", type=float, default=8.0, help="of open-loop runs (default 8)")
    parser.add_argument("--json", action="store_true", help="print the rows as JSON")
    parser.add_argument("--policies", type=Path, help="only write the gaits, into this folder")
    asked, save = parse_and_save(parser, arguments, module="experiments.swimmer")
    try:
        swimmer = Swimmer(load("hexapod_swimmer"))
        if asked.policies:
            _write(swimmer, asked.policies)
            return 0
        found = _study(swimmer, asked.seconds, as_json=asked.json)
        if save:
            save(**headline(found))
    except MorphError as error:
        sys.stderr.write(f"error: {error}\n")
        return 2
    return 0


def _write(swimmer: Swimmer, folder: Path) -> None:
    for name, gait in gaits(swimmer.robot).items():
        print(write_policy(gait, folder / name, swimmer.robot, task=name))
    for name in ("water", "water without thrust", "floor"):
        world = swimmer.worlds[name]
        file = folder / f"{name.replace(' ', '_')}.toml"
        print(write_whole(file, effects_text(world.effects)))


def _study(swimmer: Swimmer, seconds: float, *, as_json: bool) -> list[Row]:
    progress, began = Console(stderr=True), time.monotonic()
    found = rows(
        swimmer,
        seconds=seconds,
        told=lambda each: progress.print(f"{each.world}: {each.gait}", style="dim"),
    )
    if as_json:
        print(json.dumps({"rows": [asdict(each) for each in found], "mean_thrust": _thrusts()}))
        return found
    table = Table(title="The hexapod swimmer", title_justify="left")
    names = ("s", "forward m", "left m", "up m", "deepest m", "yaw °", "pitch °")
    for name in ("world", "gait", *names):
        table.add_column(name, justify="left" if name in ("world", "gait") else "right")
    for each in found:
        numbers = (each.forward, each.left, each.up, each.deepest)
        turns = (each.yaw_deg, each.pitch_deg)
        table.add_row(
            each.world,
            each.gait,
            f"{each.seconds:g}",
            *(f"{value:.3f}" for value in numbers),
            *(f"{value:.1f}" for value in turns),
        )
    wide = Console(width=140)
    wide.print(table)
    table = Table(title="Mean thrust of one paddle, hull held, N", title_justify="left")
    for name in ("amplitude rad", "frequency Hz", "Lighthill", "formula in use for AQUA"):
        table.add_column(name, justify="right")
    for one in _thrusts():
        table.add_row(*(f"{value:.3g}" for value in one.values()))
    wide.print(table)
    print(f"{time.monotonic() - began:.0f} s")
    return found


def _thrusts() -> list[dict[str, float]]:
    length, width, _ = PADDLE
    reach = length / 2.0 - PADDLE_MIDDLE
    return [
        {
            "amplitude": amplitude,
            "frequency": frequency,
            "lighthill": of_theory(amplitude, frequency, reach=reach, span=width),
            "aqua": of_aqua(amplitude, frequency, length=length, widths=(width, width)),
        }
        for amplitude, frequency in STROKES
    ]


if __name__ == "__main__":
    sys.exit(main())
