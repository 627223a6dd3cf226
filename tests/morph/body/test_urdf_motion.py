"""Robots move as Pinocchio and yourdfpy read in the same text, and as the definitions say."""

from __future__ import annotations

import io
import math
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pinocchio
import pytest
import yourdfpy
from scipy.spatial.transform import Rotation

from morph.body.load import load
from morph.body.spec import spec_of

TREES = 30
"""Random trees that are compared."""


def numbers(values: Any) -> str:
    return " ".join(repr(float(value)) for value in values)


def inertial(rng: np.random.Generator) -> str:
    """Return a random inertial, of a cloud of points, so that a body can have it."""
    points = rng.normal(scale=0.1, size=(6, 3))
    points -= points.mean(axis=0)
    mass = float(rng.uniform(0.1, 5))
    second = points.T @ points * mass / 6
    inertia = np.trace(second) * np.eye(3) - second
    values = {f"i{'xyz'[i]}{'xyz'[j]}": inertia[i, j] for i in range(3) for j in range(i, 3)}
    given = " ".join(f'{key}="{float(value)!r}"' for key, value in values.items())
    xyz, rpy = numbers(rng.normal(scale=0.1, size=3)), numbers(rng.uniform(-4, 4, 3))
    return (
        f'<inertial><origin xyz="{xyz}" rpy="{rpy}"/>'
        f'<mass value="{mass!r}"/><inertia {given}/></inertial>'
    )


def random_tree(seed: int) -> str:
    """Return a URDF of up to 14 links, whose joints are of every kind with one freedom or none."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 15))
    elements = [f'<link name="l{at}">{inertial(rng)}</link>' for at in range(count)]
    for child in range(1, count):
        kind = str(rng.choice(["revolute", "continuous", "prismatic", "fixed"]))
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        xyz, rpy = numbers(rng.normal(scale=0.3, size=3)), numbers(rng.uniform(-4, 4, 3))
        elements.append(
            f'<joint name="j{child}" type="{kind}"><parent link="l{int(rng.integers(child))}"/>'
            f'<child link="l{child}"/><origin xyz="{xyz}" rpy="{rpy}"/>'
            f'<axis xyz="{numbers(axis)}"/>'
            '<limit lower="-3" upper="3" effort="10" velocity="10"/></joint>'
        )
    rng.shuffle(elements)
    return "<robot name='tree'>" + "\n".join(elements) + "</robot>"


def written(folder: Path, text: str) -> Path:
    path = folder / "robot.urdf"
    path.write_text(text)
    return path


@pytest.mark.parametrize("seed", range(TREES))
def test_poses_and_mass_matrix_of_a_random_tree_are_those_of_pinocchio_and_yourdfpy(
    bench: Any, tmp_path: Path, seed: int
) -> None:
    text = random_tree(seed)
    reading = bench.open(written(tmp_path, text))
    assert reading.findings == ()
    model = spec_of(reading.robot).compile()
    data = mujoco.MjData(model)
    other = pinocchio.buildModelFromXML(text)
    other_data = other.createData()
    names = [joint.name for joint in reading.robot.joints]
    assert set(names) == set(other.names[1:])
    turns = np.random.default_rng(seed + 1000).uniform(-2, 2, len(names))
    position = pinocchio.neutral(other)
    for name, value in zip(names, turns, strict=True):
        data.qpos[model.joint(name).qposadr[0]] = value
        joint = other.joints[other.getJointId(name)]
        # Pinocchio holds the angle of a continuous joint as its cosine and sine.
        held = [value] if joint.nq == 1 else [math.cos(value), math.sin(value)]
        position[joint.idx_q : joint.idx_q + joint.nq] = held
    mujoco.mj_forward(model, data)
    pinocchio.framesForwardKinematics(other, other_data, position)
    third = yourdfpy.URDF.load(io.BytesIO(text.encode()), load_meshes=False)
    third.update_cfg({n: v for n, v in zip(names, turns, strict=True) if n in third.joint_map})
    for link in reading.robot.links:
        placed = other_data.oMf[other.getFrameId(link.name, pinocchio.FrameType.BODY)]
        body = data.body(link.name)
        # Some metres, through a dozen links, by quaternions: some roundings of 1e-16.
        assert body.xpos == pytest.approx(placed.translation, abs=1e-9)
        assert body.xmat.reshape(3, 3) == pytest.approx(placed.rotation, abs=1e-9)
        seen = third.get_transform(link.name, third.base_link)
        assert body.xpos == pytest.approx(seen[:3, 3], abs=1e-9)
        assert body.xmat.reshape(3, 3) == pytest.approx(seen[:3, :3], abs=1e-9)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    upper = np.triu(pinocchio.crba(other, other_data, position)) if other.nv else full
    ours = [int(model.joint(name).dofadr[0]) for name in names]
    theirs = [other.joints[other.getJointId(name)].idx_v for name in names]
    expected = (upper + np.triu(upper, 1).T)[np.ix_(theirs, theirs)] if names else full
    assert full[np.ix_(ours, ours)] == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("kind", ["revolute", "continuous", "prismatic", "planar", "floating"])
@pytest.mark.parametrize("base", ["fixed", "floating"])
def test_each_kind_of_joint_has_the_inertia_that_pinocchio_finds(
    bench: Any, kind: str, base: str
) -> None:
    rng = np.random.default_rng(5)
    reading = bench.read(
        *(f'<link name="{name}">{inertial(rng)}</link>' for name in ("trunk", "arm", "hand")),
        bench.joint(
            *("shoulder", "trunk", "arm", kind),
            '<limit lower="-1" upper="1" effort="1" velocity="1"/>',
            xyz="0.1 0.2 0.3",
        ),
        bench.joint("wrist", "arm", "hand", axis="0 1 0", xyz="0 0.1 0.4"),
        base=base,
    )
    assert reading.findings == ()
    model = spec_of(reading.robot).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    root = (pinocchio.JointModelFreeFlyer(),) if base == "floating" else ()
    other = pinocchio.buildModelFromXML(reading.path.read_text(), *root)
    other_data = other.createData()
    home = pinocchio.neutral(other)
    upper = np.triu(pinocchio.crba(other, other_data, home))
    pinocchio.forwardKinematics(other, other_data, home)
    masses = np.array([inertia.mass for inertia in other.inertias])
    centres = [other_data.oMi[k].act(other.inertias[k].lever) for k in range(other.njoints)]
    assert model.nv == {"planar": 3, "floating": 6}.get(kind, 1) + 1 + 6 * len(root)
    assert model.body_mass.sum() == pytest.approx(masses.sum(), rel=1e-12)
    assert data.subtree_com[0] == pytest.approx(masses @ centres / masses.sum(), abs=1e-9)
    # The figure: equal eigenvalues of the joint-space inertia to 1e-9.
    expected = np.linalg.eigvalsh(upper + np.triu(upper, 1).T)
    assert np.linalg.eigvalsh(full) == pytest.approx(expected, rel=1e-9, abs=1e-9)


def moved(bench: Any, joint: str, position: float) -> tuple[np.ndarray, np.ndarray]:
    """Return where a link stands once its joint is at a position."""
    reading = bench.read(bench.link("a"), bench.link("b"), joint)
    assert reading.findings == ()
    model = spec_of(reading.robot).compile()
    data = mujoco.MjData(model)
    if model.nq:
        data.qpos[:] = position
    mujoco.mj_kinematics(model, data)
    return data.body("b").xpos.copy(), data.body("b").xmat.reshape(3, 3).copy()


LIMIT = '<limit lower="-2" upper="2" effort="1" velocity="1"/>'


@pytest.mark.parametrize("kind", ["revolute", "continuous"])
def test_a_turning_joint_turns_about_its_axis_by_the_right_hand(bench: Any, kind: str) -> None:
    joint = bench.joint("j", "a", "b", kind, LIMIT, xyz="1 2 3", axis="0 0 1")
    where, axes = moved(bench, joint, 0.5)
    assert where == pytest.approx([1, 2, 3])
    assert axes == pytest.approx(Rotation.from_euler("z", 0.5).as_matrix())


def test_a_sliding_joint_slides_along_its_axis_in_the_turned_frame(bench: Any) -> None:
    joint = bench.joint("j", "a", "b", "prismatic", LIMIT, axis="0 0 1").replace(
        'xyz="0 0 0"', f'xyz="1 2 3" rpy="{math.pi / 2!r} 0 0"'
    )
    where, axes = moved(bench, joint, 0.5)
    # Turned about x by a quarter, z looks along -y.
    assert where == pytest.approx([1, 1.5, 3])
    assert axes == pytest.approx(Rotation.from_euler("x", math.pi / 2).as_matrix())


def test_a_joint_without_an_axis_turns_about_x(bench: Any) -> None:
    joint = bench.joint("j", "a", "b").replace('<axis xyz="0 0 1"/>', "")
    _, axes = moved(bench, joint, 0.5)
    assert axes == pytest.approx(Rotation.from_euler("x", 0.5).as_matrix())


def test_joints_and_motors_stand_in_the_order_of_the_file(tmp_path: Path) -> None:
    inertial = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>'
    text = '<robot name="hand"><link name="palm"/>'
    for finger in ("thumb", "index", "ring"):
        for number, parent in ((1, "palm"), (2, f"{finger}_1")):
            name = f"{finger}_{number}"
            text += f'<link name="{name}">{inertial}</link>'
            text += f'<joint name="{name}" type="continuous"><parent link="{parent}"/>'
            text += f'<child link="{name}"/></joint>'
    path = tmp_path / "hand.urdf"
    path.write_text(text + "</robot>")
    robot = load(path)
    wanted = ["thumb_1", "thumb_2", "index_1", "index_2", "ring_1", "ring_2"]
    assert [joint.name for joint in robot.joints] == wanted
    assert [actuator.joint for actuator in robot.actuators] == wanted
