"""Which observations are angles, and what they are turned into."""

from __future__ import annotations

import math

import numpy as np

from morph.arrays import Array, Integers
from morph.body.robot import Robot
from morph.errors import PolicyError
from morph.policy.policy import LARGEST, Observation, Policy
from morph.policy.tensors import kept, place


def turning(robot: Robot, observation: tuple[Observation, ...]) -> Array:
    """Return 1 for each number that is the position of a hinge without limits, 0 for others.

    Shape (observations,), as policies take it for `angles`. A hinge with limits shows its
    turns by its position, and is better seen as it is.
    """
    free = {f"{j.name}.position" for j in robot.joints if j.kind == "hinge" and j.limits is None}
    results = [each.channel in free for each in observation for _ in range(each.history)]
    return np.array(results, dtype=float)


def marked(policy: Policy, angles: object) -> Array:
    """Return which observations of a policy are angles, as 0 and 1, shape (observations,).

    Raises:
        PolicyError: They are not 0 and 1, one for each number, or an angle is not in rad.
    """
    where = place(policy)
    mask = kept(angles, "angles", (len(angles) if hasattr(angles, "__len__") else 0,), where=where)
    if not len(mask):
        mask = np.zeros(policy.size)
    numbers = [each for each in policy.observation for _ in range(each.history)]
    if mask.shape != (policy.size,) or not np.isin(mask, (0.0, 1.0)).all():
        raise PolicyError(
            f"angles has the shape {mask.shape}, or numbers other than 0 and 1",
            where=where,
            fix=f"give 1 or 0 for each of {policy.size} observations",
        )
    for each, angle in zip(numbers, mask, strict=True):
        if angle and (each.unit != "rad" or each.scale != 1.0):
            raise PolicyError(
                f"{each.channel} in {each.unit} with a scale of {each.scale:g} is no angle",
                where=where,
                fix="take only observations in rad, of scale 1, for angles",
            )
    mask.flags.writeable = False
    return mask


def features(observation: Array, plain: Integers, angles: Integers) -> Array:
    """Return the plain observations, then of each angle its sine and its cosine.

    Args:
        observation: What is seen, shape (..., observations); beyond `LARGEST` it is seen as that.
        plain: Which of them are no angles, by number.
        angles: Which are.
    """
    seen = np.minimum(np.maximum(observation, -LARGEST), LARGEST)
    if not len(angles):
        return np.asarray(seen)
    result = np.empty((*seen.shape[:-1], len(plain) + 2 * len(angles)))
    result[..., : len(plain)] = seen[..., plain]
    turned = seen[..., angles]
    np.sin(turned, out=result[..., len(plain) :: 2])
    np.cos(turned, out=result[..., len(plain) + 1 :: 2])
    return result


def wrapped(difference: Array, angles: Integers) -> Array:
    """Return differences of which those that are angles lie from -pi to pi.

    Args:
        difference: Shape (..., observations), changed in place.
        angles: Which are angles, by number.
    """
    for at in angles:
        turns = np.floor(difference[..., at] / (2.0 * math.pi) + 0.5)
        difference[..., at] -= 2.0 * math.pi * turns
    return difference
