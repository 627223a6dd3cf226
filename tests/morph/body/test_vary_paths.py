"""Bodies between two: their ends, that they can exist, and how absent links stand still."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Link, Robot
from morph.body.spec import spec_of
from morph.body.vary import Drop, Heavier, Lock, Scale, interpolate, path, vary
from morph.errors import RobotError


def described(name: str, text: str, folder: Path) -> Robot:
    """Return the robot of an MJCF text."""
    (folder / f"{name}.xml").write_text(f"<mujoco model='{name}'>{text}</mujoco>")
    return load(folder / f"{name}.xml")


def swing(robot: Robot, start: dict[str, float], seconds: float = 0.5) -> Array:
    """Return the positions of joints along a fall from a start, shape (time, joints)."""
    model = spec_of(robot).compile()
    data = mujoco.MjData(model)
    for joint, position in start.items():
        data.joint(joint).qpos = position
    found = []
    for _ in range(round(seconds / 0.002)):
        mujoco.mj_step(model, data)
        found.append([float(data.joint(joint).qpos[0]) for joint in start])
    return np.array(found)


def second_moments(link: Link) -> Array:
    """Return the pseudo-inertia of a link from its inertia, shape (4, 4)."""
    xx, yy, zz, xy, xz, yz = link.inertia
    inertia = np.array(((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)))
    com = np.array(link.com)
    found = np.zeros((4, 4))
    found[:3, :3] = np.trace(inertia) / 2 * np.eye(3) - inertia + link.mass * np.outer(com, com)
    found[:3, 3] = found[3, :3] = link.mass * com
    found[3, 3] = link.mass
    return found


def test_the_ends_of_a_way_through_one_topology_are_the_two_bodies() -> None:
    first, second = load("double_pendulum"), load("double_pendulum_a0")
    ends = interpolate(first, second, 0.0), interpolate(first, second, 1.0)
    start = {"shoulder": 2.0, "elbow": -1.0}
    for end, robot in zip(ends, (first, second), strict=True):
        assert end.links == robot.links
        assert end.joints == robot.joints
        assert end.actuators == robot.actuators
        assert (swing(end, start) == swing(robot, start)).all()


def test_masses_go_in_geometric_steps_and_centres_in_a_straight_line() -> None:
    first, second = load("cartpole"), vary(load("cartpole"), Scale(link="pole", factor=2.0))
    poles = [robot.link("pole") for robot in path(first, second, 3)]
    # 0.5 kg times 8^(k / 3), and 0.25 m to 0.5 m.
    assert [pole.mass for pole in poles] == pytest.approx([0.5, 1.0, 2.0, 4.0], rel=1e-9)
    heights = [-0.25, -1 / 3, -5 / 12, -0.5]
    assert [pole.com[2] for pole in poles] == pytest.approx(heights, rel=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_every_body_between_two_that_can_exist_can_exist(seed: int, tmp_path: Path) -> None:
    # Ends of four random point masses each: any frame, any flatness.
    rng = np.random.default_rng(seed)
    ends = []
    for name in ("first", "second"):
        points = rng.normal(size=(4, 3)) * rng.uniform(0.01, 1.0, size=3)
        masses = rng.uniform(0.01, 3.0, size=4)
        com = masses @ points / masses.sum()
        arm = points - com
        inertia = sum(
            m * (r @ r * np.eye(3) - np.outer(r, r)) for m, r in zip(masses, arm, strict=True)
        )
        full = " ".join(repr(float(inertia[i, j])) for i, j in
                        ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))  # fmt: skip
        text = (
            f"<worldbody><body name='link'><inertial pos='{com[0]} {com[1]} {com[2]}'"
            f" mass='{masses.sum()}' fullinertia='{full}'/><joint name='hinge'/></body></worldbody>"
        )
        ends.append(described(name, text, tmp_path))
    for body in path(*ends, 8):
        assert np.linalg.eigvalsh(second_moments(body.links[0])).min() > 0


def test_the_inertia_of_a_flat_body_goes_in_a_straight_line() -> None:
    first = load("cartpole")
    text = first.mjcf.replace('diaginertia="0.001 0.001 0.001"', 'diaginertia="0.001 0.001 0.002"')
    assert text != first.mjcf
    flat = vary(Robot(**{**vars(first), "mjcf": text}), Heavier(link="*", factor=3.0))
    between = interpolate(first, flat, 0.5).link("cart")
    # Half of 0.5 kg and half of 1.5 kg; a plate: its inertias across add up to that about
    # its normal. Half of 0.001 and of 3 * 0.001 kg m2, half of 0.001 and of 3 * 0.002.
    assert between.mass == pytest.approx(1.0)
    assert between.inertia[:3] == pytest.approx([0.002, 0.002, 0.0035])


@pytest.mark.parametrize("fraction", [0.0, 0.2, 0.5, 0.8, 1.0])
@pytest.mark.parametrize(
    ("one", "other"), [("double_pendulum", "double_pendulum_a0"), ("hopper", "biped")]
)
def test_the_way_back_leads_through_the_same_bodies(one: str, other: str, fraction: float) -> None:
    first, second = load(one), load(other)
    there, back = interpolate(first, second, fraction), interpolate(second, first, 1 - fraction)
    # Parts are named after the first body, and those of one body stand behind the others.
    masses = [sorted(link.mass for link in robot.links) for robot in (there, back)]
    assert masses[0] == pytest.approx(masses[1], rel=1e-9)
    assert len(there.joints) == len(back.joints)
    if one == "double_pendulum":
        for link in there.links:
            assert link.inertia == pytest.approx(back.link(link.name).inertia, rel=1e-9, abs=1e-15)


def longest(difference: Array) -> float:
    return float(np.abs(difference).max())


@pytest.mark.parametrize(
    ("one", "other"),
    [("cart_two_links", "cart_three_links"), ("cartpole", "cart_five_links"), ("hopper", "biped")],
)
def test_a_body_with_absent_links_moves_as_the_body_without(one: str, other: str) -> None:
    # An absent link weighs 0.03^3 = 3e-5 of itself. It changes accelerations of at most
    # 100 rad/s^2 by less than that share, so in 0.5 s the motion by 100 * 3e-5 / 8 = 4e-4.
    first, second = load(one), load(other)
    for robot, end in ((first, interpolate(first, second, 0.0)),
                       (second, interpolate(second, first, 0.0))):  # fmt: skip
        start = {j.name: 0.1 for j in robot.joints if j.kind in ("hinge", "slide")}
        assert longest(swing(end, start) - swing(robot, start)) < 4e-4


def test_all_bodies_of_a_way_have_the_same_parts_in_the_same_order() -> None:
    bodies = path(load("cart_two_links"), load("cart_five_links"), 5)
    parts = {
        tuple(part.name for part in (*body.links, *body.joints, *body.actuators)) for body in bodies
    }
    assert len(parts) == 1
    assert [body.mass for body in bodies] == sorted(body.mass for body in bodies)
    assert len({body.sha256 for body in bodies}) == 6


LEG = "<inertial pos='0 0 -0.2' mass='1' diaginertia='0.02 0.02 0.001'/>"


def test_a_link_can_grow_between_two_others(tmp_path: Path) -> None:
    foot = f"<body name='foot' pos='0.1 0 -0.4'>{LEG}<joint name='ankle' axis='0 1 0'/></body>"
    hip = f"<body name='hip'>{LEG}<joint name='hip' axis='0 1 0'/>"
    one = f"<worldbody>{hip}{foot}</body></worldbody>"
    joint = "<joint name='knee' axis='0 1 0'/>"
    knee = f"<body name='shank' pos='0 0 -0.3' quat='0.8 0 0.6 0'>{LEG}{joint}"
    other = one.replace(foot, f"{knee}{foot}</body>")
    first, second = described("one", one, tmp_path), described("other", other, tmp_path)
    start = {"hip": 0.5, "ankle": -0.3}
    none = interpolate(first, second, 0.0)
    assert [joint.name for joint in none.joints] == ["hip", "knee", "ankle"]
    # The same arithmetic as above.
    assert longest(swing(none, start) - swing(first, start)) < 4e-4
    whole = interpolate(first, second, 1.0)
    start["knee"] = 0.4
    assert (swing(whole, start) == swing(second, start)).all()


@pytest.mark.parametrize("presence", [0.02, 0.1, 0.3])
def test_a_link_that_is_little_there_sags_as_the_law_of_its_lock_says(presence: float) -> None:
    # r = w a T^2 with T = 0.1 s * w / (1 - w). A rod that lies level at the scale s has the
    # torque m g l / 2 s^4 and the inertia m l^2 / 3 s^5, beside 1e-12 and the rotor's
    # m_robot l^2 (1 - w)^3 with l = 0.1 m; the pole's mass is 0.5 kg, its length 0.5 m.
    robot = load("cartpole")
    bare = vary(robot, Drop(link="pole"))
    between = interpolate(bare, robot, presence)
    # T is 2 ms at the least presence: two timesteps are less.
    model = spec_of(between, timestep=0.0005).compile()
    # Level: gravity points along x instead of z.
    model.opt.gravity[:] = 9.82, 0.0, 0.0
    model.dof_frictionloss[0] = 1e6
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 4000)
    s, free = 0.03 + 0.97 * presence, 1 - presence
    torque = 0.5 * 9.82 * 0.25 * s**4
    inertia = (0.5 * 0.5**2 / 3) * s**5 + free * 1e-12 + 1.0 * 0.1**2 * free**3
    sag = presence * torque / inertia * (0.1 * presence / free) ** 2
    assert float(data.joint("hinge").qpos[0]) == pytest.approx(sag, rel=0.01)


def test_a_joint_with_the_opposite_axis_counts_the_other_way() -> None:
    cart, rider = load("cart_two_links"), load("rider_two_links_driven")
    end = interpolate(cart, rider, 1.0)
    names = [joint.name for joint in rider.joints]
    ours = [joint.name for joint in end.joints][: len(names)]
    signs = [
        np.sign(np.dot(end.joint(one).axis, rider.joint(other).axis))
        for one, other in zip(ours, names, strict=True)
    ]
    assert -1.0 in signs
    start = dict(zip(names, (0.05, 0.1, -0.1), strict=False))
    turned = {one: sign * start[name] for one, sign, name in zip(ours, signs, names, strict=True)}
    gap = swing(end, turned) * np.array(signs) - swing(rider, start)
    # As above; equal topology would leave rounding only.
    assert longest(gap) < 4e-4


def test_a_limit_that_one_body_has_widens_until_it_is_gone(tmp_path: Path) -> None:
    joint = "<joint name='hip' RANGE axis='0 1 0'/>"
    text = f"<worldbody><body name='hip'>{LEG}{joint}</body></worldbody>"
    free = described("free", text.replace("RANGE", ""), tmp_path)
    held = described("held", text.replace("RANGE", "range='-60 30'"), tmp_path)
    limits = [body.joint("hip").limits for body in path(free, held, 2)]
    assert limits[0] is None
    # Half there: twice as wide; radians.
    assert limits[1] == pytest.approx(np.radians((-120, 60)))
    assert limits[2] == pytest.approx(np.radians((-60, 30)))


def test_a_mapping_decides_what_grows_and_what_becomes_what() -> None:
    first, second = load("cartpole"), load("cart_two_links")
    names = [link.name for link in second.links]
    given = {"cart": names[0], "pole": names[2]}
    between = interpolate(first, second, 0.5, mapping=given)
    assert {"cart", "pole", names[1]} == {link.name for link in between.links}
    apart = interpolate(first, second, 0.5, mapping={})
    assert len(apart.links) == 5


def test_a_loop_grows_with_the_links_that_it_holds() -> None:
    loops = [
        int(spec_of(body).compile().neq) - sum("fading" in name for name in ties(body))
        for body in path(load("pendulum"), load("quadruped_four_bar"), 2)
    ]
    whole = int(spec_of(load("quadruped_four_bar")).compile().neq)
    assert loops == [0, whole, whole]


def ties(robot: Robot) -> Sequence[str]:
    return [str(each.name) for each in spec_of(robot).equalities]


def refusals() -> list[tuple[Any, str]]:
    cart, two = "cartpole", "cart_two_links"
    return [
        (lambda: interpolate(load(cart), load(two), 1.5), "the fraction is 1.5"),
        (lambda: interpolate(load(cart), load(two), 0.5, smallest=0.0), "smallest is 0.0"),
        (lambda: path(load(cart), load(two), 0), "steps is 0"),
        (lambda: interpolate(load(cart), load(two), 0.5, mapping={"pol": "cart"}), "nearest"),
        (
            lambda: interpolate(
                load(cart), load(two), 0.5, mapping={"cart": "cart", "pole": "cart"}
            ),
            "gives one link two counterparts",
        ),
        (
            lambda: interpolate(load("humanoid"), load("rider_five_links_driven"), 0.5),
            "no link can",
        ),
    ]


@pytest.mark.parametrize(("act", "words"), refusals())
def test_a_way_that_cannot_be_is_refused_by_name(act: Any, words: str) -> None:
    with pytest.raises(RobotError, match=words):
        act()


def test_locked_bodies_and_longer_ones_lie_on_ways_as_others_do() -> None:
    first = load("so101")
    second = vary(first, Lock(joint="Wrist_Roll"), Scale(link="lower_arm", factor=1.5))
    for one, other in itertools.pairwise(path(first, second, 4)):
        assert other.mass > one.mass
        assert [joint.name for joint in other.joints] == [joint.name for joint in first.joints]
