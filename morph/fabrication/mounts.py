"""How a servo sits where its box is drawn, and where what it turns is screwed to its horn."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.fabrication.drawing import MM, Drawing, LinkShape
from morph.fabrication.solids import placed
from morph.print.servos import ServoSize

LEVEL = 0.5
"""How far off the box's middle, in halves of its height, the joint tells which way is out."""

ON_AXIS_MM, ON_AXIS_DEG = 2.0, 2.0
"""How near the drawn axis must be to the joint's for the servo to be put onto it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Seated:
    """A servo as it is drawn, and the axis that it turns; all in the frame of its link, mm."""

    pose: Array
    """Of the servo's frame: its axis leaves the case at its origin along z; shape (4, 4)."""
    horn: Array
    """The same where the horn turns what it turns: on the joint's axis, shape (4, 4)."""
    off_mm: float
    """How far its axis is from the joint's where it was drawn."""
    off_deg: float
    """By how much its axis leans from the joint's."""

    @property
    def fits(self) -> bool:
        """Whether the servo is on the joint's axis."""
        return self.off_mm <= ON_AXIS_MM and self.off_deg <= ON_AXIS_DEG


def seated(drawing: Drawing, drawn: LinkShape, joint: str, servo: ServoSize) -> Seated:
    """Return how a servo sits that is drawn as a box and turns a joint.

    The box's sides are told apart by the servo's sizes, and where these do not tell, by the
    joint's axis. Its far end is the one further from the axis. Its horn is on the side where the
    joint is; if the joint is in its middle, where what it turns is drawn.
    """
    model, data = drawing.model, drawing.data
    at = model.joint(joint).id
    to_box = _inverse(drawing.world(drawn.link) @ drawn.pose)
    anchor = to_box[:3, :3] @ (MM * data.xanchor[at]) + to_box[:3, 3]
    axis = to_box[:3, :3] @ data.xaxis[at]
    long, up = _sides(drawn.size, axis, servo)
    toward = _toward(drawing, drawn, joint, to_box)
    z = np.zeros(3)
    z[up] = 1.0
    z *= (
        _sign(anchor[up], LEVEL * drawn.size[up])
        or _sign(toward[up], LEVEL)
        or _forward(to_box[:3, :3].T @ z)
    )
    x = np.zeros(3)
    x[long] = -_sign(anchor[long], 0.1) or _outward(to_box, long)
    case = placed(np.column_stack([x, np.cross(z, x), z]), np.zeros(3))
    origin = np.array([servo.axis_mm - servo.length_mm / 2, 0.0, servo.height_mm / 2])
    pose = case @ placed(np.eye(3), origin)
    lean = math.degrees(math.acos(min(1.0, abs(float(axis @ z)))))
    off = anchor - pose[:3, 3]
    off_mm = float(np.linalg.norm(off - (off @ axis) * axis))
    result = Seated(pose=pose, horn=pose, off_mm=off_mm, off_deg=lean)
    if result.fits:
        pose[:3, 3] += off - (off @ z) * z
        horn = pose
    else:
        horn = _horn(drawn.size, to_box, anchor, axis, pose, toward)
    return Seated(pose=drawn.pose @ pose, horn=drawn.pose @ horn, off_mm=off_mm, off_deg=lean)


def _sides(size: Array, axis: Array, servo: ServoSize) -> tuple[int, int]:
    """Return along which sides of the box a servo's length and its height are."""
    wanted = np.array([servo.length_mm, servo.width_mm, servo.height_mm])

    def misfit(order: tuple[int, ...]) -> tuple[float, float, float]:
        # A millimetre is no difference: drawings round, and some servos are nearly square.
        worst = float(np.abs(2.0 * size[list(order)] - wanted).max())
        return (round(worst / 2.0), -round(abs(float(axis[order[2]])), 6), worst)

    best = min(itertools.permutations(range(3)), key=misfit)
    return best[0], best[2]


def _toward(drawing: Drawing, drawn: LinkShape, joint: str, to_box: Array) -> Array:
    """Return where what a servo turns is drawn, in halves of the servo's box, shape (3,)."""
    robot = drawing.robot
    moved = robot.joint(joint).link
    if moved == drawn.link:
        # It turns itself about what holds its horn.
        moved = robot.link(moved).parent
    shapes = drawing.shapes.get(moved, ())
    if not shapes:
        return np.zeros(3)
    pose = to_box @ drawing.world(moved)
    middle = np.mean([shape.placed.bounds.mean(axis=0) for shape in shapes], axis=0)
    there: Array = (pose[:3, :3] @ middle + pose[:3, 3]) / drawn.size
    return there


def _horn(
    size: Array, to_box: Array, anchor: Array, axis: Array, pose: Array, toward: Array
) -> Array:
    """Return a horn's frame on the joint's axis, where that leaves the box."""
    z = axis * (
        _sign(float(axis @ pose[:3, 2]), 0.5)
        or _sign(float(axis @ (toward * size)), LEVEL * float(size.min()))
        or _forward(to_box[:3, :3].T @ axis)
    )
    # The box's corner that reaches furthest along z.
    reach = float(np.abs(z) @ size)
    side = pose[:3, 0] - (pose[:3, 0] @ z) * z
    if np.linalg.norm(side) < 0.1:
        side = pose[:3, 2] - (pose[:3, 2] @ z) * z
    x = side / np.linalg.norm(side)
    return placed(np.column_stack([x, np.cross(z, x), z]), anchor + (reach - anchor @ z) * z)


def _sign(value: float, least: float) -> float:
    """Return 1 or -1 of a value that is not small, and 0 of one that is."""
    return 0.0 if abs(value) <= least else math.copysign(1.0, value)


def _forward(direction: Array) -> float:
    """Return the sign that turns a direction of the world forward, to the left or up."""
    return math.copysign(1.0, direction[int(np.argmax(np.abs(direction)))])


def _outward(to_box: Array, side: int) -> float:
    """Return which way along a side of the box leads away from the body's middle plane."""
    across = float(to_box[side, 1])
    left = -float((to_box[:3, :3].T @ to_box[:3, 3])[1])
    return 1.0 if across * left >= 0.0 or abs(across) < LEVEL else -1.0


def _inverse(pose: Array) -> Array:
    return np.asarray(np.linalg.inv(pose), dtype=np.float64)
