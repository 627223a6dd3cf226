"""Gaits carried from walker to walker: which joint does what is learned, signs and all."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from morph.body.load import load
from morph.body.robot import Robot
from morph.body.spec import bare_spec
from morph.body.vary.apply import edited
from morph.body.vary.signs import reverse
from morph.errors import TransferError
from morph.policy_transfer.gait_family import Response, carried, joint_map, leaning, tried
from morph.search.family.gait import gait
from morph.task.crouch import crouch
from morph.task.task import Task
from morph.task.walk import walk


def standing(robot: Robot, bend: float = 0.6) -> Task:
    """Return the humanoid's task, begun on bent knees."""
    task = walk(robot, distance=0.5, horizon=5.0)
    posture = crouch(robot, {"l_knee_y": bend, "r_knee_y": bend})
    return replace(task, start=replace(task.start, position=posture))


def shown(task: Task, count: int = 60) -> Response:
    """Return what set points do, told to servos as they are."""
    names = [each.joint for each in task.robot.actuators]
    posture = np.array([task.start.position.get(name, 0.0) for name in names])
    return tried(task, lambda q, v, point: posture + point, count, np.random.default_rng(0))


@pytest.fixture(scope="module")
def humanoid() -> Task:
    """Return the humanoid on bent knees."""
    return standing(load("humanoid"))


@pytest.fixture(scope="module")
def response(humanoid: Task) -> Response:
    """Return what the humanoid's set points do to its feet."""
    return shown(humanoid)


def test_each_joint_moves_its_foot_as_the_lever_of_its_leg_says(
    humanoid: Task, response: Response
) -> None:
    # A hip turns the foot about itself: ahead goes by how far the foot is below it, and pitch by
    # the angle itself. Knee and ankle pitch the foot by as much.
    at = {each.name: number for number, each in enumerate(humanoid.robot.actuators)}
    ahead, pitch = response.gain[0], response.gain[3]
    # 60 transitions of 0.06 rad, seen to 0.001: a gain is known to 0.003 where 25 are sought.
    for name in ("l_hip_y", "l_knee_y", "l_ankle_y"):
        assert pitch[at[name]] == pytest.approx(1.0, abs=0.1)
    assert ahead[at["l_hip_y"]] == pytest.approx(-response.leg, abs=0.1 * response.leg)
    assert np.abs(response.gain[:4, at["r_hip_y"]]).max() < 0.1


def test_a_body_is_mapped_to_itself_by_the_identity(humanoid: Task, response: Response) -> None:
    found = joint_map(response, response)
    legs = [
        number
        for number, each in enumerate(humanoid.robot.actuators)
        if each.name.endswith(("hip_y", "knee_y", "ankle_y"))
    ]
    # The ridge takes a part of what moves the feet little: of a knee that is bent by 0.6 rad.
    assert np.diag(found)[legs] == pytest.approx(np.ones(6), abs=0.3)


def test_a_joint_described_with_the_opposite_sign_is_mapped_with_it(
    humanoid: Task, response: Response
) -> None:
    spec = bare_spec(humanoid.robot)
    reverse(spec, "l_knee_y")
    mirrored = edited(humanoid.robot, spec, "humanoid", "0" * 64)
    task = walk(mirrored, distance=0.5, horizon=5.0)
    posture = dict(humanoid.start.position)
    posture["l_knee_y"] *= -1.0
    seen = shown(replace(task, start=replace(task.start, position=posture)))
    at = [each.name for each in mirrored.actuators].index("l_knee_y")
    assert joint_map(response, seen)[at, at] < -0.7


def test_leaning_aside_turns_the_hips_against_each_other(
    humanoid: Task, response: Response
) -> None:
    # Rolls of the limbs are mirrored, positive outward: aside is one leg out, the other in.
    at = [each.name for each in humanoid.robot.actuators]
    lean = leaning(response)
    left, right = lean[at.index("l_hip_x")], lean[at.index("r_hip_x")]
    assert left * right < 0.0
    assert min(abs(left), abs(right)) > 0.7


def test_a_gait_carried_through_the_identity_is_the_gait(
    humanoid: Task, response: Response
) -> None:
    roles = ("hip_y", "knee_y")
    source = gait(humanoid.robot, period=humanoid.period, roles=roles)
    family = carried(
        source, None, (response, response), humanoid, map=np.eye(len(humanoid.robot.actuators))
    )
    values = family.values(family.start)
    values[-2] = 0.0
    found, wanted = family.make(values), source.make(values[:-2])
    time = np.linspace(0.0, 1.0, 11)
    nothing = np.empty((11, 0))
    # Well within the bounds, where nothing is clipped.
    inside = [name for name in range(25) if humanoid.robot.actuators[name].name == "l_hip_y"]
    off = found.act(nothing, time) - wanted.act(nothing, time) - family.posture
    assert np.abs(off[:, inside]).max() < 1e-9


def test_a_body_with_more_feet_is_refused(response: Response) -> None:
    more = replace(response, rest=np.zeros(16), gain=np.zeros((16, 8)))
    with pytest.raises(TransferError, match=r"one has 2 feet, the other 4"):
        joint_map(response, more)


def test_fewer_transitions_than_joints_are_refused(humanoid: Task) -> None:
    with pytest.raises(TransferError, match=r"20 transitions of 25 joints"):
        shown(humanoid, 20)
