"""Everything that a task may ask of a body."""

from morph.task.quantity.effort import Commands as Commands
from morph.task.quantity.joints import AngleSum as AngleSum
from morph.task.quantity.joints import JointPositions as JointPositions
from morph.task.quantity.joints import JointSpeeds as JointSpeeds
from morph.task.quantity.links import Direction as Direction
from morph.task.quantity.links import FloatSpeed as FloatSpeed
from morph.task.quantity.links import Point as Point
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
