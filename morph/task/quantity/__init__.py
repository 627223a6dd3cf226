"""Everything that a task may ask of a body."""

from morph.task.quantity.effort import Commands
from morph.task.quantity.joints import AngleSum, JointPositions, JointSpeeds
from morph.task.quantity.links import Direction, FloatSpeed, Point
from morph.task.quantity.quantity import Quantity as Quantity

QUANTITIES: tuple[type[Quantity], ...] = (
    JointPositions,
    JointSpeeds,
    AngleSum,
    Point,
    Direction,
    FloatSpeed,
    Commands,
)
"""Every quantity, in the order of the documentation."""
