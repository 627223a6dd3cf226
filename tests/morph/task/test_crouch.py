"""Standing on bent knees."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from morph.body.load import load
from morph.body.spec import spec_of
from morph.errors import TaskError
from morph.sim.start import started
from morph.task.crouch import crouch


def test_soles_are_flat_on_the_floor_and_the_weight_is_above_them() -> None:
    robot = load("humanoid")
    posture = crouch(robot, {"l_knee_y": 0.6, "r_knee_y": 0.6})
    model = spec_of(robot).compile()
    data = mujoco.MjData(model)
    data.qpos, _ = started(robot, model, posture, {})
    mujoco.mj_forward(model, data)
    for sole in ("left_sole", "right_sole"):
        at = model.geom(sole).id
        # Angles are rounded to 1e-4 rad, of three joints.
        assert abs(data.geom_xmat[at].reshape(3, 3)[2, 2] - 1.0) < 1e-6
        # The sole is 0.01 m thick: its middle is 0.005 m over the floor.
        assert data.geom_xpos[at, 2] == pytest.approx(0.005, abs=2e-4)
        assert data.subtree_com[1, 0] == pytest.approx(data.geom_xpos[at, 0], abs=2e-3)


def test_a_straight_leg_stays_as_it_is_but_for_its_weight() -> None:
    posture = crouch(load("humanoid"), {"l_knee_y": 0.0, "r_knee_y": 0.0})
    # Hip and ankle lean against each other until the weight is over the soles' middle.
    assert posture["l_hip_y"] == pytest.approx(-posture["l_ankle_y"], abs=2e-4)
    assert np.sign(posture["l_ankle_y"]) == np.sign(posture["r_ankle_y"])


def test_joints_that_are_all_bent_leave_nothing_to_place() -> None:
    legs = ("hip_y", "knee_y", "ankle_y")
    with pytest.raises(TaskError, match=r"no joint of its legs turns about the same axis"):
        crouch(load("humanoid"), {f"{side}_{name}": 0.1 for side in "lr" for name in legs})
