"""Rankings of pendulums whose dynamics share nothing with MuJoCo or the effects."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest

from experiments.concealed.generate import generate
from experiments.concealed.seal import open_seal
from experiments.concealed.solvers import paddle, solve_by_ranking
from morph.body.load import load as load_robot
from morph.body.spec import spec_of
from morph.inference import rank
from morph.inference.dictionary import dictionary
from morph.inference.effect_selection import EffectSelection
from morph.inference.finalist import Finalist, labels
from morph.inference.observed import Observed, missing, observed
from morph.inference.rank import ranked
from morph.model.episodes import episode, step_for
from morph.model.hypothesis import Hypothesis
from morph.model.nuisance_parameters import knobs
from morph.physics.effect import Effect
from morph.physics.joint.armature import Armature
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.physics.joint.end_stop import EndStop
from morph.record.load import load_recordings
from morph.sim.simulator import compiled
from tests.morph.inference.dry_wheel import posed


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "cases"


def test_effects_see_the_motion_at_the_acceleration_of_the_model(folder: Path) -> None:
    (case,) = generate("clean", 1, [4], folder, seconds=2.0)
    robot = load_robot(str(case / "robot.xml"))
    (first, *_) = load_recordings(case / "recordings", robot=robot)
    step = step_for([first], robot)
    model = compiled(spec_of(robot, timestep=step), (), robot).model
    seen = observed(model, robot, episode(first, robot, step))
    data, at = mujoco.MjData(model), 100
    data.qpos[:], data.qvel[:] = seen.motion.position[at], seen.motion.velocity[at]
    data.ctrl[:] = seen.motion.command[at]
    mujoco.mj_forward(model, data)
    assert seen.motion.drive[at].sum(axis=0) == pytest.approx(data.qfrc_actuator, abs=1e-12)
    # Half a step after the velocity of the simulation, by the model's own acceleration.
    data.qvel[:] = seen.about.velocity[at] + 0.5 * step * seen.motion.acceleration[at]
    mujoco.mj_forward(model, data)
    # Derivatives are interpolated between every fourth sample, which costs about 1e-3.
    assert seen.motion.acceleration[at] == pytest.approx(data.qacc, rel=2e-3)


def test_a_paddle_whose_edge_is_known_is_looked_for(folder: Path) -> None:
    (case,) = generate("development", 1, [7], folder, seconds=1.0)
    robot = load_robot(str(case / "robot.xml"))
    (first, *_) = load_recordings(case / "recordings", robot=robot)
    step = step_for([first], robot)
    model = compiled(spec_of(robot, timestep=step), (), robot).model
    runs = [observed(model, robot, episode(first, robot, step))]
    water = json.loads((case / "case.json").read_text())["water"]
    (thrust,) = paddle(robot, water)
    assert thrust.edge().middle == pytest.approx(2.0 * model.body(thrust.body).ipos)

    def listed(known: Sequence[Effect]) -> list[Effect]:
        return [shapes[0] for shapes in dictionary(robot, runs, known)]

    # An edge that nobody knows gives no force; all else is looked for in both.
    assert {*listed([thrust])} - {*listed([])} == {thrust}


def test_nothing_is_found_where_nothing_is_missing(folder: Path) -> None:
    # Mass, centre, inertia and gain are wrong by 10, 5, 25 and 5 % at most.
    (case,) = generate("clean", 1, [4], folder, seconds=2.0)
    assert json.loads((case / "case.json").read_text())["vary"]["inertia"] == 0.25
    assert solve_by_ranking(case, 0)["findings"] == []


def test_backlash_stands_first(folder: Path) -> None:
    (case,) = generate("development", 1, [5], folder, seconds=2.0)
    (effect,) = open_seal(case).about["effects"]
    found = solve_by_ranking(case, 0)["findings"]
    assert (found[0]["effect"], found[0]["where"]) == (effect["effect"], effect["where"]["name"])


@pytest.mark.parametrize("refits", [0, 2])
def test_a_search_that_stops_early_is_about_what_it_found(
    folder: Path, monkeypatch: pytest.MonkeyPatch, refits: int
) -> None:
    (case,) = generate("development", 1, [1], folder, seconds=2.0)
    robot = load_robot(str(case / "robot.xml"))
    recordings = load_recordings(case / "recordings", robot=robot)
    step = step_for(recordings, robot)
    nominal = Hypothesis(robot=robot, step=step, knobs=knobs(robot, {}))
    made, real = [], EffectSelection.refitted

    def counted(task: EffectSelection, *given: Any, **named: Any) -> Finalist:
        made.append(given)
        return real(task, *given, **named)

    monkeypatch.setattr(EffectSelection, "refitted", counted)
    monkeypatch.setattr(EffectSelection, "late", lambda task: len(made) > refits)
    found = ranked(nominal, [episode(each, robot, step) for each in recordings])
    assert found.stopped
    # The whole dictionary but what was found, and nothing that was not.
    labels = {effect.label for effect in found.best.effects}
    assert {effect.label for effect in found.search.found} == labels
    assert bool(labels) == (refits > 1)


def test_a_ranking_goes_on_from_a_set_of_another_step(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    task = posed(tmp_path, 0.0)
    asked: list[float] = []

    def coarse(runs: Sequence[Observed]) -> bool:
        asked.append(missing(runs))
        return True

    first = ranked(task.nominal, task.episodes, coarse=coarse)
    assert asked == [missing(first.best.refit.runs)]
    assert first.best.effects
    assert not first.none.effects
    friction, wrong = CoulombFriction(joint="axle", c=0.05), Armature(joint="axle", J=1e-5)

    def begun(*effects: Effect) -> Finalist:
        hypothesis = replace(task.nominal, effects=effects)
        refit = replace(first.best.refit, hypothesis=hypothesis, point=hypothesis.start)
        return rank._begun(task, first.none, replace(first.best, refit=refit)).best

    (law,) = begun(friction).effects
    assert law.label == "coulomb_friction@axle"
    # A law that is not needed in the other step is left out before the search goes on.
    assert labels(begun(friction, wrong).effects) == {"coulomb_friction@axle"}
    # Nothing stays of a set that explains nothing.
    assert begun(wrong) is first.none

    def again(*_: object) -> None:
        raise AssertionError

    # However much the description alone lacks, it is not searched by rollouts again.
    for name in ("FAR", "FARTHEST"):
        monkeypatch.setattr(rank, name, 0.0)
    monkeypatch.setattr(rank, "_by_rollouts", again)
    found = ranked(task.nominal, task.episodes, start=first.best, coarse=lambda runs: True).best
    assert labels(found.effects) == labels(first.best.effects)
    with pytest.raises(AssertionError):
        ranked(task.nominal, task.episodes)


def test_dry_friction_is_no_hysteresis_of_less_than_readings_tell(tmp_path: Path) -> None:
    task = posed(tmp_path, 0.0)
    (found,) = ranked(task.nominal, task.episodes).best.effects
    assert isinstance(found, CoulombFriction)
    # The discs' motion tells friction to 0.1 %: 0.05 N m within a hundredth.
    assert found.c == pytest.approx(0.05, rel=0.01)


def test_a_stop_is_sought_at_other_depths(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rank, "gains", lambda one, new, validation: new.evidence > one.evidence)
    motion = SimpleNamespace(place=lambda joint: np.array([-0.2, 0.0, 0.5]))

    def refitted(law: EndStop) -> Any:
        # A likelihood with a narrow peak beside a broad one, as that of a stiff stop has.
        peak = 100.0 if abs(law.q_stop - 0.48) < 0.01 else -abs(law.q_stop - 0.3)
        refit = SimpleNamespace(runs=(SimpleNamespace(motion=motion),))
        return SimpleNamespace(effects=(law,), evidence=peak, refit=refit)

    task: Any = SimpleNamespace(
        late=lambda: False, validation=None, exchanged=lambda best, at, other: refitted(other)
    )
    best = refitted(EndStop(joint="axle", q_stop=0.3, k=40.0))
    found = rank.restarted(task, best)
    assert found.effects[0].q_stop == pytest.approx(0.48)
    assert found.effects[0].k == pytest.approx(400.0)
    task.late = lambda: True
    assert rank.restarted(task, best) is best
