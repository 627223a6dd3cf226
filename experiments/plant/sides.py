"""Left and right of a description: which joints are twins, and how they lie to each other."""

from __future__ import annotations

import re

import numpy as np

from experiments.plant.description import Description, child_of, joint_in, numbers
from experiments.plant.measure import world
from morph.arrays import Array

SIDES = (("left", "right"), ("Left", "Right"), ("LEFT", "RIGHT"), ("l", "r"), ("L", "R"))
LEGS = {"FL": "FR", "RL": "RR", "HL": "HR", "LF": "RF", "LH": "RH", "lf": "rf", "lh": "rh"}
"""Left and right as names have them, as a word between underscores; legs by their corner."""


def twin(name: str) -> str:
    """Return what the same part on the other side would be called, or nothing."""
    other = {a: b for pair in (*SIDES, *LEGS.items()) for a, b in (pair, pair[::-1])}
    words = re.split(r"(_|-|(?<=[a-z])(?=[A-Z]))", name)
    swapped = [other.get(word, word) for word in words]
    return "" if swapped == words else "".join(swapped)


def side(description: Description) -> tuple[int, float]:
    """Return the axis of the base's frame from right to left, and where the middle lies on it.

    By the pairs of joints that bear a left and a right name: the axis on which most of
    them are mirror images of each other.
    """
    pairs = twins(description)
    if not pairs:
        return 1, 0.0
    at = np.array([[joint_at(description, name) for name in pair] for pair in pairs])
    apart, middle = np.abs(at[:, 0] - at[:, 1]), (at[:, 0] + at[:, 1]) / 2
    axis = int(np.argmax(np.median(apart, axis=0)))
    return axis, float(np.median(middle[:, axis]))


def twins(description: Description) -> list[tuple[str, str]]:
    """Return pairs of joints that bear a left and a right name, each pair once."""
    known = description.joints
    return [
        (one, other)
        for place, one in enumerate(known)
        if (other := twin(one)) in known and place < known.index(other)
    ]


def joint_at(description: Description, joint: str) -> Array:
    """Return where a joint is in the base's frame, m, shape (3,)."""
    child = child_of(joint_in(description.robot, joint))
    place: Array = world(description, child)[:3, 3]
    return place


def axis_in_world(description: Description, joint: str) -> Array:
    """Return a joint's unit axis in the base's frame, shape (3,)."""
    element = joint_in(description.robot, joint)
    axis = np.array(numbers(element.find("axis"), "xyz", "1 0 0"))
    turned: Array = world(description, child_of(element))[:3, :3] @ axis
    return turned / float(np.linalg.norm(turned))
