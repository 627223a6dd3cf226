"""A policy's numbers: finite, of the right shape, and never changed."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from morph.arrays import Array
from morph.errors import PolicyError
from morph.policy.fields import most_of
from morph.policy.policy import LARGEST, Policy


def keep(policy: Policy, **shapes: tuple[int | None, ...]) -> None:
    """Make arrays of the named fields of a policy that is being made, and check them.

    Args:
        policy: The policy.
        shapes: For each field the shape that it must have; None for any length but 0.

    Raises:
        PolicyError: A shape is wrong, or a number is none or too large.
    """
    for name, shape in shapes.items():
        value = kept(getattr(policy, name), name, shape, where=place(policy))
        object.__setattr__(policy, name, value)


def kept(value: object, name: str, shape: tuple[int | None, ...], *, where: str) -> Array:
    """Return numbers as an array that cannot be changed.

    Raises:
        PolicyError: Their shape is wrong, or one is no number or too large.
    """
    try:
        array = np.array(value, dtype=float)
    except (TypeError, ValueError) as error:
        raise PolicyError(
            f"{name} is no array of numbers", where=where, fix="give an array of floats"
        ) from error
    wanted = tuple("n" if length is None else length for length in shape)
    fits = array.ndim == len(shape) and all(
        result == length or (length is None and result)
        for result, length in zip(array.shape, shape, strict=True)
    )
    if not fits:
        raise PolicyError(
            f"{name} has the shape {_shown(array.shape)}",
            where=where,
            fix=f"give it the shape {_shown(wanted)}",
        )
    if not (np.abs(array) <= LARGEST).all():
        raise PolicyError(
            f"{name} holds what is no number from {-LARGEST:g} to {LARGEST:g}",
            where=where,
            fix="give finite numbers in SI",
        )
    array.flags.writeable = False
    return array


def named(weights: Mapping[str, Array], names: tuple[str, ...], kind: str) -> None:
    """Check that numbers have exactly these names.

    Raises:
        PolicyError: One is missing, or there is one more.
    """
    if set(weights) != set(names):
        shapes = {name: value.shape for name, value in weights.items()}
        raise PolicyError(
            f"its numbers have the shapes {most_of(shapes)}",
            where=f"a policy of kind {kind}",
            fix=f"give {', '.join(names)} and nothing else",
        )


def place(policy: Policy) -> str:
    """Return how an error names a policy."""
    return f"a policy of kind {policy.kind}"


def _shown(shape: tuple[object, ...]) -> str:
    return f"({', '.join(map(str, shape))}{',' if len(shape) == 1 else ''})"
