"""Arrows of the force that is missing at each joint, along its axis, at its anchor."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from morph.app.viewer.figure import Figure
from morph.app.viewer.mismatch.heat import forces
from morph.app.viewer.mismatch.take import DESCRIBED, Take
from morph.arrays import Array

LONG = 0.35
"""Length of the arrow of the force that `FULL` of the pictures stay below, by the body's size."""
FULL = 0.98
"""See `LONG`."""
APART = 0.04
"""How far arrows of two models at one joint stand apart, by the body's size."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Scale:
    """How long arrows are."""

    metres: dict[str, float]
    """Length of an arrow of one unit of force, m, by unit."""
    size: float
    """The body's size, m."""

    def note(self, both: bool) -> str:
        """Return what the arrows are, in words.

        Args:
            both: Whether those of the corrected model are drawn too.
        """
        told = " and ".join(
            f"{0.1 * self.size:.2g} m of arrow is {0.1 * self.size / each:.2g} {unit}"
            for unit, each in self.metres.items()
        )
        which = " (red as described, green corrected)" if both else ""
        return (
            f"Arrows along the joints' axes are the torque or force that is missing there{which}, "
            f"by the right-hand rule: {told}."
        )


def scale_of(figure: Figure, take: Take) -> Scale | None:
    """Return how long arrows are, so that the description's fit the body; None without any."""
    if DESCRIBED not in take.missing:
        return None
    found = np.abs(forces(take, DESCRIBED, len(take.measured)))
    size = _size(figure, take)
    greatest: dict[str, float] = {}
    for at, joint in enumerate(figure.robot.joints):
        known = found[np.isfinite(found[:, at]), at]
        high = float(np.quantile(known, FULL)) if len(known) else 0.0
        greatest[joint.effort_unit] = max(high, greatest.get(joint.effort_unit, 0.0))
    metres = {unit: LONG * size / each for unit, each in greatest.items() if each > 0.0}
    return Scale(metres=metres, size=size) if metres else None


def wrenches(figure: Figure, take: Take, model: str, scale: Scale, aside: float = 0.0) -> Array:
    """Return arrows in the pictures, m, shape (pictures, joints, 2, 3); NaN where none is known.

    Args:
        figure: The body.
        take: What is shown.
        model: Which model lacks the force.
        scale: How long arrows are.
        aside: How many places they stand beside the axis, so that two models' are told apart.
    """
    force = forces(take, model, len(take.measured))
    anchor, axis = axes(figure, take.measured)
    metres = np.array([scale.metres.get(j.effort_unit, 0.0) for j in figure.robot.joints])
    # Beside the axis is any direction at right angles to it, the same in every picture.
    across = np.cross(axis, np.array([0.0, 0.0, 1.0]))
    flat = np.linalg.norm(across, axis=-1, keepdims=True)
    across = np.where(flat > 1e-6, across / np.maximum(flat, 1e-9), np.array([1.0, 0.0, 0.0]))
    foot = anchor + aside * APART * scale.size * across
    tip = foot + axis * (metres * force)[..., None]
    return np.stack([foot, tip], axis=2)


def axes(figure: Figure, positions: Array) -> tuple[Array, Array]:
    """Return each joint's anchor and axis in the body's world, (pictures, joints, 3) each."""
    model = figure.model
    data = mujoco.MjData(model)
    which = [int(model.joint(joint.name).id) for joint in figure.robot.joints]
    anchor = np.empty((len(positions), len(which), 3))
    axis = np.empty_like(anchor)
    for at, pose in enumerate(positions):
        data.qpos[:] = pose
        mujoco.mj_kinematics(model, data)
        anchor[at], axis[at] = data.xanchor[which], data.xaxis[which]
    return anchor, axis


def _size(figure: Figure, take: Take) -> float:
    """Return how far a body's links and anchors reach from end to end, m."""
    anchor, _ = axes(figure, take.measured[:1])
    reach = [shape.vertices for shape in figure.shapes if shape.body]
    radius = max((float(np.linalg.norm(each, axis=1).max()) for each in reach), default=0.1)
    return float(np.linalg.norm(np.ptp(anchor[0], axis=0))) + 2.0 * radius
