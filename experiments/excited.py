"""How often a law is named after a planned experiment, beside the power that was predicted.

Each case draws a robot of the shelf, a law with a twin at one of its parts and a sensor's noise,
and plans the experiment that tells the two apart. One of the two then acts on a robot that is
simulated at a fifth of the planner's step and read twice with that noise, and a diagnosis says what
acts. The control is the strongest quick motion of the same length: what one records without a plan.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from experiments.engine_options import add_engine_options, rows_of, seeds_of
from experiments.figures.save_options import Save, parse_and_save
from morph.arrays import JSON
from morph.body.load import load
from morph.body.robot import Robot
from morph.experiment_design.excitation import excitations
from morph.experiment_design.plan import plan
from morph.experiment_design.separation import POWER, PlannedRun
from morph.inference.diagnose import diagnose
from morph.physics import EFFECTS
from morph.physics.effect import Effect
from morph.record.recording import Channel, Recording
from morph.sim.simulator import Simulator
from morph.study.cell import cells_of

EXAMPLE = """example:
  python -m experiments.excited --seeds 0:4 --save-as out/excited.json"""

ROBOTS = (
    "pendulum",
    "cartpole",
    "double_pendulum",
    "double_pendulum_a0",
    "cart_two_links",
    "so101",
)
KINDS = {"joint", "actuator"}
"""Kinds of parts whose laws are drawn."""
LEAST, MOST = 3e-4, 3e-2
"""Standard deviation of readings, rad or m, drawn log-uniformly."""
STEP, RATE = 0.0004, 100.0
"""Seconds a step of the robot, and its readings a second."""
LONGEST = 10.0
"""Seconds that a run may last."""


def drawn(seed: int) -> tuple[Robot, Effect, Effect, float]:
    """Return a robot, a law, a twin of it at the same part, and a sensor's noise."""
    rng = np.random.default_rng([11, seed])
    robot = load(str(rng.choice(ROBOTS)))
    names = {kind.name: kind for kind in EFFECTS if kind.kind in KINDS}
    pairs = [
        (kind.at(place), names[twin].at(place))
        for kind in names.values()
        for twin in kind.twins
        if twin in names and twin != kind.simpler and names[twin].simpler != kind.name
        for place in kind.places(robot)
        if place in names[twin].places(robot)
    ]
    law, rival = pairs[int(rng.integers(len(pairs)))]
    noise = float(np.exp(rng.uniform(np.log(LEAST), np.log(MOST))))
    return robot, law, rival, noise


def case(seed: int) -> JSON:
    """Return what was predicted and what was named in one case."""
    robot, law, rival, noise = drawn(seed)
    found = plan(robot, (law, rival), seconds=LONGEST, rate=RATE, noise=noise, seed=seed)
    rng = np.random.default_rng([12, seed])
    acts = found.separations[int(rng.integers(2))]
    kinds = {each.label: each for each in (law, rival)}
    true = replace(kinds[acts.law], **acts.size)  # type: ignore[type-var]
    (planned,) = found.runs
    every = excitations(robot, LONGEST, 0.002, seed)
    # The strongest of a kind comes first; of some robots a quick motion is not safe.
    quick = next((each for each in every if each.kind == "quick"), every[0])
    usual = PlannedRun(excitation=quick, seconds=planned.seconds)
    return {
        "seed": seed,
        "robot": robot.name,
        "law": acts.law,
        "rival": acts.rival,
        "noise": noise,
        "kind": planned.excitation.kind,
        "seconds": planned.seconds,
        "power": acts.power,
        "named": named(robot, planned, true, noise, rng),
        "named_without_plan": named(robot, usual, true, noise, rng),
    }


def named(
    robot: Robot, run: PlannedRun, true: Effect, noise: float, rng: np.random.Generator
) -> list[str]:
    """Return the labels that a diagnosis finds after two recordings of a run."""
    readings = [_recorded(robot, run, true, noise, rng, f"take_{at}") for at in range(2)]
    found = diagnose(robot, readings, horizon=0.5)
    return [finding.effect.label for finding in found.findings]


def _recorded(
    robot: Robot, run: PlannedRun, true: Effect, noise: float, rng: np.random.Generator, name: str
) -> Recording:
    told = run.inputs.channels
    made = Simulator(robot, effects=(true,), step=STEP).run(
        seconds=run.seconds,
        command={each.name: told[f"{each.name}.command"] for each in robot.actuators},
    )
    channels = {}
    for channel, each in made.channels.items():
        if each.hold:
            channels[channel] = each
        elif channel.endswith(".position"):
            every = slice(None, None, round(1.0 / (RATE * STEP)))
            value = each.value[every] + rng.normal(0.0, noise, len(each.value[every]))
            channels[channel] = Channel(time=each.time[every], value=value)
    return replace(made, channels=channels, name=name)


def summary(rows: Sequence[JSON]) -> JSON:
    """Return the share of cases that were named and told apart, by what was predicted.

    Told apart is a law of which something is found at its part, and not the rival there.
    """
    power = np.array([row["power"] for row in rows])
    sure, unsure = power >= POWER, power < 0.5
    found: JSON = {
        "cases": len(rows),
        "predicted": float(power.mean()),
        "sure": int(sure.sum()),
        "unsure": int(unsure.sum()),
        "seconds": float(np.median([row["seconds"] for row in rows])),
    }
    for way in ("named", "named_without_plan"):
        named = np.array([row["law"] in row[way] for row in rows])
        told = np.array([_told_apart(row, row[way]) for row in rows])
        found |= {
            way: float(named.mean()),
            way.replace("named", "told"): float(told.mean()),
            f"{way.replace('named', 'told')}_of_sure": _mean(told[sure]),
            f"{way.replace('named', 'told')}_of_unsure": _mean(told[unsure]),
        }
    return found


def _told_apart(row: JSON, labels: Sequence[str]) -> bool:
    place = row["law"].partition("@")[2]
    here = [label for label in labels if label.partition("@")[2] == place]
    return bool(here) and row["rival"] not in here


def _mean(values: np.ndarray) -> float | None:
    return float(values.mean()) if len(values) else None


def main(argv: list[str] | None = None) -> int:
    """Run the study."""
    told, save = _told(argv)
    seeds = seeds_of(told.seeds)
    rows = rows_of(cells_of(case, [{"seed": seed} for seed in seeds]), told, name="excited")
    failed = [row for row in rows if "why" in row]
    rows = [row for row in rows if "why" not in row]
    found = {**summary(rows), "refused": len(failed)}
    if save:
        ends = ("told", "named")
        usual = {name: found[f"{name}_without_plan"] for name in ends}
        save(figures=found, controls={"quick motion": usual}, rows=rows, seeds=seeds)
    print(json.dumps(found, indent=1))
    return 0


def _told(argv: list[str] | None) -> tuple[argparse.Namespace, Save]:
    parser = argparse.ArgumentParser(
        prog="python -m experiments.excited",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--seeds", default="100:140", help="A:B, or how many from 0")
    add_engine_options(parser, out="out/excited")
    return parse_and_save(parser, argv, module="experiments.excited")


if __name__ == "__main__":
    raise SystemExit(main())
