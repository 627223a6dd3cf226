"""Motors that have become servos."""

import mujoco
import numpy as np
import pytest

from morph.body.load import load
from morph.body.spec import spec_of
from morph.policy_transfer.gait.servoed import servoed


def test_a_servo_pushes_by_its_law_up_to_the_motors_limit() -> None:
    robot = servoed(load("swimmer_three_links"), yields=0.25, settles=0.1)
    model = spec_of(robot).compile()
    data = mujoco.MjData(model)
    data.qpos[model.joint("front").qposadr[0]] = 0.1
    data.qvel[model.joint("front").dofadr[0]] = 0.5
    data.ctrl[:] = (0.2, 1.0)
    mujoco.mj_forward(model, data)
    # Front: 5 / 0.25 = 20 N m/rad on 0.1 rad, less 2 N m s/rad on 0.5 rad/s. Rear: 20 N m on a
    # radian, of which the motor has 5.
    np.testing.assert_allclose(data.actuator_force, [20.0 * 0.1 - 2.0 * 0.5, 5.0])


def test_servos_stay_as_they_are() -> None:
    robot = load("sea_snake")
    assert servoed(robot) is robot


@pytest.mark.parametrize("name", ["swimmer_three_links", "hopper"])
def test_every_motor_becomes_a_servo_and_the_body_weighs_the_same(name: str) -> None:
    before, after = load(name), servoed(load(name))
    assert {each.kind for each in after.actuators} == {"position"}
    assert after.mass == pytest.approx(before.mass)
    assert after.sha256 != before.sha256
