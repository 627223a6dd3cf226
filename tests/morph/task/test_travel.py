"""Standing, walking and swimming: which bodies can be asked, how they begin, what counts."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from morph.body.limbs import torso_of
from morph.body.load import load
from morph.body.postures import posture_of
from morph.body.spec import spec_of
from morph.errors import TaskError
from morph.task.balance import balance
from morph.task.moved import Moved
from morph.task.stand import stand
from morph.task.swim import swim
from morph.task.task import Task
from morph.task.tasks import task, tasks_of
from morph.task.walk import walk

TORSOS = {
    "biped": "torso",
    "hopper": "torso",
    "humanoid": "pelvis",
    "humanoid_skateboard": "pelvis",
    "quadruped_four_bar": "core",
    "hexapod_swimmer": "hull",
    "swimmer_three_links": "head",
    "cartpole": None,
    "so101": None,
    "rider_two_links_driven": None,
}


@pytest.mark.parametrize(("body", "link"), TORSOS.items())
def test_the_torso_is_what_moves_freely_though_no_motor_moves_it(
    body: str, link: str | None
) -> None:
    assert torso_of(load(body)) == link


@pytest.mark.parametrize("body", ["biped", "hopper"])
def test_in_its_stance_a_walker_is_over_its_feet_and_its_knees_are_bent(body: str) -> None:
    robot = load(body)
    start = posture_of(robot)
    model = spec_of(robot).compile()
    data = mujoco.MjData(model)
    for name, value in start.items():
        data.qpos[model.joint(name).qposadr[0]] = value
    mujoco.mj_forward(model, data)
    feet = [body for body in range(model.nbody) if model.body(body).name.endswith("foot")]
    for foot in feet:
        lean = data.xmat[foot].reshape(3, 3)[:, 2]
        assert lean == pytest.approx([0.0, 0.0, 1.0], abs=0.01)
    middle = np.mean([data.xipos[foot][0] for foot in feet])
    # The soles reach some 0.13 m either way; a tenth of that is well within.
    assert abs(data.subtree_com[0][0] - middle) < 0.013
    for actuator in robot.actuators:
        low, high = robot.joint(actuator.joint).limits or (-9.0, 9.0)
        assert low + 0.1 < start[actuator.joint] < high - 0.1


def moved(asked: Task, x: float, y: float, tilt: float) -> Moved:
    """Return a body that glides from its start to (x, y), leaning all the time."""
    model = asked.simulator().model
    q, v = asked.start.sample(asked.robot, model, 1, None)
    share = np.linspace(0.0, 1.0, asked.samples)
    position = np.repeat(q[:, None], asked.samples, axis=1)
    position[0, :, 0] += x * share
    position[0, :, 1] += y * share
    position[0, :, 3:7] = [np.cos(tilt / 2), 0.0, np.sin(tilt / 2), 0.0]
    return Moved(
        robot=asked.robot,
        model=model,
        time=asked.period * np.arange(asked.samples),
        position=position,
        velocity=np.repeat(v[:, None], asked.samples, axis=1),
        command=np.zeros((1, asked.samples, model.nu)),
    )


@pytest.mark.parametrize(
    ("x", "y", "tilt", "success"),
    [(1.1, 0.0, 0.0, True), (0.9, 0.0, 0.0, False), (1.1, 0.6, 0.0, False), (1.1, 0.0, 0.9, False)],
)
def test_a_walk_is_a_metre_ahead_not_far_aside_and_upright(
    x: float, y: float, tilt: float, success: bool
) -> None:
    asked = walk(load("quadruped_printed"), horizon=1.0)
    assert bool(asked.succeeded(moved(asked, x, y, tilt))[0]) is success


def test_the_cost_of_a_walk_is_that_of_the_way_that_is_left() -> None:
    asked = walk(load("quadruped_printed"), horizon=1.0)
    # At the end ((1.5 - x) / 0.5)^2 / 2 for the way and (y / 0.5)^2 / 2 aside.
    assert asked.loss(moved(asked, 1.0, 0.25, 0.0)) == pytest.approx([0.5 + 0.125], rel=1e-6)


def test_what_is_trimmed_for_the_sea_swims_in_the_sea() -> None:
    assert swim(load("hexapod_swimmer")).world == "water"
    assert swim(load("hexapod_swimmer_salt")).world == "salt_water"


def test_bodies_that_cannot_are_refused_with_a_body_that_can() -> None:
    with pytest.raises(TaskError, match="held to the world"):
        walk(load("so101"))
    with pytest.raises(TaskError, match="not made to swim"):
        swim(load("quadruped_printed"))


def test_a_body_on_its_feet_balances_where_it_stands() -> None:
    robot = load("hopper")
    by_name = balance(robot)
    assert by_name.name == "balance"
    assert by_name.goals == stand(robot).goals


@pytest.mark.parametrize("body", ["humanoid", "quadruped_four_bar"])
def test_a_start_on_the_floor_throws_nobody_off_it(body: str) -> None:
    asked = stand(load(body))
    model = asked.simulator().model
    q, _ = asked.start.sample(asked.robot, model, 20, np.random.default_rng(0))
    shifted = np.ptp(q, axis=0) > 0.0
    # A closed chain may be moved as a whole, any other body at its joints alone.
    assert shifted[:7].any() == bool(asked.robot.loops)
    assert shifted[7:].any() != bool(asked.robot.loops)


@pytest.mark.parametrize(
    "body", ["biped", "humanoid", "quadruped_printed", "sea_snake", "so101", "swimmer_three_links"]
)
def test_the_first_task_of_a_card_can_be_made(body: str) -> None:
    robot = load(body)
    first = tasks_of(robot)[0]
    assert first == robot.card.tasks[0]
    assert task(first, robot).name == first


def test_a_task_of_other_length_costs_another_hash() -> None:
    asked = stand(load("humanoid"))
    assert asked.sha256 != replace(asked, horizon=4.0).sha256
