"""How a servo sits where its box is drawn: which way its horn looks, and where its axis is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.make.drawing import MM, Drawing, Drawn
from morph.make.solids import placed

LEVEL = 0.5
"""How far off the box's middle, in halves of its height, the joint tells which way is out, mm."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Seated:
    """A servo's case as it is drawn, and the axis that it turns."""

    case: Array
    """From the case's frame (its middle; x along its length, z along its axis), shape (4, 4), mm,
    to the frame of the link that holds it."""
    size: Array
    """Of the case along these axes, mm, shape (3,)."""
    joint: Array
    """Where the joint's axis leaves the case's top, in the case's frame, mm, shape (3,)."""

    def pose(self, axis_mm: float | None) -> Array:
        """Return the servo's frame in the link's; its axis is `axis_mm` from the case's middle.

        Without a figure the axis is taken to be where the joint's is.
        """
        along = self.joint[0] if axis_mm is None else -axis_mm
        across = self.joint[1] if axis_mm is None else 0.0
        return self.case @ placed(np.eye(3), np.array([along, across, self.size[2] / 2.0]))


def seated(drawing: Drawing, box: Drawn, joint: str) -> Seated:
    """Return how a servo drawn as a box sits that turns a joint.

    Its height is the side of the box that the joint's axis is most nearly along, its length the
    longer one of the others, and its far end the one further from the axis. Its horn is on the
    side where the joint is, and if the joint is in its middle, where what it turns has its mass.
    """
    model, data = drawing.model, drawing.data
    at = model.joint(joint).id
    to_box = np.asarray(np.linalg.inv(drawing.world(box.link) @ box.pose), dtype=np.float64)
    anchor = to_box[:3, :3] @ (MM * data.xanchor[at]) + to_box[:3, 3]
    axis = to_box[:3, :3] @ data.xaxis[at]
    up = int(np.argmax(np.abs(axis)))
    others = [side for side in range(3) if side != up]
    long = max(others, key=lambda side: (round(float(box.size[side]), 3), -side))
    z = np.zeros(3)
    z[up] = _out(drawing, box, joint, to_box, anchor, axis, up)
    x = np.zeros(3)
    x[long] = -1.0 if anchor[long] > 0 else 1.0
    turn = np.column_stack([x, np.cross(z, x), z])
    size = 2.0 * np.array([box.size[long], box.size[3 - up - long], box.size[up]])
    local = turn.T @ anchor
    return Seated(
        case=box.pose @ placed(turn, np.zeros(3)),
        size=size,
        joint=np.array([local[0], local[1], size[2] / 2.0]),
    )


def _out(
    drawing: Drawing, box: Drawn, joint: str, to_box: Array, anchor: Array, axis: Array, up: int
) -> float:
    """Return 1 if the horn looks along the box's axis `up`, and -1 if against it."""
    if abs(anchor[up]) > LEVEL * box.size[up]:
        return float(np.sign(anchor[up]))
    robot = drawing.robot
    moved = robot.joint(joint).link
    if moved == box.link:
        # It turns itself about what holds its horn.
        moved = robot.link(moved).parent
    shapes = drawing.shapes.get(moved, ())
    if shapes:
        pose = to_box @ drawing.world(moved)
        middle = np.mean([shape.placed.bounds.mean(axis=0) for shape in shapes], axis=0)
        side = float((pose[:3, :3] @ middle + pose[:3, 3])[up])
        if abs(side) > LEVEL * box.size[up]:
            return float(np.sign(side))
    return 1.0 if axis[up] > 0 else -1.0
