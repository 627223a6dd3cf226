"""How far the joints of closed chains turn that have no limits of their own."""

from __future__ import annotations

import itertools
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array
from morph.fabrication.drawing import Drawing

STEPS, TURNS = 8, 6
"""Steps on the way from zero to each corner of what is driven, and corrections at each step."""

MOST_CORNERS = 64
"""Most corners that are gone to; of more, random ones."""

CLOSED_MM = 1.0
"""How far apart a pin's two halves may be where a pose still counts, mm."""

MARGIN = np.deg2rad(3.0)
"""Added on each side, as corners are not all there is."""


def reach(drawing: Drawing) -> dict[str, tuple[float, float]]:
    """Return from where to where each hinge without limits turns in a closed chain, rad.

    The joints with limits are driven to the corners of their ranges, alike in every chain that
    is alike, and the pins are closed on the way by Gauss-Newton steps of least size.
    """
    model = drawing.model
    pins = [at for at in range(model.neq) if model.eq_type[at] == mujoco.mjtEq.mjEQ_CONNECT]
    links = {int(body) for at in pins for body in (model.eq_obj1id[at], model.eq_obj2id[at])}
    chain = {joint for body in links for joint in _above(model, body)}
    driven = [joint for joint in chain if model.jnt_limited[joint]]
    free = [joint for joint in chain if not model.jnt_limited[joint]]
    if not pins or not free:
        return {}
    dofs = model.jnt_dofadr[free]
    seen = np.zeros((2, len(free)))
    for corner in _corners(model, driven):
        data = mujoco.MjData(model)
        for step in range(1, STEPS + 1):
            data.qpos[model.jnt_qposadr[driven]] = corner * step / STEPS
            if not _closed(model, data, pins, dofs):
                break
            at = data.qpos[model.jnt_qposadr[free]] - model.qpos0[model.jnt_qposadr[free]]
            seen = np.stack([np.minimum(seen[0], at), np.maximum(seen[1], at)])
    return {
        model.joint(joint).name: (float(low - MARGIN), float(high + MARGIN))
        for joint, low, high in zip(free, *seen, strict=True)
    }


def _above(model: Any, body: int) -> list[int]:
    """Return the hinges between a link and the tree's base."""
    results = []
    while body:
        first, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
        hinges = [
            joint
            for joint in range(first, first + count)
            if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_HINGE
        ]
        results += hinges
        body = int(model.body_parentid[body])
    return results


def _corners(model: Any, driven: list[int]) -> list[Array]:
    """Return where the driven joints are sent: every way in which two neighbours can differ."""
    low, high = model.jnt_range[driven].T
    results = []
    for pattern in itertools.product((0.0, 0.5, 1.0), repeat=min(2, len(driven))):
        share = np.resize(np.array(pattern), len(driven))
        results.append(low + share * (high - low))
    rng = np.random.default_rng(0)
    while len(results) < MOST_CORNERS // 2:
        results.append(low + rng.integers(0, 2, len(driven)) * (high - low))
    return results


def _closed(model: Any, data: Any, pins: list[int], dofs: Array) -> bool:
    """Close the pins by turning the joints `dofs`; return whether that was possible."""
    gap = np.zeros(3 * len(pins))
    rows = np.zeros((3 * len(pins), model.nv))
    one, other = np.zeros((3, model.nv)), np.zeros((3, model.nv))
    for _ in range(TURNS):
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        for k, at in enumerate(pins):
            first, second = int(model.eq_obj1id[at]), int(model.eq_obj2id[at])
            here = _point(data, first, model.eq_data[at, :3])
            there = _point(data, second, model.eq_data[at, 3:6])
            mujoco.mj_jac(model, data, one, None, here, first)
            mujoco.mj_jac(model, data, other, None, there, second)
            gap[3 * k : 3 * k + 3] = here - there
            rows[3 * k : 3 * k + 3] = one - other
        if np.abs(gap).max() < 1e-6:
            return True
        change = np.zeros(model.nv)
        change[dofs] = -np.linalg.lstsq(rows[:, dofs], gap, rcond=1e-6)[0]
        mujoco.mj_integratePos(model, data.qpos, change, 1.0)
    return bool(np.abs(gap).max() < CLOSED_MM / 1e3)


def _point(data: Any, body: int, local: Array) -> Array:
    point: Array = data.xmat[body].reshape(3, 3) @ local + data.xpos[body]
    return point
