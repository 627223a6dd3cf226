"""Output error: a servo that sticks, integrated by hand, whose gain the description has wrong."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from morph.body.load import load
from morph.inference.effect_selection import EffectSelection
from morph.inference.finalist import Finalist
from morph.inference.output_error import output_error
from morph.inference.rank import ranked
from morph.inference.search import Prior
from morph.inference.validate import Validation
from morph.model.deadline import NEVER, Deadline
from morph.model.episodes import episode
from morph.model.hypothesis import Hypothesis
from morph.model.nuisance_parameters import knobs
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.record.recording import Channel, Recording
from tests.morph.inference.dry_disc import INERTIA, STEP, turned

SAMPLES, NOISE = 750, 1e-3
GAIN, DAMPING, COULOMB, WRONG = 4.0, 0.2, 0.3, 1.3
SERVO = f"""
<mujoco model="servo"><option gravity="0 0 0"/><worldbody><body name="disc">
  <joint name="axle" axis="0 0 1" damping="{DAMPING}"/>
  <inertial pos="0 0 0" mass="1" diaginertia="{INERTIA} {INERTIA} {INERTIA}"/></body></worldbody>
  <actuator><position name="servo" joint="axle" kp="{WRONG * GAIN}"/></actuator></mujoco>
"""


@pytest.fixture(scope="module")
def task(tmp_path_factory: pytest.TempPathFactory) -> EffectSelection:
    """Return four runs of a servo that stands still for much of the time, to be explained."""
    path = tmp_path_factory.mktemp("servo") / "servo.xml"
    path.write_text(SERVO)
    robot, rng, runs = load(path), np.random.default_rng(0), []
    for number in range(4):
        time = STEP * np.arange(SAMPLES)
        goal = 0.25 * np.cos((1.0 + 0.3 * number) * time) + 0.05 * np.cos(7.0 * time)
        read = turned(
            goal.tolist(), lambda u, q, v: GAIN * (u - q) - DAMPING * v, coulomb=COULOMB, angle=0.25
        )
        channels = {
            "axle.position": Channel(time=time, value=read + NOISE * rng.normal(size=SAMPLES)),
            "servo.command": Channel(time=time, value=goal, hold=True),
        }
        runs.append(episode(Recording(name=f"run_{number}", channels=channels), robot, STEP))
    trusted = {"mass": 0.0, "com": 0.0, "inertia": 0.0, "joint": 0.0, "gain": 0.5}
    return EffectSelection(
        nominal=Hypothesis(robot=robot, step=STEP, knobs=knobs(robot, trusted)),
        episodes=runs, known=(), validation=Validation.of(runs), prior=Prior(alone={}),
        deadline=NEVER, by_rollouts=True,
    )  # fmt: skip


def test_rollouts_err_least_at_the_true_gain_and_friction(task: EffectSelection) -> None:
    start = replace(task.nominal, effects=(CoulombFriction(joint="axle", c=0.05),))
    found = output_error(start, start.start, task.validation)
    (gain,) = np.exp(found.point[: len(start.knobs)]) * WRONG
    # The simulation's step of 4 ms against one of 0.25 ms: friction acts half a step late, which
    # moves a force by its rate of 7 / s times 2 ms.
    assert gain == pytest.approx(1.0, abs=0.02)
    assert found.point[-1] == pytest.approx(COULOMB, rel=0.02)
    # At its least the log posterior has no slope, by folds that add up to it.
    step, _, gained = found.step()
    assert np.abs(step).max() < 1e-2
    assert gained < 1.0
    assert len(found.grams) == task.validation.folds
    whole = found.grams.sum(axis=0)
    assert whole == pytest.approx(whole.T)


def test_no_step_begins_after_the_deadline(task: EffectSelection) -> None:
    start = replace(task.nominal, effects=(CoulombFriction(joint="axle", c=0.05),))
    found = output_error(start, start.start, task.validation, Deadline(time=-1.0))
    assert found.point.tolist() == start.start.tolist()


def test_a_refit_by_rollouts_is_judged_by_its_stretches(task: EffectSelection) -> None:
    none = task.refitted(task.nominal, task.nominal.start)
    assert none.refit.evidence == pytest.approx(-none.losses.sum())
    ready = replace(task, prior=task.search(none).prior)
    tried, best = ready.added(none, task.search(none), 1)
    assert [effect.name for effect in best.effects] == ["coulomb_friction"]
    assert best.losses.sum() < none.losses.sum() - 1.0
    # Each law of friction was refitted, however little its evidence.
    names = {effect.name for each in tried for effect in each.effects}
    assert {"coulomb_friction", "load_dependent_friction", "stribeck_friction"} <= names


def test_where_the_missing_force_is_not_believed_rollouts_decide(
    task: EffectSelection, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("morph.inference.effect_selection.FAR", 0.0)
    made = []
    real = output_error

    def counted(*given: object) -> object:
        made.append(given)
        return real(*given)  # type: ignore[arg-type]

    monkeypatch.setattr("morph.inference.effect_selection.output_error", counted)
    found = ranked(task.nominal, task.episodes)
    assert made
    (effect,) = found.best.effects
    assert isinstance(effect, CoulombFriction)
    assert effect.c == pytest.approx(COULOMB, rel=0.02)


def test_a_fold_that_is_left_out_moves_the_point_as_a_refit_without_it(
    task: EffectSelection, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Both refits go on to their ends.
    monkeypatch.setattr("morph.inference.output_error.STEPS", 6)
    start = replace(task.nominal, effects=(CoulombFriction(joint="axle", c=0.05),))
    found = output_error(start, start.start, task.validation)
    assert task.validation.blocks == 1
    for fold in range(task.validation.folds):
        step, _, _ = found.without_fold(fold).step()
        others = [each for at, each in enumerate(task.episodes) if at != fold]
        rest = output_error(start, found.point, Validation.of(others))
        # Other runs have other sizes of errors, by a tenth or so.
        assert step == pytest.approx(rest.point - found.point, rel=0.25)


def test_where_a_refit_ends_short_of_the_least_error_its_slope_is_not_followed(
    task: EffectSelection, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("morph.inference.output_error.STEPS", 0)
    start = replace(task.nominal, effects=(CoulombFriction(joint="axle", c=0.8 * COULOMB),))
    found = output_error(start, start.start, task.validation)
    step, _, _ = found.step()
    assert step == pytest.approx(0.0, abs=1e-9)


def test_an_even_spread_of_stretches_is_fitted(
    task: EffectSelection, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("morph.inference.output_error.MOST_FITTED", 4)
    segments = task.validation.segments
    assert len(segments) > 4
    found = output_error(task.nominal, task.nominal.start, task.validation)
    assert found.readings == 4 * segments.reading.shape[2]
    # One of each run: every fold has its part of the second derivatives.
    assert (found.grams[:, 1, 1] > 0.0).all()


@pytest.mark.parametrize(("force", "first"), [(9.0, False), (11.0, True)])
def test_where_ten_times_the_force_is_missing_no_whitened_refit_is_tried(
    task: EffectSelection, monkeypatch: pytest.MonkeyPatch, force: float, first: bool
) -> None:
    searched = []

    def added(
        self: EffectSelection, base: Finalist, *rest: object
    ) -> tuple[list[Finalist], object]:
        searched.append(self.by_rollouts)
        return [], base

    monkeypatch.setattr(EffectSelection, "added", added)
    monkeypatch.setattr("morph.inference.rank.missing", lambda runs: force)
    monkeypatch.setattr("morph.inference.rank.at_noise", lambda runs: False)
    ranked(task.nominal, task.episodes)
    assert searched[0] == first
    assert searched[-1]
