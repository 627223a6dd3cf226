"""The humanoid, the same on a skateboard, and the biped against what is known of them."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from typing import Any

import mujoco
import numpy as np
import pytest

from morph.arrays import Array
from morph.body import shelf

MIRROR = np.array([1.0, -1.0, 1.0])
"""What the plane between left and right does to a point."""


def path(name: str) -> str:
    return str(shelf.builtin_shelf() / name / "robot.xml")


def resting(name: str) -> tuple[Any, Any]:
    model = mujoco.MjModel.from_xml_path(path(name))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


def on_floor(name: str) -> Any:
    spec = mujoco.MjSpec.from_file(path(name))
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[3, 3, 0.1])
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    return spec.compile()


def ends(model: Any, data: Any, geom: int) -> tuple[float, float]:
    """Return the least and the greatest height of a shape."""
    up, size = data.geom_xmat[geom].reshape(3, 3)[2], model.geom_size[geom]
    kind = mujoco.mjtGeom(model.geom_type[geom])
    flat = math.hypot(up[0], up[1])
    half = {
        mujoco.mjtGeom.mjGEOM_BOX: np.abs(up) @ size,
        mujoco.mjtGeom.mjGEOM_ELLIPSOID: float(np.linalg.norm(up * size)),
        mujoco.mjtGeom.mjGEOM_SPHERE: size[0],
        mujoco.mjtGeom.mjGEOM_CAPSULE: size[0] + abs(up[2]) * size[1],
        mujoco.mjtGeom.mjGEOM_CYLINDER: flat * size[0] + abs(up[2]) * size[1],
    }[kind]
    return data.geom_xpos[geom, 2] - half, data.geom_xpos[geom, 2] + half


def partner(name: str) -> str:
    if name.startswith(("l_", "r_")):
        return {"l": "r", "r": "l"}[name[0]] + name[1:]
    for side, other in (("left_", "right_"), ("right_", "left_")):
        if name.startswith(side):
            return other + name.removeprefix(side)
    return name


def tensor(model: Any, body: int) -> Array:
    axes = np.zeros(9)
    mujoco.mju_quat2Mat(axes, model.body_iquat[body])
    axes = axes.reshape(3, 3)
    return np.asarray(axes @ np.diag(model.body_inertia[body]) @ axes.T)


def test_the_humanoid_is_084_m_tall_and_weighs_3_kg() -> None:
    model, data = resting("humanoid")
    heights = [ends(model, data, geom) for geom in range(model.ngeom)]
    assert min(low for low, _ in heights) == pytest.approx(0.0, abs=1e-12)
    assert max(high for _, high in heights) == pytest.approx(0.84, abs=1e-12)
    assert model.body_mass.sum() == pytest.approx(3.0, abs=1e-12)
    assert model.nu == 25


@pytest.mark.parametrize("name", ["humanoid", "biped"])
def test_left_and_right_are_mirror_images(name: str) -> None:
    model, _ = resting(name)
    for body in range(1, model.nbody):
        other = model.body(partner(model.body(body).name)).id
        assert model.body_mass[body] == model.body_mass[other]
        assert model.body_pos[body] * MIRROR == pytest.approx(model.body_pos[other], abs=1e-15)
        assert model.body_ipos[body] * MIRROR == pytest.approx(model.body_ipos[other], abs=1e-12)
        mirrored = np.outer(MIRROR, MIRROR) * tensor(model, body)
        # Twelve digits are written of moments of 1e-3 kg m2.
        assert np.abs(mirrored - tensor(model, other)).max() < 1e-12
    for joint in range(model.njnt):
        if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_HINGE:
            other = model.joint(partner(model.joint(joint).name)).id
            assert tuple(model.jnt_range[joint]) == tuple(model.jnt_range[other])


def test_pitch_joints_turn_the_same_way_and_mirrored_joints_outward() -> None:
    model, data = resting("humanoid")
    for joint in range(model.njnt):
        name = model.joint(joint).name
        if name.endswith("_y"):
            assert tuple(data.xaxis[joint]) == (0.0, 1.0, 0.0), name
        elif partner(name) != name:
            # A mirror turns a turn about: the axis of a reflected rotation is -reflection.
            other = model.joint(partner(name)).id
            assert data.xaxis[joint] == pytest.approx(-MIRROR * data.xaxis[other]), name


@pytest.mark.parametrize("name", ["humanoid", "biped"])
def test_equal_commands_left_and_right_give_mirrored_poses(name: str) -> None:
    model, data = resting(name)
    rng, joints = np.random.default_rng(5), range(model.njnt)
    for _ in range(10):
        for joint in joints:
            own = model.joint(joint).name
            if partner(own) != own:
                low, high = model.jnt_range[joint]
                angle = rng.uniform(low, high)
                for side in (own, partner(own)):
                    data.joint(side).qpos[0] = angle
        mujoco.mj_kinematics(model, data)
        for body in range(1, model.nbody):
            other = model.body(partner(model.body(body).name)).id
            assert data.xipos[body] * MIRROR == pytest.approx(data.xipos[other], abs=1e-12)


@pytest.mark.parametrize(
    ("joint", "site", "way"),
    [
        ("l_hip_y", "left_toe", (-1, 0, 0)),  # A hanging limb swings back,
        ("l_elbow_y", "left_hand", (-1, 0, 0)),
        ("abs_y", "eyes", (1, 0, 0)),  # the trunk leans forward,
        ("l_hip_x", "left_heel", (0, 1, 0)),  # a leg and an arm go outward,
        ("l_shoulder_x", "left_hand", (0, 1, 0)),
        ("l_hip_z", "left_toe", (0, 1, 0)),  # and toes turn out.
        ("r_hip_z", "right_toe", (0, -1, 0)),
    ],
)
def test_a_positive_angle_moves_as_the_card_says(
    joint: str, site: str, way: tuple[int, int, int]
) -> None:
    model, data = resting("humanoid")
    before = data.site(site).xpos.copy()
    data.joint(joint).qpos[0] = 0.01
    mujoco.mj_kinematics(model, data)
    moved = data.site(site).xpos - before
    assert moved @ way > 0.0005
    assert moved @ way > 0.9 * np.abs(moved).max()


def over(data: Any, model: Any, pelvis: str) -> tuple[Array, Array, Array]:
    """Return the centre of mass, and the corners that heels and toes span, m."""
    tips = [data.site(f"{s}_{t}").xpos for s in ("left", "right") for t in ("heel", "toe")]
    return data.subtree_com[model.body(pelvis).id], np.min(tips, axis=0), np.max(tips, axis=0)


@pytest.mark.parametrize(("name", "seconds"), [("humanoid", 5.0), ("humanoid_skateboard", 5.0)])
def test_with_its_servos_at_home_it_stands(name: str, seconds: float) -> None:
    # Leaning as one on two ankles of 12.6 N m/rad it resists by 25.2 N m/rad, and falls by
    # 3 kg * 9.81 m/s2 * (0.469 - 0.040) m = 12.6 N m/rad: it stands, with some sway.
    model = on_floor(name)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    start = float(data.subtree_com[model.body("pelvis").id][2])
    while data.time < seconds:
        mujoco.mj_step(model, data)
        centre, low, high = over(data, model, "pelvis")
        assert low[0] < centre[0] < high[0]
        assert low[1] < centre[1] < high[1]
    assert centre[2] == pytest.approx(start, abs=0.01)


def test_without_servos_it_falls() -> None:
    # So that the test above can fail.
    model = on_floor("humanoid")
    model.actuator_gainprm[:] = model.actuator_biasprm[:] = 0.0
    data = mujoco.MjData(model)
    while data.time < 2.0:
        mujoco.mj_step(model, data)
    assert data.subtree_com[model.body("pelvis").id][2] < 0.25


def humanoid_in(name: str) -> ElementTree.Element:
    """Return the humanoid's part of a description, without its root and place."""
    pelvis = ElementTree.parse(path(name)).find(".//body[@name='pelvis']")
    assert pelvis is not None
    del pelvis.attrib["pos"]
    roots = [part for part in pelvis if "root" in part.get("name", "")]
    assert {part.tag for part in roots} <= {"freejoint", "joint"}
    for part in roots:
        pelvis.remove(part)
    for part in pelvis.iter():
        part.text = part.tail = None
    return pelvis


def test_the_humanoid_on_the_board_is_the_humanoid() -> None:
    alone, aboard = humanoid_in("humanoid"), humanoid_in("humanoid_skateboard")
    assert len(list(alone.iter("joint"))) == 25
    assert ElementTree.tostring(alone) == ElementTree.tostring(aboard)
    for part in ("default", "actuator"):
        texts = []
        for name in ("humanoid", "humanoid_skateboard"):
            found = ElementTree.parse(path(name)).find(part)
            assert found is not None
            texts.append("".join(ElementTree.tostring(found, encoding="unicode").split()))
        assert texts[0] == texts[1]
    alone_model, aboard_model = resting("humanoid")[0], resting("humanoid_skateboard")[0]
    raised = aboard_model.body("board").pos + aboard_model.body("pelvis").pos
    # Deck at 0.0845 m, 0.0055 m to its top: the soles stand 0.09 m higher.
    assert raised - alone_model.body("pelvis").pos == pytest.approx([0, 0, 0.09], abs=1e-15)


@pytest.mark.parametrize("lean", [-0.2, -0.05, 0.1, 0.25])
def test_a_deck_that_leans_steers_its_axles_as_hubbard_says(lean: float) -> None:
    # Hubbard 1979: an axle that stays level steers by tan = tan(pivot) sin(lean); pivot 45
    # degrees. A lean about +x is to the right, and turns the front axle to the right, -z.
    model, data = resting("humanoid_skateboard")
    half = lean / 2
    data.joint("board").qpos[3:] = math.cos(half), math.sin(half), 0, 0

    def axle(truck: str, angle: float) -> Array:
        data.joint(truck).qpos[0] = angle
        mujoco.mj_kinematics(model, data)
        return np.array(data.body(truck).xmat.reshape(3, 3)[:, 1])

    for truck, sign in (("front_truck", -1.0), ("rear_truck", 1.0)):
        low, high = -0.6, 0.6
        for _ in range(60):
            middle = (low + high) / 2
            rises = axle(truck, middle)[2] > 0.0
            low, high = (low, middle) if rises else (middle, high)
        across = axle(truck, low)
        assert across[2] == pytest.approx(0.0, abs=1e-12)
        steer = math.atan2(-across[0], across[1])
        assert math.tan(steer) == pytest.approx(sign * math.sin(lean), abs=1e-12)


def test_the_board_rolls_and_turns_to_the_side_it_leans_to() -> None:
    model = on_floor("humanoid_skateboard")
    data = mujoco.MjData(model)
    data.qvel[0] = 0.5
    for wheel in ("front_left", "front_right", "rear_left", "rear_right"):
        data.joint(f"{wheel}_wheel").qvel[0] = 0.5 / 0.026
    while data.time < 1.0:
        # 2 N m about +x press the deck's right side down.
        data.xfrc_applied[model.body("board").id, 3] = 2.0
        mujoco.mj_step(model, data)
    assert data.body("board").xpos[0] > 0.3
    assert data.body("board").xpos[1] < -0.001
    forward = data.body("board").xmat.reshape(3, 3)[:, 0]
    assert math.atan2(forward[1], forward[0]) < -0.005


@pytest.mark.parametrize(("link", "proximal"), [("left_thigh", 0.540), ("left_shank", 0.528)])
def test_a_limb_of_the_biped_swings_about_its_upper_joint_as_winter_says(
    link: str, proximal: float
) -> None:
    # Winter 2009, table 4.1, has the radius of gyration about the upper joint in a column of
    # its own, to three digits; the body was made from the other columns.
    model, _ = resting("biped")
    body = model.body(link).id
    length = {"left_thigh": 0.245, "left_shank": 0.246}[link] * 1.75
    about_joint = tensor(model, body)[1, 1] + model.body_mass[body] * model.body_ipos[body, 2] ** 2
    radius = math.sqrt(about_joint / model.body_mass[body]) / length
    assert radius == pytest.approx(proximal, abs=0.001)


def test_the_biped_stands_on_flat_soles_at_zero() -> None:
    model, data = resting("biped")
    lowest = min(ends(model, data, geom)[0] for geom in range(model.ngeom))
    assert lowest == pytest.approx(0.0, abs=1e-12)
    centre, low, high = over(data, model, "torso")
    assert low[0] < centre[0] < high[0]
    # Winter's shares of a body add up to the whole.
    assert model.body_mass.sum() == pytest.approx(70.0, abs=1e-12)
