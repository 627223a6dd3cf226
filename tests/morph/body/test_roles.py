"""Roles of joints, against the motion that they ought to mean and against other names."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium
import mujoco
import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.body.roles import actuator_roles, joint_roles
from morph.body.spec import spec_of
from morph.search.family.gait import gait
from tests.morph.body.disguise import disguised

ANT = Path(gymnasium.__file__).parent / "envs/mujoco/assets/ant.xml"


def grouped(robot: Robot) -> set[frozenset[str]]:
    """Return the joints of each role."""
    roles = joint_roles(robot)
    return {
        frozenset(name for name, each in roles.items() if each.order == role.order)
        for role in roles.values()
    }


@pytest.mark.parametrize("body", ["quadruped_printed", "humanoid", "hexapod_swimmer", "sea_snake"])
def test_joints_of_one_role_are_those_whose_names_say_so(body: str) -> None:
    robot = load(body)
    words = {"left", "right", "l", "r", "front", "rear", "middle"}
    said: dict[tuple[str, ...], set[str]] = {}
    for name in joint_roles(robot):
        rest = tuple(w for w in name.split("_") if w not in words and not w.isdecimal())
        said.setdefault(rest, set()).add(name)
    assert grouped(robot) == {frozenset(names) for names in said.values()}


def test_a_label_is_what_the_names_have_in_common() -> None:
    roles = actuator_roles(load("quadruped_four_bar"))
    assert {role.name for role in roles.values()} == {"hip", "knee"}
    for part in ("hip", "knee"):
        left, rear = roles[f"front_left_{part}_servo"], roles[f"rear_right_{part}_servo"]
        assert (left.side, left.place, rear.side, rear.place) == (0.0, 0.0, 1.0, 1.0)
    assert joint_roles(load("humanoid"))["l_hip_x"].name == "hip_x"


def test_the_bends_of_a_snake_stand_in_a_row_from_front_to_rear() -> None:
    roles = actuator_roles(load("sea_snake"))
    assert [roles[f"yaw_{at}"].place for at in range(1, 6)] == [0.0, 0.25, 0.5, 0.75, 1.0]
    assert {roles[f"yaw_{at}"].side for at in range(1, 6)} == {None}


def test_joints_of_an_arm_have_roles_of_their_own() -> None:
    roles = joint_roles(load("so101"))
    assert len({role.order for role in roles.values()}) == len(roles)


def moved(robot: Robot, role: int, angle: float) -> dict[str, Array]:
    """Return how far each link's centre of mass goes if all joints of a role turn alike, m."""
    model: Any = spec_of(robot).compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    before = data.xipos.copy()
    for name, each in joint_roles(robot).items():
        if each.order == role:
            data.qpos[model.joint(name).qposadr[0]] += each.sense * angle
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    return {model.body(at).name: data.xipos[at] - before[at] for at in range(1, model.nbody)}


@pytest.mark.parametrize("seed", [None, 0, 1, 2])
@pytest.mark.parametrize("body", ["humanoid", "quadruped_printed", "hexapod_swimmer", ANT])
def test_equal_motions_of_twins_are_mirror_images(
    body: str | Path, seed: int | None, tmp_path: Path
) -> None:
    robot = load(body)
    if seed is not None:
        robot, _ = disguised(robot, tmp_path, seed)
    roles = joint_roles(robot)
    link = {joint.name: joint.link for joint in robot.joints}
    pairs = 0
    for order in {role.order for role in roles.values()}:
        gone = moved(robot, order, 0.2)
        same = [(name, role) for name, role in roles.items() if role.order == order]
        left = {role.place: name for name, role in same if role.side == 0.0}
        right = {role.place: name for name, role in same if role.side == 1.0}
        assert left.keys() == right.keys()
        for place, name in left.items():
            mirrored = gone[link[right[place]]] * [1.0, -1.0, 1.0]
            # Twins lie within 6 % of where the mirror image would: 0.2 rad times that.
            size = max(float(np.linalg.norm(gone[link[name]])), 0.05)
            assert np.linalg.norm(gone[link[name]] - mirrored) < 0.3 * size
            pairs += 1
    assert pairs >= 3


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize(
    "body", ["quadruped_printed", "hexapod_swimmer", "sea_snake", "swimmer_three_links", ANT]
)
def test_names_axes_and_order_change_no_gait(body: str | Path, seed: int, tmp_path: Path) -> None:
    before = load(body)
    after, _ = disguised(before, tmp_path, seed)
    runs = [swum(before), swum(after)]
    # A description is written with six digits: 1e-6 of a metre, grown by less than e^5 in 1 s.
    assert runs[0] == pytest.approx(runs[1], abs=1e-4)
    assert np.ptp(runs[0], axis=0).max() > 1e-3


def swum(robot: Robot) -> Array:
    """Return where all bodies are in a second of one gait, without gravity, shape (steps, 3 n)."""
    family = gait(robot)
    rng = np.random.default_rng(5)
    policy = family.policy(rng.uniform(0.2, 0.8, len(family.numbers)))
    model: Any = spec_of(robot).compile()
    model.opt.gravity[:] = 0.0
    data = mujoco.MjData(model)
    order = [model.actuator(each.actuator).id for each in policy.action]
    seen = []
    while data.time < 1.0:
        data.ctrl[order] = policy.act(np.empty(0), np.array(data.time))
        mujoco.mj_step(model, data)
        seen.append(data.xpos[1:].ravel().copy())
    return np.array(seen)
