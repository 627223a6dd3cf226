"""Every body that is here, simulated with one law left out of its description, and diagnosed.

The bodies are those of the shelf, the robots that others published, each by one description, and
robots drawn from a corpus of URDFs. A law is drawn among all that can act on a body, at one of its
places and at a size drawn log-uniformly. Joints that a motor drives are led along sines by a PD
controller, servos are told the sines, others get them as efforts; the commands are logged, and
the joints' positions and the poses of floating links read with noise. Clean cases have no law.
Controls: the law and the place drawn at random among those that can act.
"""

from __future__ import annotations

import argparse
import json
import time
import zlib
from collections.abc import Sequence
from typing import Any

import numpy as np

from experiments.bodies_driven import NOISE, PERIOD, STEP, loaded, moved_along_sines, read
from experiments.engine_options import add_engine_options, rows_of, seeds_of
from experiments.figures.save_options import Save, parse_and_save
from experiments.needs import need_robots
from morph.arrays import JSON, Array
from morph.body import shelf
from morph.body.robot import Robot
from morph.errors import MorphError, SimulationFailed
from morph.experiment_design.effect_size import at_share
from morph.experiment_design.plan import expected_motion, laws_information, separations_of
from morph.experiment_design.separation import DECIDED
from morph.inference.diagnose import diagnose
from morph.inference.observed import Observed
from morph.model.episodes import step_for
from morph.model.hypothesis import Hypothesis
from morph.model.nuisance_parameters import knobs
from morph.physics import EFFECTS
from morph.physics.effect import Effect
from morph.record.recording import Recording
from morph.sim.closed_loop import closed_loop
from morph.sim.simulator import Simulator, Trajectory
from morph.study.cell import cells_of

EXAMPLE = """examples:
  python -m experiments.bodies --seeds 1 --only pendulum so101 --save-as out/bodies.json
  python -m experiments.bodies --seeds 100:102 --corpus 10 --resume"""

PUBLISHED = (
    "aqua/aqua_description/urdf/aqua.urdf",
    "erd_bolt/robots/bolt.urdf",
    "erd_double_pendulum/urdf/double_pendulum.urdf",
    "erd_simple_humanoid/urdf/simple_humanoid.urdf",
    "open_duck_mini_v2/mjcf/open_duck_mini_v2.xml",
    "poppy_humanoid/robots/Poppy_Humanoid.URDF",
    "poppy_torso/robots/Poppy_Torso.URDF",
    "sigmaban/robot.urdf",
    "solo/resources/solo8.urdf",
    "solo/resources/solo12.urdf",
    "urma_hexapod/hexapod.xml",
    "urma_sea_snake/sea_snake.xml",
)
"""Below the folder of published robots: one description of each."""
CORPUS = "urdf_corpus"
"""Folder of descriptions of which some are drawn."""
LEAST, MOST = 0.1, 0.6
"""Size of a law: its force over the force of the joint's drives or the inertial one, RMS."""
BUDGET = 600.0
"""Seconds that a diagnosis is given."""
RUNS = 3
"""Runs of a case."""
DRAWS = 40
"""Laws that are drawn until one acts."""
SURE = 0.5
"""Probability of `unknown` above which it is part of the answer."""
SHOWN, WINDOW = 3.0, round(0.5 / PERIOD)
"""Least change of the readings over their noise by a law that is drawn, RMS, and after how many
commands."""


def bodies(corpus: int, seed: int, joints: int) -> list[str]:
    """Return the names of the shelf, and paths below the folder of published robots.

    Args:
        corpus: How many of the corpus of descriptions are drawn.
        seed: Random seed of the draw.
        joints: Most joints of a body.
    """
    root = need_robots()
    found = [*shelf.names(), *PUBLISHED]
    there = sorted(each.name for each in (root / CORPUS).glob("*.urdf"))
    order = np.random.default_rng([21, seed]).permutation(len(there))
    found += [f"{CORPUS}/{there[at]}" for at in order[:corpus]]
    return [body for body in found if len(loaded(body).joints) <= joints]


def case(body: str, seed: int, *, clean: bool) -> JSON:
    """Return what is hidden in one body and what is found."""
    rng = np.random.default_rng([21, seed, zlib.crc32(body.encode()), int(clean)])
    robot = loaded(body)
    hidden, share = (None, 0.0) if clean else _drawn(robot, rng)
    effects = () if hidden is None else (hidden,)
    runs = [_recorded(robot, effects, rng, f"take_{at}") for at in range(RUNS)]
    row: JSON = {
        "body": body,
        "seed": seed,
        "joints": len(robot.joints),
        "hidden": "" if hidden is None else hidden.label,
        "size": {} if hidden is None else {k.name: getattr(hidden, k.name) for k in hidden.free()},
        "share": share,
        "random": _at_random(robot, rng).label,
    }
    began = time.process_time()
    try:
        found = diagnose(robot, runs, budget=BUDGET)
    except MorphError as error:
        return {**row, "refused": error.what, "found": [], "rivals": [], "unknown": 0.0}
    names = [finding.effect.label for finding in found.findings]
    rivals = [
        f"{rival.effect}@{rival.where}" for each in found.findings[:1] for rival in each.rivals
    ]
    return {
        **row,
        "found": names,
        "probability": [finding.probability for finding in found.findings],
        "rivals": rivals,
        "unknown": found.unexplained.probability,
        "stopped_short": found.stopped_short,
        "cpu_seconds": time.process_time() - began,
    }


def _drawn(robot: Robot, rng: np.random.Generator) -> tuple[Effect, float]:
    """Return a law that shows on a robot, and its share of the force there."""
    clean = moved_along_sines(robot, (), np.random.default_rng(rng.integers(2**32)))
    recording = read(robot, (), clean, rng, "clean")
    step = step_for([recording], robot)
    nominal = Hypothesis(robot=robot, step=step, knobs=knobs(robot, None))
    seen = expected_motion(nominal, recording, NOISE)
    for _ in range(DRAWS):
        law, share = _at_random(robot, rng), float(np.exp(rng.uniform(*np.log([LEAST, MOST]))))
        shapes = law.shapes(seen.motion) or (law,)
        law = shapes[int(rng.integers(len(shapes)))]
        try:
            law = at_share(law, seen, share)
            if law.coefficients.any() and _shows(robot, law, clean) and _told(nominal, law, seen):
                return law, share
        except MorphError:
            continue  # Out of bounds there, or the simulation diverges.
    raise SimulationFailed(
        f"none of {DRAWS} laws shows", where=f"robot {robot.name}", fix="draw another seed"
    )


def _told(nominal: Hypothesis, law: Effect, seen: Observed) -> bool:
    """Return whether masses, gains and the like, refitted, do not explain what a law does."""
    whole = laws_information(nominal, [(law,)], seen)[-1]
    (found,) = separations_of(whole, [(law,)], [(0, None)])
    return found.nats > DECIDED


def _at_random(robot: Robot, rng: np.random.Generator) -> Effect:
    """Return a law of the robot itself at one of its places, neutral."""
    wet = robot.card is not None and robot.card.water is not None
    kinds = [
        kind
        for kind in EFFECTS
        if kind.strengths
        and kind.kind in {"joint", "actuator", "sensor", "body"}
        and not kind.of_a_run
        and kind.name != "tether"
        and (wet or not kind.__module__.startswith("morph.physics.fluid"))
        and kind.places(robot)
    ]
    kind = kinds[int(rng.integers(len(kinds)))]
    # Velocities are not read.
    places = [name for name in kind.places(robot) if not name.endswith(".velocity")]
    return kind.at(places[0 if kind.everywhere else int(rng.integers(len(places)))])


def _shows(robot: Robot, law: Effect, clean: Trajectory) -> bool:
    """Return whether a law changes what is read half a second after starts of a clean motion."""
    if law.kind == "sensor":
        return True
    told = np.stack([clean.command[each.name] for each in robot.actuators], axis=1)
    ends = []
    for effects in ((), (law,)):
        simulator = Simulator(robot, effects=effects, step=STEP)
        every = np.arange(0, len(clean.time) - WINDOW - 1, WINDOW)
        start = clean.position[every], clean.velocity[every]

        def act(q: Array, v: Array, t: float, first: Any = every) -> Any:
            return told[first + round(t / PERIOD)]

        loop = closed_loop(simulator, act, *start, period=PERIOD, seconds=WINDOW * PERIOD)
        ends.append(loop.position[:, -1])
    return bool(np.sqrt(np.mean(np.max((ends[1] - ends[0]) ** 2, axis=1))) > SHOWN * NOISE)


def _recorded(
    robot: Robot, effects: tuple[Effect, ...], rng: np.random.Generator, name: str
) -> Recording:
    return read(robot, effects, moved_along_sines(robot, effects, rng), rng, name)


def summary(rows: Sequence[JSON]) -> JSON:
    """Return shares of bodies that can be diagnosed, of laws that are named, of clean ones accused.

    Place asks whether the first finding is at the part of the law that is hidden.
    """
    laws = [row for row in rows if row["hidden"] and "refused" not in row]
    clean = [row for row in rows if not row["hidden"] and "refused" not in row]
    firsts = [(row["found"] + [""])[0] for row in laws]
    return {
        "cases": len(rows),
        "bodies": len({row["body"] for row in rows}),
        "diagnosed": 1.0 - sum("refused" in row for row in rows) / max(1, len(rows)),
        "laws": len(laws),
        "first": _mean([a == row["hidden"] for a, row in zip(firsts, laws, strict=True)]),
        "first_three": _mean(
            [row["hidden"] in [*row["found"], *row["rivals"]][:3] for row in laws]
        ),
        "place": _mean(
            [_place(a) == _place(row["hidden"]) for a, row in zip(firsts, laws, strict=True)]
        ),
        "unknown": _mean([row["unknown"] > SURE for row in laws]),
        "clean": len(clean),
        "accused": sum(bool(row["found"]) or row["unknown"] > SURE for row in clean),
        "cpu_seconds": float(np.median([row.get("cpu_seconds", 0.0) for row in rows] or [0.0])),
        "cpu_seconds_most": max((row.get("cpu_seconds", 0.0) for row in rows), default=0.0),
    }


def _place(label: str) -> str:
    return label.partition("@")[2]


def _mean(values: Sequence[bool]) -> float | None:
    return float(np.mean(values)) if values else None


def main(argv: list[str] | None = None) -> int:
    """Run the study."""
    told, save = _asked(argv)
    seeds = seeds_of(told.seeds)
    cases = [
        {"body": body, "seed": seed, "clean": clean}
        for seed in seeds
        for body in told.only or bodies(told.corpus, seed, told.joints)
        for clean in (False, True)
    ]
    rows = rows_of(cells_of(case, cases), told, name="bodies")
    failed = [
        {**one, "why": row["why"]} for one, row in zip(cases, rows, strict=True) if "why" in row
    ]
    rows = [row for row in rows if "why" not in row]
    found = {**summary(rows), "not_simulated": len(failed)}
    at_random = [{**row, "found": [row["random"]], "rivals": []} for row in rows if row["hidden"]]
    if save:
        save(
            figures=found,
            controls={"drawn at random": summary(at_random)},
            rows=[*rows, *failed],
            seeds=seeds,
        )
    for each in failed:
        print(f"{each['body']}: not simulated: {each['why']}")
    print(json.dumps(found, indent=1))
    return 0


def _asked(argv: list[str] | None) -> tuple[argparse.Namespace, Save]:
    parser = argparse.ArgumentParser(
        prog="python -m experiments.bodies",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--seeds", default="101:102", help="A:B, or how many from 0")
    parser.add_argument("--only", nargs="+", help="bodies, instead of all")
    parser.add_argument("--corpus", type=int, default=10, help="robots drawn from the corpus")
    parser.add_argument("--joints", type=int, default=50, help="bodies of at most so many joints")
    add_engine_options(parser, out="out/bodies")
    return parse_and_save(parser, argv, module="experiments.bodies")


if __name__ == "__main__":
    raise SystemExit(main())
