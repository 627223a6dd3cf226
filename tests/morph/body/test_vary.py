"""Each operation against a closed form or a second library."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pinocchio
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.body.twin import twin_of
from morph.body.vary import Add, Drop, Heavier, Lock, Operation, Scale, Stiffen, removed, vary
from morph.errors import RobotError

GRAVITY = 9.81


def described(text: str, folder: Path) -> Robot:
    """Return the robot of an MJCF text."""
    (folder / "made.xml").write_text(f"<mujoco model='made'>{text}</mujoco>")
    return load(folder / "made.xml")


def period(robot: Robot) -> float:
    """Return the period of a swing of 0.01 rad about the joint `hinge`, s."""
    model = spec_of(robot, timestep=0.0001).compile()
    data = mujoco.MjData(model)
    data.joint("hinge").qpos = 0.01
    crossings: list[float] = []
    while len(crossings) < 3:
        before, time = float(data.qpos[0]), data.time
        mujoco.mj_step(model, data)
        if before * data.qpos[0] < 0:
            crossings.append(time + 0.0001 * before / (before - float(data.qpos[0])))
    return crossings[2] - crossings[0]


def mass_matrix(model: Any, position: Array) -> Array:
    data = mujoco.MjData(model)
    data.qpos[:] = position
    mujoco.mj_forward(model, data)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    return full


def test_a_rod_scaled_at_constant_density_is_the_larger_rod() -> None:
    # A rod of 0.5 kg and 0.5 m, times 1.3: m s^3, and m l^2 / 12 of the new mass and length.
    pole = vary(load("cartpole"), Scale(link="pole", factor=1.3)).link("pole")
    mass, length = 0.5 * 1.3**3, 0.5 * 1.3
    assert pole.mass == pytest.approx(mass, rel=1e-12)
    assert pole.com == pytest.approx((0, 0, -length / 2), rel=1e-12)
    assert pole.inertia[0] == pytest.approx(mass * length**2 / 12, rel=1e-12)


def test_a_rod_that_keeps_its_mass_has_an_inertia_that_grows_as_its_length_squared() -> None:
    pole = vary(load("cartpole"), Scale(link="pole", factor=1.3, mass="keep")).link("pole")
    assert pole.mass == 0.5
    assert pole.inertia[0] == pytest.approx(0.5 * (0.5 * 1.3) ** 2 / 12, rel=1e-12)


def test_a_rod_stretched_along_itself_grows_longer_and_not_thicker() -> None:
    # Along z: m s, and across s^3 (m l^2 / 12 - t) + s t, where t = 1e-5 / 2 is the
    # second moment across the rod, half of the inertia along it.
    operation = Scale(link="pole", factor=1.3, along=(0.0, 0.0, 2.0))
    pole = vary(load("cartpole"), operation).link("pole")
    thick = 1e-5 / 2
    across = 1.3**3 * (0.5 * 0.5**2 / 12 - thick) + 1.3 * thick
    assert pole.mass == pytest.approx(0.5 * 1.3, rel=1e-12)
    assert pole.inertia[:3] == pytest.approx((across, across, 1.3e-5), rel=1e-9)


def test_the_links_beyond_a_scaled_one_move_along_and_stay_as_they_are() -> None:
    before = load("so101")
    after = vary(before, Scale(link="lower_arm", factor=2.0))
    tips = []
    for robot in (before, after):
        model = spec_of(robot).compile()
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        tips.append(data.site("tip").xpos.copy())
    # At zero the wrist stands 0.1349 m ahead of and 0.0052 m above the elbow: once more.
    assert tips[1] - tips[0] == pytest.approx([0.1349, 0, 0.0052], abs=1e-12)
    others = [link.name for link in before.links if link.name != "lower_arm"]
    assert all(before.link(name) == after.link(name) for name in others)


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_a_pendulum_that_is_larger_swings_slower_by_the_root_of_its_size(factor: float) -> None:
    # T = 2 pi sqrt(I / (m g d)), with I ~ s^5 and m d ~ s^4. The crossings of a step of
    # 1e-4 s are found to about 1e-8 s; the amplitude of 0.01 rad acts alike on both.
    robot = load("pendulum")
    larger = vary(robot, Scale(link="*", factor=factor))
    assert period(larger) / period(robot) == pytest.approx(math.sqrt(factor), rel=1e-4)


def test_a_heavier_pendulum_swings_as_before_and_against_a_spring_slower() -> None:
    # T = 2 pi sqrt(f I / (f m g d + k)); the pendulum has I = 0.251, m = 1, d = 0.5.
    robot = load("pendulum")
    link = robot.links[-1].name
    heavy = vary(robot, Heavier(link=link, factor=4.0))
    assert period(heavy) == pytest.approx(period(robot), rel=1e-6)
    sprung = vary(heavy, Stiffen(joint="hinge", stiffness=20.0))
    wanted = 2 * math.pi * math.sqrt(4 * 0.251 / (4 * 1.0 * GRAVITY * 0.5 + 20.0))
    # An amplitude of 0.01 rad lengthens it by less than 0.01^2 / 16.
    assert period(sprung) == pytest.approx(wanted, rel=2e-5)


def test_mass_added_is_spread_as_the_links_own() -> None:
    pole = vary(load("cartpole"), Heavier(link="pole", add=0.25)).link("pole")
    assert pole.mass == 0.75
    assert pole.inertia[0] == pytest.approx(0.75 * 0.5**2 / 12, rel=1e-12)
    whole = vary(load("cartpole"), Heavier(link="*", add=1.0))
    assert whole.mass == pytest.approx(2.0, rel=1e-12)


def test_springs_in_parallel_act_as_one() -> None:
    # -3 (q - 0.2) - 1 (q - 1.0) = -4 (q - 0.4), since (3 * 0.2 + 1 * 1.0) / 4 = 0.4.
    robot = vary(
        load("pendulum"),
        Stiffen(joint="hinge", stiffness=3.0, rest=0.2, damping=0.5),
        Stiffen(joint="hinge", stiffness=1.0, rest=1.0, damping=0.25),
    )
    model = spec_of(robot).compile()
    data = mujoco.MjData(model)
    data.qpos[0], data.qvel[0] = -0.3, 2.0
    mujoco.mj_forward(model, data)
    assert data.qfrc_passive[0] == pytest.approx(-4 * (-0.3 - 0.4) - 0.75 * 2, abs=1e-12)


@pytest.mark.parametrize(
    "operation",
    [
        Scale(link="*", factor=1.0),
        Scale(link="wrist", factor=1.0),
        Heavier(link="wrist", factor=1.0),
        Stiffen(joint="Elbow", stiffness=0.0),
    ],
    ids=str,
)
def test_an_operation_that_changes_nothing_gives_the_same_text(operation: Operation) -> None:
    robot = load("so101")
    same = vary(robot, operation)
    assert same.mjcf.replace(same.name, robot.name) == robot.mjcf


@pytest.mark.parametrize(
    ("name", "joint", "at"), [("double_pendulum", "elbow", 0.7), ("so101", "Elbow", -0.4)]
)
def test_a_locked_joint_leaves_the_composite_body_that_pinocchio_finds(
    name: str, joint: str, at: float
) -> None:
    robot = load(name)
    twin = twin_of(robot)
    stand = pinocchio.neutral(twin)
    stand[twin.joints[twin.getJointId(joint)].idx_q] = at
    reduced = pinocchio.buildReducedModel(twin, [twin.getJointId(joint)], stand)
    model = spec_of(vary(robot, Lock(joint=joint, at=at))).compile()
    rng = np.random.default_rng(5)
    for _ in range(5):
        q, v = rng.normal(size=(2, model.nv))
        upper = np.triu(pinocchio.crba(reduced, reduced.createData(), q))
        # Doubles, and inertias of about 1 kg m2: rounding is 1e-15.
        assert np.abs(upper - np.triu(mass_matrix(model, q))).max() < 1e-12
        data = mujoco.MjData(model)
        data.qpos[:], data.qvel[:] = q, v
        mujoco.mj_forward(model, data)
        bias = pinocchio.nonLinearEffects(reduced, reduced.createData(), q, v)
        assert np.abs(bias - data.qfrc_bias).max() < 1e-9


@pytest.mark.parametrize("joint", ["along", "turn", "tilt"])
def test_a_joint_locked_among_others_of_its_link_leaves_every_point_in_place(
    joint: str, tmp_path: Path
) -> None:
    robot = described(
        "<worldbody><body pos='1 2 3' quat='0.8 0 0.6 0'><inertial pos='0 0 0' mass='1'"
        " diaginertia='1 1 1'/><joint name='along' type='slide' axis='1 1 0'/>"
        "<joint name='turn' pos='0.1 0.2 0' axis='0 0 1'/><joint name='tilt' pos='0 0.3 0.1'"
        " axis='0 1 1'/><site name='tip' pos='0.5 0.4 0.3'/></body></worldbody>",
        tmp_path,
    )
    stand = {"along": 0.3, "turn": 0.7, "tilt": -1.1}
    found = []
    for each in (robot, vary(robot, Lock(joint=joint, at=stand[joint]))):
        model = spec_of(each).compile()
        data = mujoco.MjData(model)
        for name in (other.name for other in each.joints):
            data.joint(name).qpos = stand[name]
        mujoco.mj_forward(model, data)
        found.append(np.append(data.site("tip").xpos, data.site("tip").xmat))
    assert np.abs(found[1] - found[0]).max() < 1e-12


@pytest.mark.parametrize(
    ("shape", "size", "kind", "half"),
    [
        ("box", (0.1, 0.2, 0.3), "box", "0.05 0.1 0.15"),
        ("sphere", (0.1,), "sphere", "0.1"),
        ("cylinder", (0.1, 0.3), "cylinder", "0.1 0.15"),
        ("capsule", (0.1, 0.3), "capsule", "0.1 0.15"),
    ],
)
def test_an_added_solid_has_the_inertia_that_mujoco_gives_its_shape(
    shape: str, size: tuple[float, ...], kind: str, half: str, tmp_path: Path
) -> None:
    operation = Add(
        link="tip", parent="pole", mass=0.7, shape=shape, size=size, centre=(0.0, 0.0, 0.2)
    )
    added = vary(load("cartpole"), operation).link("tip")
    drawn = described(
        f"<worldbody><body name='tip'><joint/><geom type='{kind}' size='{half}' mass='0.7'"
        " pos='0 0 0.2'/></body></worldbody>",
        tmp_path,
    ).link("tip")
    assert added.mass == drawn.mass == 0.7
    assert added.com == pytest.approx(drawn.com, abs=1e-15)
    assert added.inertia == pytest.approx(drawn.inertia, rel=1e-9, abs=1e-15)


def test_a_link_added_and_dropped_again_leaves_the_robot_as_it_was() -> None:
    robot = load("so101")
    added = vary(robot, Add(link="tip", parent="jaw", mass=0.1, joint="tip", motor=1.0))
    assert added.joint("tip").limits is None
    assert [actuator.joint for actuator in added.actuators][-1] == "tip"
    back = vary(added, Drop(link="tip"))
    assert back.mjcf.replace(back.name, robot.name) == robot.mjcf


def test_a_pendulum_made_of_added_links_is_the_cart_pole() -> None:
    # The pole: a rod of 0.5 kg and 0.5 m; as a box of 0.5 m by a by a, a^2 = 1e-5 * 6 / 0.5.
    edge = math.sqrt(1e-5 * 6 / 0.5)
    robot = load("cartpole")
    made = vary(
        robot,
        Drop(link="pole"),
        Add(link="pole", parent="cart", mass=0.5, shape="box", size=(edge, edge, 0.5),
            centre=(0.0, 0.0, -0.25), joint="hinge", axis=(0.0, -1.0, 0.0)),
    )  # fmt: skip
    pair = [mass_matrix(spec_of(each).compile(), np.array([0.1, 0.8])) for each in (robot, made)]
    # The box is a little thick: its inertia across exceeds the rod's by m a^2 / 12 = 5e-6.
    assert np.abs(pair[0] - pair[1]).max() == pytest.approx(5e-6, rel=1e-9)


def test_what_goes_with_a_locked_joint_is_named() -> None:
    gone = removed(load("cartpole"), Lock(joint="slide"))
    assert gone == ("joint 'slide'", "actuator 'slide'")
    assert "actuator 'Jaw'" in removed(load("so101"), Drop(link="wrist"))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Scale(link="pole", factor=0.0), "factor is 0.0, not between 1e-06 and 1e"),
        (lambda: Scale(link="pole", factor=1e300), "factor is 1e\\+300, not between 1e-06 and 1e"),
        (
            lambda: Scale(link="pole", factor=2.0, along=(0.0, 0.0, 1e-300)),
            "along has no direction",
        ),
        (lambda: Scale(link="pole", factor=math.inf), "factor is inf"),
        (lambda: Heavier(link="pole", add=-0.5), r"leaves 0 kg of 0\.5 kg"),
        (lambda: Scale(link="pol", factor=2.0), "no link 'pol'; the nearest names are 'pole'"),
        (lambda: Lock(joint="hing"), "no joint 'hing'; the nearest names are 'hinge'"),
        (lambda: Lock(joint="slide", at=math.nan), "at is nan, not finite"),
        (lambda: Drop(link="cart"), "no link would be left"),
        (lambda: Stiffen(joint="hinge", stiffness=-1.0), "stiffness is -1.0, below 0"),
        (lambda: Add(link="pole", parent="cart", mass=1.0), "the link 'pole' is there already"),
        (lambda: Add(link="a", parent="b", mass=1.0), "no link 'b'"),
        (lambda: Add(link="a", parent="cart", mass=1.0, shape="cone"), "shape is 'cone'"),
    ],
)
def test_what_cannot_be_done_is_refused_by_name(make: Any, words: str) -> None:
    with pytest.raises(RobotError, match=words):
        vary(load("cartpole"), make())


def test_a_robot_without_joints_has_nothing_to_lock() -> None:
    bare = vary(load("pendulum"), Lock(joint="hinge"))
    with pytest.raises(RobotError, match="nothing to lock"):
        vary(bare, Lock(joint="hinge"))
