"""What acted on a body along its run: motors, contacts and water, from the simulator itself."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from morph.app.picture.times import nearest_samples
from morph.app.viewer.compare.run import SimulatedRun
from morph.app.viewer.motion import RATE
from morph.arrays import Array
from morph.body.robot import Robot
from morph.physics.fluid.force import water_forces
from morph.physics.fluid.kernel import flowing
from morph.physics.fluid.reference import wet_bodies


@dataclass(frozen=True, kw_only=True)
class Drive:
    """A joint that motors drive."""

    joint: str
    """Its name."""
    dof: int
    """Which degree of freedom it is."""
    place: int
    """Where it stands in `qpos`."""
    index: int
    """MuJoCo's number of the joint."""
    unit: str
    """Of its effort: `N m` or `N`."""
    limit: float | None
    """What its motors can do at most together; None where one of them has no limit."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Forces:
    """Efforts at every step; what is drawn, in every picture.

    What is drawn has a place and a vector: shape (pictures, arrows, 2, 3), m and N, or N m.
    """

    drives: tuple[Drive, ...]
    """The driven joints."""
    effort: Array
    """Of their motors, N m or N, shape (samples, drives)."""
    contact: Array
    """Force of a contact on the body; on the second of two links that touch each other. NaN
    where there is none."""
    fluid: Array
    """Force of the water on each wet link but for its buoyancy: drag, thrust, added mass."""
    buoyancy: Array
    """Buoyancy of each wet link."""
    torque: Array
    """Effort of each driven joint, along its axis."""


def drives_of(robot: Robot, model: Any) -> tuple[Drive, ...]:
    """Return the joints that a robot's motors drive, in the order of its joints."""
    results = []
    for joint in robot.joints:
        limits = [each.limit for each in robot.actuators if each.joint == joint.name]
        if not limits or joint.kind not in ("hinge", "slide"):
            continue
        here = model.joint(joint.name)
        known = [limit for limit in limits if limit is not None]
        results.append(
            Drive(
                joint=joint.name,
                dof=int(here.dofadr[0]),
                place=int(here.qposadr[0]),
                index=int(here.id),
                unit=joint.effort_unit,
                limit=sum(known) if len(known) == len(limits) else None,
            )
        )
    return tuple(results)


def forces(run: SimulatedRun) -> Forces:
    """Return what acted on a body, state after state of its run.

    A state and what arrives at the actuators determine every force; only motors with a state
    of their own would need more, and morph simulates none.
    """
    model, drives = run.model, drives_of(run.robot, run.model)
    data = mujoco.MjData(model)
    pictures = nearest_samples(run.time, RATE)
    drawn = {int(sample): at for at, sample in enumerate(pictures)}
    dofs, wet = [drive.dof for drive in drives], wet_bodies(model)
    effort = np.empty((len(run.time), len(drives)))
    torque = np.empty((len(pictures), len(drives), 2, 3))
    water = np.empty((2, len(pictures), len(wet), 2, 3))
    contacts: list[Array] = [np.zeros((0, 2, 3))] * len(pictures)
    with flowing(model):
        for at in range(len(run.time)):
            data.qpos[:], data.qvel[:] = run.position[at], run.velocity[at]
            data.ctrl[:] = run.control[at]
            mujoco.mj_forward(model, data)
            effort[at] = data.qfrc_actuator[dofs]
            if (picture := drawn.get(at)) is not None:
                contacts[picture] = _contacts(model, data)
                water[:, picture] = water_forces(model, data)
                for number, drive in enumerate(drives):
                    torque[picture, number, 0] = data.xanchor[drive.index]
                    torque[picture, number, 1] = effort[at, number] * data.xaxis[drive.index]
    return Forces(
        drives=drives,
        effort=effort,
        contact=_padded(contacts),
        fluid=water[0],
        buoyancy=water[1],
        torque=torque,
    )


def _contacts(model: Any, data: Any) -> Array:
    """Return where contacts press on the body and how, m and N, shape (contacts, 2, 3)."""
    result, six = [], np.zeros(6)
    for number in range(data.ncon):
        contact = data.contact[number]
        if contact.efc_address < 0:
            continue
        mujoco.mj_contactForce(model, data, number, six)
        # MuJoCo tells what the first presses on the second with, in axes of which the first
        # leads from the first to the second.
        force = contact.frame.reshape(3, 3).T @ six[:3]
        if model.geom_bodyid[contact.geom[1]] == 0:
            force = -force
        result.append((contact.pos.copy(), force))
    return np.array(result).reshape(-1, 2, 3)


def _padded(rows: list[Array]) -> Array:
    """Return rows of different length as one array, filled with NaN."""
    most = max((len(row) for row in rows), default=0)
    whole = np.full((len(rows), most, 2, 3), np.nan)
    for at, row in enumerate(rows):
        whole[at, : len(row)] = row
    return whole
