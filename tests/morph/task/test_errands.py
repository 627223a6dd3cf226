"""Hop, ride, steer and gait speed: what counts, and who can be asked."""

import mujoco
import numpy as np
import pytest

from morph.body.load import load
from morph.errors import TaskError
from morph.policy.pattern import pattern
from morph.search.generations.population import tried
from morph.sim.closed_loop import closed_loop
from morph.task.gait_speed import gait_speed
from morph.task.hop import Leap, hop
from morph.task.moved import Moved
from morph.task.ride import ride
from morph.task.steer import steer
from morph.task.task import Task


def at_rest(task: Task) -> Moved:
    """Return a body that stays where it begins, as it would in a world without gravity."""
    model = task.simulator().model
    q, v = task.start.sample(task.robot, model, 1, None)
    return Moved(
        robot=task.robot,
        model=model,
        time=task.period * np.arange(task.samples),
        position=np.repeat(q[:, None], task.samples, axis=1),
        velocity=np.repeat(0.0 * v[:, None], task.samples, axis=1),
        command=np.zeros((1, task.samples, model.nu)),
    )


@pytest.mark.parametrize(("metres", "reached"), [(0.89, False), (0.95, True), (1.12, False)])
def test_a_gait_speed_is_met_neither_slower_nor_faster(metres: float, reached: bool) -> None:
    # 0.1 m/s for 10 s is a metre, give or take a tenth.
    task = gait_speed(load("sea_snake"), speed=0.1, horizon=10.0)
    moved = at_rest(task)
    moved.position[0, :, 0] += metres * moved.time / moved.time[-1]
    assert bool(task.succeeded(moved)[0]) is reached


def test_a_speed_that_is_none_is_refused() -> None:
    with pytest.raises(TaskError, match="-1 m/s is out of range"):
        gait_speed(load("sea_snake"), speed=-1.0)


@pytest.mark.parametrize(("height", "reached"), [(0.02, False), (0.04, True)])
def test_a_hop_leaves_the_floor_at_some_time(height: float, reached: bool) -> None:
    task = hop(load("hopper"), horizon=1.0)
    moved = at_rest(task)
    moved.position[0, :, moved.model.joint("up").qposadr[0]] += height * np.sin(
        np.pi * moved.time / moved.time[-1]
    )
    (leap,) = [goal for goal in task.goals if isinstance(goal.quantity, Leap)]
    assert bool(leap.reached(moved)[0]) is reached


def test_a_ride_ends_a_metre_ahead() -> None:
    task = ride(load("rider_rigid_driven"))
    moved = at_rest(task)
    assert not task.succeeded(moved)[0]
    moved.position[0, :, moved.model.joint("board").qposadr[0]] += np.minimum(1.0, moved.time)
    assert task.succeeded(moved)[0]


def test_who_has_no_board_can_neither_ride_nor_steer() -> None:
    with pytest.raises(TaskError, match="rides on one"):
        ride(load("double_pendulum"))
    with pytest.raises(TaskError, match="does not stand on a board"):
        steer(load("humanoid"))


def test_the_wheels_of_a_board_that_is_to_steer_roll_as_fast_as_the_board() -> None:
    task = steer(load("humanoid_skateboard"), speed=0.5)
    simulator = task.simulator()
    model = simulator.model
    q, v = task.start.sample(task.robot, model, 1, None)
    data = mujoco.MjData(model)
    data.qpos, data.qvel = q[0], v[0]
    mujoco.mj_forward(model, data)
    # What a wheel has at its lowest point is v - w r = 0.
    wheel = model.body("front_left_wheel").id
    velocity = np.zeros(6)
    mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, wheel, velocity, 0)
    radius = data.xpos[wheel][2]
    assert velocity[3] - velocity[1] * radius == pytest.approx(0.0, abs=1e-9)
    # So it rolls on: friction neither speeds it up nor slows it down.
    still = pattern(task.robot, {})
    loop = closed_loop(
        simulator,
        lambda a, b, time: still.act(np.empty((1, 0)), np.full(1, time)),
        q,
        v,
        period=0.02,
        seconds=0.4,
    )
    assert loop.velocity[0, -1, 0] == pytest.approx(0.5, abs=0.1)
    assert not tried(task, [still], simulator, runs=2, rng=np.random.default_rng(0)).success.any()
