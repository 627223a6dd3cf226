"""The degrees of freedom of a body as a reader names them, each with the unit of its force."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.robot import Joint, Robot
from morph.record.quantities import XYZ


@dataclass(frozen=True, kw_only=True)
class Freedom:
    """One degree of freedom."""

    name: str
    """That of its joint, or of a link that moves freely with the axis: `hull x`, `hull turn z`."""
    joint: Joint
    """The joint that it is of."""
    unit: str
    """N of a force, N m of a torque."""


def freedoms(robot: Robot) -> tuple[Freedom, ...]:
    """Return all degrees of freedom, in the order of `qvel`."""
    results: list[Freedom] = []
    for joint in robot.joints:
        if joint.kind in {"hinge", "slide"}:
            results.append(Freedom(name=joint.name, joint=joint, unit=joint.effort_unit))
        if joint.kind == "free":
            results += [Freedom(name=f"{joint.link} {a}", joint=joint, unit="N") for a in XYZ]
        if joint.kind in {"free", "ball"}:
            turns = [f"{joint.link} turn {axis}" for axis in XYZ]
            results += [Freedom(name=name, joint=joint, unit="N m") for name in turns]
    return tuple(results)


def axes(model: mujoco.MjModel, robot: Robot, positions: Array) -> tuple[Array, Array]:
    """Return the anchor and the axis of each degree of freedom, (pictures, dofs, 3) each.

    A free link is pushed along the world's axes and turned about its own.

    Args:
        model: The compiled robot.
        robot: Its description.
        positions: Shape (pictures, nq).
    """
    data = mujoco.MjData(model)
    anchor = np.empty((len(positions), model.nv, 3))
    axis = np.empty_like(anchor)
    joints = [(joint.kind, model.joint(joint.name)) for joint in robot.joints]
    for at, pose in enumerate(positions):
        data.qpos[:] = pose
        mujoco.mj_kinematics(model, data)
        for kind, joint in joints:
            dof, body = int(joint.dofadr[0]), int(model.jnt_bodyid[joint.id])
            anchor[at, dof : dof + 6] = data.xanchor[joint.id]
            turned = data.xmat[body].reshape(3, 3).T
            if kind == "free":
                axis[at, dof : dof + 3], axis[at, dof + 3 : dof + 6] = np.eye(3), turned
            elif kind == "ball":
                axis[at, dof : dof + 3] = turned
            else:
                axis[at, dof] = data.xaxis[joint.id]
    return anchor, axis
