"""Friction and gains by inverse dynamics, of a disc that is integrated by hand and often sticks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from morph.body.load import load
from morph.inference.columns import Columns
from morph.inference.dictionary import search_beside
from morph.inference.effect_selection import EffectSelection
from morph.inference.finalist import Finalist
from morph.inference.inverse_dynamics import (
    BAND,
    as_moved,
    force_levels,
    force_rows,
    likeliest_forces,
)
from morph.inference.observed import Observed
from morph.inference.rank import ranked
from morph.inference.refit import Refit, seen
from morph.inference.search import Prior
from morph.inference.validate import Validation
from morph.model.deadline import NEVER, Deadline
from morph.model.episodes import Episode
from morph.model.hypothesis import Hypothesis
from morph.model.nuisance_parameters import knobs
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.physics.joint.viscous_friction import ViscousFriction
from tests.morph.inference.dry_disc import INERTIA, STEP, pushed, pushes, turned

SAMPLES, NOISE, COULOMB, WRONG = 1500, 1e-4, 0.3, 1.3
MOTOR = f"""
<mujoco model="motor"><option gravity="0 0 0"/><worldbody><body name="disc">
  <joint name="axle" axis="0 0 1"/>
  <inertial pos="0 0 0" mass="1" diaginertia="{INERTIA} {INERTIA} {INERTIA}"/></body></worldbody>
  <actuator><motor name="motor" joint="axle" gear="{WRONG}"/></actuator></mujoco>
"""


def sticking(number: int) -> list[bool]:
    """Return whether the disc rests over the whole step that follows each command."""
    angle = np.array(turned(pushes(number, SAMPLES), lambda u, q, v: u, coulomb=COULOMB))
    return list(np.diff(angle, append=angle[-1]) == 0.0)


@pytest.fixture(scope="module")
def nominal(tmp_path_factory: pytest.TempPathFactory) -> Hypothesis:
    path = tmp_path_factory.mktemp("motor") / "motor.xml"
    path.write_text(MOTOR)
    trusted = {"mass": 0.0, "com": 0.0, "inertia": 0.0, "joint": 0.0, "gain": 0.5}
    robot = load(path)
    return Hypothesis(robot=robot, step=STEP, knobs=knobs(robot, trusted))


@pytest.fixture(scope="module")
def episodes(nominal: Hypothesis) -> list[Episode]:
    return pushed(nominal.robot, coulomb=COULOMB, samples=SAMPLES, noise=NOISE)


@pytest.fixture(scope="module")
def runs(nominal: Hypothesis, episodes: list[Episode]) -> list[Observed]:
    return seen(nominal, nominal.start, episodes)


@pytest.fixture
def task(nominal: Hypothesis, episodes: list[Episode]) -> EffectSelection:
    return EffectSelection(
        nominal=nominal, episodes=episodes, known=(), validation=Validation.of(episodes),
        prior=Prior(alone={}), deadline=NEVER, by_rollouts=True, by_forces=True,
    )  # fmt: skip


def test_a_motor_is_not_called_weak_where_friction_holds_it(
    nominal: Hypothesis, runs: list[Observed]
) -> None:
    start = replace(nominal, effects=(CoulombFriction(joint="axle", c=0.01),))
    found = likeliest_forces(start, start.start, runs)
    gain, friction = np.exp(found.point[0]) * WRONG, found.point[1]
    # Rows keep 0.1 s from where it sticks; a thirtieth of what the filter takes into one comes from
    # further off, as a step's response settles. With the rows at which it sticks the gain would be
    # 0.87, its bound, and the friction 0.25 N m.
    assert gain == pytest.approx(1.0, abs=0.05)
    assert friction == pytest.approx(COULOMB, rel=0.06)
    # It is a maximum: no step gains anything.
    _, _, gained = found.step()
    assert gained < 1.0


def test_rows_are_of_times_at_which_the_joint_slips(
    nominal: Hypothesis, runs: list[Observed]
) -> None:
    own, moved = Columns.of(nominal, nominal.start), as_moved(nominal, nominal.start, runs[0])
    rows = force_rows(own, moved, ())
    width = round(0.5 / BAND / STEP)
    assert rows.rows.shape == (len(rows.slips), 1, 2)
    rests = np.array(sticking(0))
    middle = width * (1 + np.arange(len(rows.slips)))
    held = [rests[at - width : at + width + 1].any() for at in middle]
    assert 0.2 < np.mean(held) < 0.9
    assert not rows.slips[held].any()
    # While it slips the model of too strong a motor lacks minus 0.3 times the command, and the
    # friction against the motion.
    slipping = rows.slips[:, 0] > 0.0
    assert slipping.sum() > 5
    error, column = rows.rows[slipping, 0].T
    assert np.corrcoef(error, column)[0, 1] < -0.9


def test_friction_is_what_forces_tell_first(nominal: Hypothesis, runs: list[Observed]) -> None:
    own = likeliest_forces(nominal, nominal.start, runs)
    base = Refit(hypothesis=nominal, point=own.point, runs=runs, evidence=0.0, rank=1)
    sets = search_beside(base, (), None, 1, by_forces=True).sets(1)
    (first,) = sets[0].effects
    assert first.name in {"coulomb_friction", "stribeck_friction", "load_dependent_friction"}
    (coulomb,) = next(each.effects for each in sets if each.effects[0].name == "coulomb_friction")
    assert isinstance(coulomb, CoulombFriction)
    assert coulomb.c == pytest.approx(COULOMB, rel=0.06)


def test_levels_share_rows_and_differ_in_scale(nominal: Hypothesis, runs: list[Observed]) -> None:
    own = Columns.of(nominal, nominal.start)
    grids = [(ViscousFriction(joint="axle", b=0.1),)]
    whole, tenth = force_levels(own, grids, runs, 2, (1.0, 0.1))
    assert len(whole) == len(tenth) == 2 * len(runs)
    for one, other in zip(whole, tenth, strict=True):
        np.testing.assert_allclose(other.gram, 100.0 * one.gram)
        shrunk = 2.0 * one.readings * np.log(0.1)
        assert other.logarithm - one.logarithm == pytest.approx(shrunk)
    # Errors are in units of their RMS: their squares add up to how many there are.
    square = sum(fold.gram[0, 0] for fold in whole)
    assert square == pytest.approx(sum(fold.readings for fold in whole))


def test_no_step_begins_after_the_deadline(nominal: Hypothesis, runs: list[Observed]) -> None:
    start = replace(nominal, effects=(CoulombFriction(joint="axle", c=0.01),))
    found = likeliest_forces(start, start.start, runs, deadline=Deadline(time=-1.0))
    assert found.point.tolist() == start.start.tolist()


@pytest.mark.parametrize(("force", "first"), [(0.9, False), (1.1, True)])
def test_where_motors_leave_more_than_the_inertial_force_forces_tell(
    task: EffectSelection, monkeypatch: pytest.MonkeyPatch, force: float, first: bool
) -> None:
    searched = []

    def added(
        self: EffectSelection, base: Finalist, *rest: object
    ) -> tuple[list[Finalist], object]:
        searched.append(self.by_rollouts and self.by_forces)
        return [], base

    monkeypatch.setattr(EffectSelection, "added", added)
    monkeypatch.setattr("morph.inference.rank.missing", lambda runs: force)
    monkeypatch.setattr("morph.inference.rank.at_noise", lambda runs: False)
    ranked(task.nominal, task.episodes)
    assert searched[0] == first
    assert searched[-1]


def test_the_likeliest_set_is_refitted_beside_each_law_of_friction(task: EffectSelection) -> None:
    none = task.refitted(task.nominal, task.nominal.start)
    search = task.search(none)
    first, _ = replace(task, prior=search.prior).proposals(search, search.sets(1), none)
    laws = {one.effects[0].name for one in first}
    assert {"coulomb_friction", "stribeck_friction", "load_dependent_friction"} <= laws


def test_friction_and_gain_are_named_by_forces_and_rollouts(task: EffectSelection) -> None:
    none = task.refitted(task.nominal, task.nominal.start)
    search = task.search(none)
    _, best = replace(task, prior=search.prior).added(none, search, 1)
    (effect,) = best.effects
    assert isinstance(effect, CoulombFriction)
    assert effect.c == pytest.approx(COULOMB, rel=0.06)
