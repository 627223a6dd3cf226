"""Solvers: `morph.diagnose` and the baselines, each from a case's folder to an answer."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from experiments.concealed.baselines import (
    refit_own_figures,
    solve_by_inverse_dynamics,
    solve_by_lasso,
    solve_by_residual,
    solve_by_sindy,
    solve_by_sysid,
)
from experiments.concealed.errors import BenchmarkError
from experiments.concealed.predict import predicted
from experiments.concealed.seal import open_seal
from experiments.concealed.submission import JSON, submission
from experiments.concealed.suites import LAWS
from experiments.openloop import from_mjcf
from morph.body.load import load as load_robot
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.errors import DiagnosisError
from morph.inference.diagnose import diagnose
from morph.inference.rank import ranked
from morph.model.episodes import episode, step_for
from morph.model.hypothesis import Hypothesis
from morph.model.nuisance_parameters import knobs
from morph.physics.fluid.thrust import Thrust
from morph.record.load import load_recordings

Solver = Callable[[Path, int], JSON]


def solve_by_morph(folder: Path, seed: int) -> JSON:
    """Return the answer of `morph.diagnose`; a case that it refuses is answered `unknown`."""
    begin = time.process_time()
    known = json.loads((folder / "case.json").read_text())
    robot = load_robot(str(folder / known["description"]))
    recordings = load_recordings(folder / "recordings", robot=robot)
    told = paddle(robot, known["water"]) if known["water"] else ()
    try:
        found = diagnose(robot, recordings, vary=known["vary"], known=told, seed=seed)
        said = found.as_json()
    except DiagnosisError:
        return submission(known["name"], "morph", seconds=time.process_time() - begin, unknown=1.0)
    findings = [
        {
            "effect": finding["effect"],
            "where": finding["where"]["name"],
            "probability": float(finding["probability"]),
            "parameters": {
                name: {k: float(stated[k]) for k in ("value", "low90", "high90")}
                for name, stated in finding["parameters"].items()
            },
            **({"run": finding["episodes"][0]} if finding["interval_s"] else {}),
        }
        for finding in said["findings"]
    ]
    changes = [
        {
            "effect": change["effect"],
            "where": change["where"]["name"],
            "run": change["episode"],
            "time": float(change["time_s"]),
        }
        for change in said["changes"]
    ]
    named = {(finding["effect"], finding["where"]) for finding in findings}
    rivals = [
        {"effect": effect, "where": where, "probability": float(probability)}
        for label, probability in said["probabilities"].items()
        for effect, at, where in [label.partition("@")]
        if at and (effect, where) not in named
    ]
    return submission(
        known["name"], "morph", seconds=time.process_time() - begin, findings=findings,
        rivals=rivals, changes=changes, none=float(said["probabilities"].get("none", 0.0)),
        unknown=float(said["probabilities"].get("unknown", 0.0)),
        predicted=predicted(folder, from_mjcf(found.corrected), found.corrected_effects),
    )  # fmt: skip


def solve_by_ranking(folder: Path, seed: int) -> JSON:
    """Return what `morph.inference` ranks first, without intervals and held-out check."""
    begin = time.process_time()
    known = json.loads((folder / "case.json").read_text())
    robot = load_robot(str(folder / known["description"]))
    recordings = load_recordings(folder / "recordings", robot=robot)
    step = step_for(recordings, robot)
    nominal = Hypothesis(robot=robot, step=step, knobs=knobs(robot, known["vary"]))
    told = paddle(robot, known["water"]) if known["water"] else ()
    found = ranked(nominal, [episode(each, robot, step) for each in recordings], told)
    sets = [found.best, *(each for each in found.tried if each is not found.best)]
    # Sets of effects by their evidence, no effect among them, all alike before.
    weights = np.exp([min(0.0, each.evidence - sets[0].evidence) for each in sets])
    weights /= weights.sum()
    share: dict[tuple[str, str], float] = {}
    for each, weight in zip(sets, weights, strict=True):
        for effect in each.effects:
            key = effect.name, effect.where
            share[key] = share.get(key, 0.0) + float(weight)
    named = {(effect.name, effect.where) for effect in sets[0].effects}
    ordered = sorted(share, key=lambda key: -share[key])
    listed = [
        {"effect": effect, "where": where, "probability": min(1.0, share[effect, where])}
        for effect, where in ordered
    ]
    none = sum(float(w) for w, each in zip(weights, sets, strict=True) if not each.effects)
    return submission(
        known["name"], "linear", seconds=time.process_time() - begin,
        findings=[each for each in listed if (each["effect"], each["where"]) in named],
        rivals=[each for each in listed if (each["effect"], each["where"]) not in named][:5],
        none=min(1.0, none),
    )  # fmt: skip


def paddle(robot: Robot, water: JSON) -> tuple[Thrust, ...]:
    """Return the thrust of the paddle that a case names, of no strength yet.

    Its trailing edge, which no case tells, is taken to lie on the ray from the joint through the
    link's centre of mass, twice as far out.
    """
    model = spec_of(robot).compile()
    body = model.body(water["paddle"]["link"])
    middle, axis = 2.0 * body.ipos, model.jnt_axis[body.jntadr[0]]
    normal = np.cross(axis, middle)
    length = float(np.linalg.norm(normal))
    if length < 1e-9:
        return ()
    return (
        Thrust(
            body=body.name, density=water["density"], span=water["paddle"]["height_m"],
            **dict(zip(("x", "y", "z"), middle.tolist(), strict=True)),
            **dict(zip(("nx", "ny", "nz"), (normal / length).tolist(), strict=True)),
        ),
    )  # fmt: skip


def solve_by_chance(folder: Path, seed: int) -> JSON:
    """Return an answer drawn at random: one to three laws at random parts, or none, or unknown."""
    known = json.loads((folder / "case.json").read_text())
    rng = np.random.default_rng([seed, *known["name"].encode()])
    root = ElementTree.parse(folder / known["description"]).getroot()
    parts = {
        "joint": [str(each.get("name")) for each in root.iter("joint")],
        "actuator": [str(each.get("name")) for each in root.iterfind("actuator/*")],
        "sensor": [f"{each.get('name')}.position" for each in root.iter("joint")],
        "body": [str(each.get("name")) for each in root.iter("body")],
        "world": ["world"],
    }
    kind = int(rng.choice([-1, 0, 1, 2, 3], p=[0.15, 0.1, 0.45, 0.2, 0.1]))
    findings = []
    for number in rng.permutation(len(LAWS))[: max(kind, 0)]:
        law = LAWS[int(number)]
        findings.append(
            {"effect": law.name, "where": str(rng.choice(parts[law.kind])), "probability": 0.5}
        )
    return submission(
        known["name"], "random", findings=findings, none=float(kind == 0), unknown=float(kind < 0)
    )


def solve_by_trust(folder: Path, seed: int) -> JSON:
    """Return the answer that nothing is ever missing."""
    return submission(folder.name, "none", none=1.0)


def solve_by_oracle(folder: Path, seed: int) -> JSON:
    """Return the truth itself: the bound of what can be scored."""
    sealed = open_seal(folder)
    truth = sealed.about
    inside = truth["answer"] == "effects"
    findings = [
        {
            "effect": effect["effect"],
            "where": effect["where"]["name"],
            "probability": 1.0,
            "parameters": {
                name: dict.fromkeys(("value", "low90", "high90"), effect["figures"][name])
                for name in effect["scored"]
            },
        }
        for effect in truth["effects"]
    ]
    joints = [name for name in truth["parts"] if name.endswith(".position")]
    predicted = {
        name: [None if np.isnan(x) else float(x) for x in sealed.oracle[:, i]]
        for i, name in enumerate(joints)
    }
    return submission(
        truth["case"], "oracle", findings=findings if inside else [], predicted=predicted,
        none=float(truth["answer"] == "none"), unknown=float(truth["answer"] == "unknown"),
    )  # fmt: skip


SOLVERS: Mapping[str, Solver] = {
    "morph": solve_by_morph,
    "linear": solve_by_ranking,
    "refit": refit_own_figures,
    "lasso": solve_by_lasso,
    "sindy": solve_by_sindy,
    "gp": solve_by_residual,
    "sysid": solve_by_sysid,
    "idim": solve_by_inverse_dynamics,
    "random": solve_by_chance,
    "none": solve_by_trust,
    "oracle": solve_by_oracle,
}
"""Solvers by name."""


def solver_of(name: str) -> Solver:
    """Return a solver by its name.

    Raises:
        BenchmarkError: There is none of that name.
    """
    if name not in SOLVERS:
        raise BenchmarkError(
            f"there is no solver {name!r}", where="--solver", fix=f"choose among {list(SOLVERS)}"
        )
    return SOLVERS[name]
