"""Dry friction that a description states, on a disc that is integrated by hand and often sticks."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from morph.body.load import load
from morph.inference.columns import Columns
from morph.inference.observed import Observed, missing, settled
from morph.inference.rank import ranked
from morph.inference.refit import seen
from morph.model.episodes import Episode
from morph.model.hypothesis import Hypothesis
from morph.model.nuisance_parameters import knobs
from morph.physics.joint.coulomb_friction import CoulombFriction
from tests.morph.inference.dry_disc import INERTIA, STEP, pushed

SAMPLES, NOISE, COULOMB = 1500, 1e-4, 0.3
TRUSTED = {"mass": 0.0, "com": 0.0, "inertia": 0.0, "joint": 0.1, "gain": 0.1}


def disc(folder: Path, friction: float) -> Hypothesis:
    path = folder / f"motor_{friction}.xml"
    path.write_text(f"""
<mujoco model="motor"><option gravity="0 0 0"/><worldbody><body name="disc">
  <joint name="axle" axis="0 0 1" frictionloss="{friction}"/>
  <inertial pos="0 0 0" mass="1" diaginertia="{INERTIA} {INERTIA} {INERTIA}"/></body></worldbody>
  <actuator><motor name="motor" joint="axle"/></actuator></mujoco>
""")
    robot = load(path)
    return Hypothesis(robot=robot, step=STEP, knobs=knobs(robot, TRUSTED))


@pytest.fixture(scope="module")
def right(tmp_path_factory: pytest.TempPathFactory) -> Hypothesis:
    return disc(tmp_path_factory.mktemp("disc"), COULOMB)


@pytest.fixture(scope="module")
def episodes(right: Hypothesis) -> list[Episode]:
    return pushed(right.robot, coulomb=COULOMB, samples=SAMPLES, noise=NOISE)


@pytest.fixture(scope="module")
def runs(right: Hypothesis, episodes: list[Episode]) -> list[Observed]:
    return seen(right, right.start, episodes)


def test_what_is_described_is_not_missing(
    right: Hypothesis, episodes: list[Episode], runs: list[Observed], tmp_path: Path
) -> None:
    bare = disc(tmp_path, 0.0)
    without = seen(bare, bare.start, episodes)
    # The friction is most of the torque of 0.5 N m.
    assert missing(without) > 0.3
    assert missing([settled(run) for run in runs]) < 0.1
    found = replace(bare, effects=(CoulombFriction(joint="axle", c=COULOMB),))
    same = seen(found, found.start, episodes)
    for one, other in zip(runs, same, strict=True):
        np.testing.assert_array_equal(one.about.force, other.about.force)


def test_its_own_column_is_that_of_the_effect_times_its_level(
    right: Hypothesis, runs: list[Observed]
) -> None:
    freed = right.freed()
    at = [knob.what for knob in freed.knobs].index("frictionloss")
    own, _ = Columns.of(freed, freed.start).forces(runs[0])
    force = COULOMB * CoulombFriction(joint="axle").regressor(runs[0].motion)[:, 0, 0]
    # A difference over a step of 1e-3 of the logarithm is off by half of that.
    np.testing.assert_allclose(own[:, 0, at], force, rtol=1e-3)
    assert np.ptp(force) == pytest.approx(2.0 * COULOMB)


def test_a_right_description_is_not_accused(right: Hypothesis, episodes: list[Episode]) -> None:
    best = ranked(right, episodes).best
    assert best.effects == ()
    assert missing(best.refit.runs) < 0.1
