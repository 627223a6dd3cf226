"""A current through a drag that is not found yet, against MuJoCo's Jacobians of points."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.inference.streaming import Streaming, acting_together, resolved
from morph.model.episodes import episode, step_for
from morph.model.hypothesis import Hypothesis
from morph.model.motion import needed
from morph.physics.body_motion import body_motions
from morph.physics.fluid.fluid_current import FluidCurrent
from morph.physics.fluid.linear_drag import LinearDrag
from morph.physics.fluid.quadratic_drag import QuadraticDrag
from morph.physics.joint.viscous_friction import ViscousFriction
from morph.record.recording import Recording


def test_a_current_through_a_drag_of_one_is_a_force_at_its_point(
    arm: Callable[..., Robot], recorded: Callable[..., Recording]
) -> None:
    robot = arm()
    run = recorded(robot, start={"shoulder": 0.4, "elbow": -0.7}, noise=0.0, seconds=1.0)
    step = step_for([run], robot)
    model = Hypothesis(robot=robot, step=step, knobs=())
    motion = needed(model, model.start, episode(run, robot, step)).motion
    drag = LinearDrag(body="lower", cx=0.2, cz=0.05)
    compiled = spec_of(robot).compile()
    moved = (motion.position, motion.velocity, motion.acceleration)
    motion = replace(motion, bodies=body_motions(compiled, ["lower"], *moved))
    found = Streaming(drag=drag).regressor(motion)
    data, lower = mujoco.MjData(compiled), compiled.body("lower").id
    for at in (0, len(found) // 2, len(found) - 1):
        data.qpos[:] = motion.position[at]
        mujoco.mj_kinematics(compiled, data)
        mujoco.mj_comPos(compiled, data)
        jacobian = np.zeros((3, compiled.nv))
        point = data.xpos[lower] + data.xmat[lower].reshape(3, 3) @ drag.centre
        mujoco.mj_jac(compiled, data, jacobian, None, point, lower)
        # A difference over 1e-4 m/s of numbers of about 1 N m rounds to 1e-12.
        assert found[at] == pytest.approx(jacobian.T, abs=1e-9)


def test_a_product_with_a_drag_becomes_the_current() -> None:
    drag = LinearDrag(body="lower", x=2.0, y=4.0, z=6.0)
    product = Streaming(drag=LinearDrag(body="lower"), x=2.0, z=-1.0)
    friction = ViscousFriction(joint="elbow", b=0.1)
    assert resolved([product, friction, drag]) == (FluidCurrent(x=0.5, z=-0.25), friction, drag)
    # Beside a drag of nothing it would be without bounds.
    least = resolved([product, LinearDrag(body="lower")])[0]
    assert isinstance(least, FluidCurrent)
    assert (least.x, least.y, least.z) == pytest.approx((3.0, 0.0, -1.5))


def test_a_current_and_its_only_drag_go_together() -> None:
    drag, other = LinearDrag(body="lower"), QuadraticDrag(body="upper")
    friction, current = ViscousFriction(joint="elbow"), FluidCurrent()
    effects = [friction, drag, current]
    assert [acting_together(effects, at) for at in range(3)] == [[0], [1, 2], [1, 2]]
    # Through another drag the current still acts.
    assert acting_together([*effects, other], 1) == [1]
    assert acting_together([*effects, other], 2) == [2]
