"""Small bodies, and random trees of bodies, to put into the water."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.physics.fluid import numbers as at
from morph.physics.fluid.kernel import install
from morph.physics.fluid.settle import settle

HINGE, SLIDE, BALL, FREE = (
    mujoco.mjtJoint.mjJNT_HINGE,
    mujoco.mjtJoint.mjJNT_SLIDE,
    mujoco.mjtJoint.mjJNT_BALL,
    mujoco.mjtJoint.mjJNT_FREE,
)
KINDS = ((HINGE,), (SLIDE,), (BALL,), (SLIDE, HINGE), ())
"""The joints of a branch; none where it is welded to its parent."""


def numbers(rng: np.random.Generator, *, ideal: bool) -> list[float]:
    """Random numbers of a wet body; an ideal fluid neither lifts, drags, flows nor sheds."""
    root = rng.normal(size=(6, 6))
    found = np.zeros(at.WIDTH)
    found[at.MARK], found[at.SCALE] = at.SIGNATURE, 1.0
    found[at.ADDED] = (root @ root.T + np.eye(6))[np.triu_indices(6)]
    found[at.POINT] = rng.uniform(-0.1, 0.1, 3)
    if ideal:
        return list(found)
    found[at.SCALE] = rng.choice((0.0, 0.5, 1.0))
    found[at.DISPLACED], found[at.CENTRE] = 3.0, rng.uniform(-0.1, 0.1, 3)
    found[at.LINEAR], found[at.QUADRATIC] = rng.uniform(0.0, 1.0, (2, 6))
    found[at.APART] = rng.choice((0.0, 1.0)) * rng.uniform(-0.1, 0.1, 3)
    found[at.CURRENT] = rng.uniform(-0.5, 0.5, 3)
    across = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    found[at.EDGE], found[at.SHED] = rng.uniform(-0.2, 0.2, 3), rng.choice((0.0, 2.0))
    found[at.CHORD], found[at.NORMAL] = across[0], across[1]
    return list(found)


def branch(parent: Any, name: str, kinds: tuple[Any, ...], rng: np.random.Generator) -> None:
    """Add a box of some kilograms, moved by joints of these kinds."""
    body = parent.add_body(name=name, pos=rng.uniform(-0.3, 0.3, 3), quat=rng.normal(size=4))
    for kind in kinds:
        place = {} if kind == FREE else {"pos": rng.uniform(-0.1, 0.1, 3)}
        body.add_joint(type=kind, axis=rng.normal(size=3), **place)
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=rng.uniform(0.05, 0.1, 3),
        pos=rng.uniform(-0.1, 0.1, 3),
        contype=0,
        conaffinity=0,
    )


def tree(
    bodies: int,
    seed: int,
    *,
    ideal: bool = False,
    root: tuple[Any, ...] = (FREE,),
    kinds: tuple[tuple[Any, ...], ...] = KINDS,
    roots: int = 1,
) -> Any:
    """Return a `mujoco.MjSpec` of random wet trees, whose bodies are called b0, b1 and so on."""
    rng = np.random.default_rng(seed)
    spec = mujoco.MjSpec()
    grown: list[Any] = []
    for index in range(bodies):
        name = f"b{index}"
        if index < roots:
            branch(spec.worldbody, name, root, rng)
        else:
            branch(grown[rng.integers(index)], name, kinds[rng.integers(len(kinds))], rng)
        grown.append(spec.body(name))
        at.write_numbers(spec, name, numbers(rng, ideal=ideal))
    return spec


@pytest.fixture
def grown() -> Callable[..., Any]:
    """What makes random wet trees; the fluid is installed."""
    install()
    return tree


def state(model: Any, seed: int, speed: float = 1.0) -> Any:
    """Return data of a model at a random place, at random speeds of this size."""
    rng = np.random.default_rng(seed)
    data = mujoco.MjData(model)
    mujoco.mj_integratePos(model, data.qpos, rng.normal(size=model.nv), 1.0)
    data.qvel[:] = speed * rng.normal(size=model.nv)
    return data


@pytest.fixture(scope="session")
def moving() -> Callable[..., Any]:
    """What puts a model into a random state."""
    return state


def inertia(model: Any, data: Any) -> Array:
    """Return the joint-space inertia that the data hold, (nv, nv)."""
    whole = np.zeros((model.nv, model.nv))
    for row in range(model.nv):
        first, count = model.M_rowadr[row], model.M_rownnz[row]
        columns = model.M_colind[first : first + count]
        whole[row, columns] = whole[columns, row] = data.M[first : first + count]
    return whole


@pytest.fixture(scope="session")
def dense() -> Callable[..., Array]:
    """What writes the inertia of a model's data as a matrix."""
    return inertia


def spatial(model: Any, body: int) -> Array:
    """Return the rigid inertia of a body about its origin, in its axes, linear first, (6, 6)."""
    turned = np.zeros(9)
    mujoco.mju_quat2Mat(turned, model.body_iquat[body])
    axes, mass = turned.reshape(3, 3), model.body_mass[body]
    lever = np.cross(np.eye(3), model.body_ipos[body])  # lever @ v = com x v
    whole = np.zeros((6, 6))
    whole[:3, :3], whole[3:, :3], whole[:3, 3:] = mass * np.eye(3), mass * lever, mass * lever.T
    whole[3:, 3:] = axes @ np.diag(model.body_inertia[body]) @ axes.T + mass * lever @ lever.T
    return whole


def twins(spec: Any) -> tuple[Any, Any]:
    """Return a tree in water that weighs nothing but 3 times its inertia, and one 4 times as heavy.

    The second has a fourth of the gravity, so that both move alike.
    """
    dry = spec.compile()
    for body in range(1, dry.nbody):
        found = np.zeros(at.WIDTH)
        found[at.MARK], found[at.SCALE] = at.SIGNATURE, 1.0
        found[at.ADDED] = 3.0 * spatial(dry, body)[np.triu_indices(6)]
        at.write_numbers(spec, dry.body(body).name, list(found))
    wet = settle(spec.compile())
    dry.body_user[:] = 0.0
    dry.body_mass[:] *= 4.0
    dry.body_inertia[:] *= 4.0
    dry.opt.gravity[:] /= 4.0
    mujoco.mj_setConst(dry, mujoco.MjData(dry))
    return wet, dry


@pytest.fixture
def alike() -> Callable[[Any], tuple[Any, Any]]:
    """What makes a wet model, and a dry one that moves like it."""
    return twins


@pytest.fixture
def written(tmp_path: Path) -> Callable[[str], Robot]:
    """What makes a robot of the inside of an MJCF."""

    def write(inside: str) -> Robot:
        path = tmp_path / "robot.xml"
        path.write_text(f'<mujoco model="body"><compiler angle="radian"/>{inside}</mujoco>')
        return load(path)

    return write
