"""Arrows of the force and the torque that are missing at each joint, at its anchor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.app.viewer.figure import Figure
from morph.app.viewer.mismatch.freedoms import axes, freedoms
from morph.app.viewer.mismatch.heat import forces
from morph.app.viewer.mismatch.window import DESCRIBED, Take
from morph.arrays import Array

LONG = 0.35
"""Length of the arrow of the force that `FULL` of the pictures stay below, by the body's size."""
OUT_OF = 0.8
"""The same of a body that moves freely, whose arrows begin within it."""
FULL = 0.98
"""See `LONG`."""
APART = 0.04
"""How far arrows of two models at one joint stand apart, by the body's size."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ArrowScale:
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
        text = " and ".join(
            f"{0.1 * self.size:.2g} m of arrow is {0.1 * self.size / each:.2g} {unit}"
            for unit, each in self.metres.items()
        )
        which = " (red as described, green corrected)" if both else ""
        return (
            f"Arrows at the joints are the torque or force that is missing there{which}, by the "
            f"right-hand rule: {text}."
        )


def scale_of(figure: Figure, take: Take) -> ArrowScale | None:
    """Return how long arrows are, so that the description's fit the body; None without any."""
    if DESCRIBED not in take.missing:
        return None
    result = np.abs(forces(take, DESCRIBED, len(take.measured)))
    size = _size(figure, take)
    greatest: dict[str, float] = {}
    for at, freedom in enumerate(freedoms(figure.robot)):
        known = result[np.isfinite(result[:, at]), at]
        high = float(np.quantile(known, FULL)) if len(known) else 0.0
        greatest[freedom.unit] = max(high, greatest.get(freedom.unit, 0.0))
    free = any(joint.kind == "free" for joint in figure.robot.joints)
    long = (OUT_OF if free else LONG) * size
    metres = {unit: long / each for unit, each in greatest.items() if each > 0.0}
    return ArrowScale(metres=metres, size=size) if metres else None


def wrenches(
    figure: Figure, take: Take, model: str, scale: ArrowScale, aside: float = 0.0
) -> Array:
    """Return arrows in the pictures, m, shape (pictures, arrows, 2, 3); NaN where none is known.

    A hinge or slide has one, a link that moves freely one of force and one of torque.

    Args:
        figure: The body.
        take: What is shown.
        model: Which model lacks the force.
        scale: How long arrows are.
        aside: How many places they stand beside the axis, so that two models' are told apart.
    """
    known = freedoms(figure.robot)
    force = forces(take, model, len(take.measured))
    anchors, each = axes(figure.model, figure.robot, take.measured)
    metres = np.array([scale.metres.get(freedom.unit, 0.0) for freedom in known])
    along = each * (metres * force)[..., None]
    groups = list(dict.fromkeys((freedom.joint.name, freedom.unit) for freedom in known))
    inside = [
        [at for at, freedom in enumerate(known) if (freedom.joint.name, freedom.unit) == group]
        for group in groups
    ]
    anchor = np.stack([anchors[:, some[0]] for some in inside], axis=1)
    shift = np.stack([along[:, some].sum(axis=1) for some in inside], axis=1)
    axis = np.stack([each[:, some[0]] for some in inside], axis=1)
    # Beside the axis is any direction at right angles to it, the same in every picture.
    across = np.cross(axis, np.array([0.0, 0.0, 1.0]))
    flat = np.linalg.norm(across, axis=-1, keepdims=True)
    across = np.where(flat > 1e-6, across / np.maximum(flat, 1e-9), np.array([1.0, 0.0, 0.0]))
    foot = anchor + aside * APART * scale.size * across
    return np.stack([foot, foot + shift], axis=2)


def _size(figure: Figure, take: Take) -> float:
    """Return how far a body's links and anchors reach from end to end, m."""
    anchor, _ = axes(figure.model, figure.robot, take.measured[:1])
    reach = [shape.vertices for shape in figure.shapes if shape.body]
    radius = max((float(np.linalg.norm(each, axis=1).max()) for each in reach), default=0.1)
    return float(np.linalg.norm(np.ptp(anchor[0], axis=0))) + 2.0 * radius
