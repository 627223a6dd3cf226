"""Where forces of contact act along a motion: points that touch the floor, joints at their ends.

Such a force is as large as it must be: depths that no recording holds tell of it. What it does to
the points on which it acts is therefore unknown, and what the rest of the robot does is not.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from morph.arrays import Array, Mask
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.model.episodes import Episode
from morph.physics.body_motion import times

INSTANTS, LEAST = 1000, 0.003
"""Most instants of each run at which contacts are looked for; and the share of them that touch in
runs of a robot in contact: a stiff ball touches for some milliseconds of each bounce."""
REACH, NEAR_END = 0.006, 0.005
"""Distance from the floor, m, and of a joint from its end, rad or m, from which forces may act:
shapes, floors and encoders err by as much."""
IMPACT = 0.05
"""Seconds in which a point may lose the velocity at which it touches."""
RANK = 1e-3
"""Singular value of these velocities, over the greatest, below which one depends on others."""


def touches(robot: Robot, episodes: Sequence[Episode]) -> bool:
    """Return whether a robot touches a plane that does not move, as recorded, in part of the runs.

    Shapes of a base that overlap those of the link on it are no contact.
    """
    model = spec_of(robot).compile()
    data, floor = mujoco.MjData(model), _floors(model)
    results = []
    for episode in episodes:
        for position in episode.position[:: -(-len(episode.position) // INSTANTS)]:
            data.qpos[:] = position
            mujoco.mj_fwdPosition(model, data)
            results.append(bool(_touching(model, data, floor).any()))
    return float(np.mean(results)) > LEAST


def at_stops(robot: Robot, episodes: Sequence[Episode]) -> bool:
    """Return whether joints are at the ends of their described ranges in part of the runs."""
    model = spec_of(robot).compile()
    place, _, (low, high) = _ends(model)
    at = np.concatenate([episode.position[:, place] for episode in episodes])
    return bool((((at < low) | (at > high)).mean(axis=0) > LEAST).any())


@dataclass(frozen=True, kw_only=True, eq=False)
class Contact:
    """What forces of contact may change along a motion."""

    rows: Array
    """Combinations of velocities of points in contact and of joints at their ends, by those of the
    joints: orthonormal in the inertia's metric, so that half of their squares is kinetic energy, in
    J, and turning as little as they can from one sample to the next; shape (samples, rows, dofs),
    zero where fewer do."""
    impact: Array
    """Standard deviation of the change of these velocities in a step by impacts, sqrt(J): in the
    50 ms after touchdown they add up to its speed; shape (samples,)."""

    def borne(self, mobility: Array, acceleration: Array, inertial: Array) -> Array:
        """Return the inertial forces of joints in contact, N m or N, shape (samples, dofs).

        They are max(|M qacc|, |qacc_i| / D_ii) of each joint i, where D is the inverse inertia
        projected onto the constraints of contact: a stance leg moves the trunk, and the inertia of
        the leg's own joint understates that.

        Args:
            mobility: Inverse of the inertia, shape (samples, dofs, dofs).
            acceleration: Of the joints, shape (samples, dofs).
            inertial: Forces that the inertia takes without contact, shape (samples, dofs).
        """
        if not self.rows.size:
            return inertial
        moves = mobility - by_contact(self.rows, mobility) @ self.rows @ mobility
        alone, whole = (np.diagonal(each, axis1=1, axis2=2) for each in (moves, mobility))
        held = alone < RANK * whole
        borne = np.where(held, 0.0, acceleration / np.where(held, 1.0, alone))
        return np.asarray(np.maximum(np.abs(inertial), np.abs(borne)))

    def changes(self, velocity: Array) -> float:
        """Return the RMS change of these velocities from one sample to the next, sqrt(J).

        Args:
            velocity: Of the joints, shape (samples, dofs).
        """
        there = self.rows[1:].any(axis=2)
        changes = times(self.rows[1:], np.diff(velocity, axis=0))[there]
        return float(np.sqrt(np.mean(changes**2))) if changes.size else 0.0


def contact_along(
    model: mujoco.MjModel,
    shown: Array,
    position: Array,
    velocity: Array,
    step: float,
    unsure: int = 1,
) -> Contact:
    """Return what forces of contact may change along a motion.

    Args:
        model: The model.
        shown: Positions as read, rad or m, shape (samples, nq): what smooths them rounds off knocks
            by centimetres.
        position: Smoothed ones, which do not leave the floor by noise.
        velocity: Per s, shape (samples, dofs).
        step: Seconds from one sample to the next.
        unsure: Samples by which contact may begin earlier, and end later, than positions show; at
            most 50 ms of them count.
    """
    near, floor = copy.copy(model), _floors(model)
    # MuJoCo adds the margins of two geoms.
    near.geom_margin[:] = 0.5 * REACH
    near.pair_margin[:] = REACH
    data, (place, dofs, (low, high)) = mujoco.MjData(near), _ends(model)
    whole = np.stack([shown, position], axis=1)
    held = (whole[:, :, place] < low + NEAR_END) | (whole[:, :, place] > high - NEAR_END)
    held = held.any(axis=1)
    if not (held.any() or floor.any()):
        return Contact(rows=np.zeros((len(position), 0, model.nv)), impact=np.zeros(len(position)))
    there, units, whitened = [], np.eye(model.nv), np.empty((len(position), model.nv, model.nv))
    for sample, (both, ended) in enumerate(zip(whole, held, strict=True)):
        there.append({(-1, int(dof)): units[[dof]] for dof in dofs[ended]})
        for at in both:
            data.qpos[:] = at
            mujoco.mj_fwdPosition(near, data)
            there[-1] |= _touching_rows(near, data, floor)
        mujoco.mj_fullM(near, data, whitened[sample])
    whitened = np.linalg.cholesky(whitened)
    unsure = min(unsure, round(IMPACT / step))
    across = np.linalg.inv(whitened).transpose(0, 2, 1)
    result, since, speed = [], dict.fromkeys(there[0], -len(there)), []
    for at, now in enumerate(there):
        # Impacts happen between two samples.
        near_by = dict(now)
        for other in there[max(at - unsure, 0) : at + unsure + 1]:
            near_by = other | near_by
        since = {key: since.get(key, at) for key in near_by}
        result.append(_independent([*near_by.values()], across[at]))
        fast = []
        for key, began in since.items():
            if step * (at - began) < IMPACT:
                moves = _independent([near_by[key]], across[at]) @ whitened[at].T
                before = velocity[max(began - 1, 0) : at + 1]
                fast.append(float(np.linalg.norm(before @ moves.T, axis=1).max()))
        speed.append(max(fast, default=0.0))
    # The filter is compiled for as many rows as joints, where these are few.
    most = max(map(len, result))
    rows = np.zeros((len(position), model.nv if most and model.nv <= 7 else most, model.nv))
    last = rows[0]
    for sample, some in zip(rows, result, strict=True):
        if len(some):
            sample[: len(some)] = some
            sample[:] = last = _turned(sample, last)
    return Contact(
        rows=rows @ whitened.transpose(0, 2, 1), impact=np.sqrt(step / IMPACT) * np.array(speed)
    )


def by_contact(rows: Array, mobility: Array) -> Array:
    """Return the dynamically consistent inverse W J' (J W J')^-1, W = M^-1: qacc by that of J qvel.

    The rows J stay those of the nominal model, so that a hypothesis that changes masses does not
    change the prior of the acceleration of points in contact.

    Source: Khatib 1987, IEEE Journal of Robotics and Automation 3(1), eq. 51 (the inverse of J that
    is consistent with the inertia).

    Args:
        rows: J, shape (samples, rows, dofs).
        mobility: W, shape (samples, dofs, dofs).

    Returns:
        Shape (samples, dofs, rows); zero where a row is.
    """
    there = rows.any(axis=(1, 2))
    result = np.zeros((len(rows), rows.shape[2], rows.shape[1]))
    along = mobility @ np.swapaxes(rows, 1, 2)
    # A model that has diverged is not finite, and stays so.
    result[there] = np.nan
    there &= np.isfinite(along).all(axis=(1, 2))
    result[there] = along[there] @ np.linalg.pinv(rows[there] @ along[there], rcond=1e-9)
    return result


def _floors(model: mujoco.MjModel) -> Mask:
    """Return which shapes are planes that do not move."""
    fixed = model.body_weldid[model.geom_bodyid] == 0
    return np.asarray(fixed & (model.geom_type == int(mujoco.mjtGeom.mjGEOM_PLANE)))


def _touching(model: mujoco.MjModel, data: mujoco.MjData, floor: Mask) -> Mask:
    """Return which contacts are of a shape that moves with a floor."""
    pairs = data.contact.geom[: data.ncon]
    moves = model.body_weldid[model.geom_bodyid] > 0
    return np.asarray(moves[pairs].any(axis=1) & floor[pairs].any(axis=1))


def _ends(model: mujoco.MjModel) -> tuple[Array, Array, Array]:
    """Return places in `qpos`, degrees of freedom and ends of hinges and slides with a range."""
    ends = model.jnt_limited.astype(bool) & (model.jnt_type >= int(mujoco.mjtJoint.mjJNT_SLIDE))
    return model.jnt_qposadr[ends], model.jnt_dofadr[ends], model.jnt_range[ends].T


def _touching_rows(
    model: mujoco.MjModel, data: mujoco.MjData, floor: Mask
) -> dict[tuple[int, int], Array]:
    """Return what contact of each two shapes may change, shapes (rows, dofs)."""
    results: dict[tuple[int, int], Array] = {}
    none = np.zeros((0, model.nv))
    linear, angular = np.empty((3, model.nv)), np.empty((3, model.nv))
    for index in np.flatnonzero(_touching(model, data, floor)):
        contact = data.contact[index]
        body = model.geom_bodyid[contact.geom]
        moving = int(body[model.body_weldid[body] > 0][0])
        mujoco.mj_jac(model, data, linear, angular, contact.pos, moving)
        # Rolling and torsional friction are moments.
        turns = angular if contact.dim > 4 else contact.frame[None, :3] @ angular
        pair = int(contact.geom[0]), int(contact.geom[1])
        rows = [results.get(pair, none), linear, turns if contact.dim > 3 else none]
        results[pair] = np.concatenate(rows)
    return results


def _independent(parts: Sequence[Array], across: Array) -> Array:
    """Return orthonormal combinations of rows that say the same, by whitened velocities.

    Args:
        parts: Rows by velocities of joints.
        across: These by whitened ones, of which half the sum of squares is the kinetic energy.
    """
    if not parts:
        return np.zeros((0, len(across)))
    _, size, result = np.linalg.svd(np.concatenate(parts) @ across, full_matrices=False)
    return np.asarray(result[size > RANK * max(size[0], 1e-12)])


def _turned(rows: Array, last: Array) -> Array:
    """Return orthogonal combinations of rows, nearest to others (Procrustes, Schonemann 1966)."""
    left, _, right = np.linalg.svd(last @ rows.T)
    return np.asarray(left @ right @ rows)
