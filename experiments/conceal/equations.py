"""Hand-written equations of motion of planar mechanisms, vectorised over rows.

A row is one episode of one case: every parameter may differ from row to row.
Arrays are joint first, `(joints, rows)`, so that each operation of a step runs
over all rows. Nothing here comes from MuJoCo or from `morph`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Parameters = dict[str, Array]


@dataclass(frozen=True, kw_only=True)
class Reach:
    """How far and how hard a joint is driven, to choose commands and sizes."""

    span: float
    """Largest excursion that an experimenter would allow, rad or m."""
    effort: float
    """What moves the joint well, N m or N."""
    speed: float
    """A brisk speed, rad/s or m/s."""


class Equations(ABC):
    """M(q) a + h(q, v) = tau for one mechanism of one or two joints."""

    name: str
    """The robot's name on the shelf."""
    joints: tuple[str, ...]
    """Joints in the order of q."""
    actuators: tuple[str, ...]
    """Actuators, each named as the joint that it drives."""
    kinds: tuple[str, ...]
    """`hinge` or `slide` for each joint."""
    reach: tuple[Reach, ...]
    """How each joint is driven."""
    varied: tuple[str, ...]
    """Masses, distances of centres of mass and inertias that a truth draws anew."""

    @abstractmethod
    def nominal(self) -> dict[str, float]:
        """Return what the description on the shelf states, SI."""

    @abstractmethod
    def mass(self, q: Array, p: Parameters) -> tuple[Array, ...]:
        """Return M: (M11,) for one joint, (M11, M12, M22) for two; each of shape (rows,)."""

    @abstractmethod
    def bias(self, q: Array, v: Array, p: Parameters) -> Array:
        """Return h: Coriolis, gravity and the description's own damping; shape (joints, rows)."""

    @abstractmethod
    def energy(self, q: Array, v: Array, p: Parameters) -> Array:
        """Return kinetic plus potential energy, J, shape (rows,)."""


def kinetic(mass: tuple[Array, ...], v: Array) -> Array:
    """Return v' M v / 2, J, shape (rows,)."""
    if len(mass) == 1:
        return np.asarray(0.5 * mass[0] * v[0] ** 2)
    m11, m12, m22 = mass
    return np.asarray(0.5 * m11 * v[0] ** 2 + m12 * v[0] * v[1] + 0.5 * m22 * v[1] ** 2)


def inverse(mass: tuple[Array, ...]) -> tuple[Array, ...]:
    """Return the inverse of M in the same packing."""
    if len(mass) == 1:
        return (1.0 / mass[0],)
    m11, m12, m22 = mass
    scale = 1.0 / (m11 * m22 - m12 * m12)
    return (m22 * scale, -m12 * scale, m11 * scale)


def times(packed: tuple[Array, ...], x: Array) -> Array:
    """Return a packed symmetric matrix times x, shape (joints, rows)."""
    if len(packed) == 1:
        return packed[0] * x
    a, b, c = packed
    out = np.empty_like(x)
    out[0] = a * x[0] + b * x[1]
    out[1] = b * x[0] + c * x[1]
    return out
