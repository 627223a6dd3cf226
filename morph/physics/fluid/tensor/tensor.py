"""An added-mass tensor with the volume that displaces the fluid."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from morph.arrays import Array
from morph.errors import RobotError

SYMMETRIC = 1e-9
"""Greatest difference of two mirrored entries, as a part of the greatest entry."""


def _origin() -> Array:
    return np.zeros(3)


@dataclass(frozen=True, kw_only=True, eq=False)
class Tensor:
    """The inertia of the fluid around a solid at unit density, and what the solid displaces."""

    matrix: Array
    """Tensor on [v; w] about `point`, in the frame's axes, shape (6, 6); m3, m4 and m5."""
    volume: float
    """Volume displaced, m3."""
    centre: Array = field(default_factory=_origin)
    """Centre of that volume, shape (3,), m."""
    point: Array = field(default_factory=_origin)
    """Place whose velocity is v, shape (3,), m."""
    error: float = 0.0
    """Estimated relative error of the worst diagonal entry about `centre`; 0 in closed form."""
    panels: int = 0
    """Panels of the finest surface it was computed on; 0 in closed form."""

    def __post_init__(self) -> None:
        matrix = self.matrix
        if matrix.shape != (6, 6) or not np.isfinite(matrix).all():
            raise _unfit(f"a matrix of shape {matrix.shape}, or one that is not finite")
        if np.abs(matrix - matrix.T).max() > SYMMETRIC * np.abs(matrix).max():
            raise _unfit("a matrix that is not symmetric")
        if not (np.isfinite(self.volume) and self.volume > 0.0):
            raise _unfit(f"a volume of {self.volume:g} m3")

    def about(self, point: ArrayLike) -> Tensor:
        """Return the tensor of the same solid about another place of the frame.

        The old place moves with v + w x (old - new), so [v; w] there is A [v; w]
        here and K becomes A' K A (Featherstone 2008, eq. 2.62).
        """
        new = np.asarray(point, dtype=np.float64)
        move = np.eye(6)
        # The columns are w x (old - new) for unit w.
        move[:3, 3:] = np.cross(np.eye(3), self.point - new).T
        return replace(self, matrix=_even(move.T @ self.matrix @ move), point=new)

    def scaled(self, factor: float) -> Tensor:
        """Return the tensor of the solid grown by a factor about the frame's origin."""
        if not (np.isfinite(factor) and factor > 0.0):
            raise _unfit(f"a scale of {factor:g}")
        power = np.repeat((1.0, factor), 3)
        return replace(
            self,
            matrix=factor**3 * np.outer(power, power) * self.matrix,
            volume=factor**3 * self.volume,
            centre=factor * self.centre,
            point=factor * self.point,
        )

    def turned(self, rotation: Array) -> Tensor:
        """Return the tensor of the solid turned about the frame's origin, x' = R x.

        Args:
            rotation: R, a proper rotation, shape (3, 3).
        """
        R = np.asarray(rotation, dtype=np.float64)
        if R.shape != (3, 3) or not (
            np.allclose(R @ R.T, np.eye(3), atol=1e-9) and np.linalg.det(R) > 0.0
        ):
            raise _unfit("a matrix that is no rotation")
        both = np.kron(np.eye(2), R)
        return replace(
            self,
            matrix=_even(both @ self.matrix @ both.T),
            centre=R @ self.centre,
            point=R @ self.point,
        )

    def mirrored(self, signs: Array) -> Tensor:
        """Return the tensor of the mirrored solid, x' = s x; -1 in s mirrors an axis.

        v mirrors as places do, w as their cross products: by s times the product of s.
        """
        both = np.concatenate([signs, signs.prod() * signs])
        return replace(
            self,
            matrix=np.outer(both, both) * self.matrix,
            centre=signs * self.centre,
            point=signs * self.point,
        )

    def shifted(self, offset: ArrayLike) -> Tensor:
        """Return the tensor of the solid moved by an offset, about the same place of the frame."""
        move = np.asarray(offset, dtype=np.float64)
        along = replace(self, centre=self.centre + move, point=self.point + move)
        return along.about(self.point)


def _even(matrix: Array) -> Array:
    even: Array = 0.5 * (matrix + matrix.T)
    return even


def _unfit(what: str) -> RobotError:
    return RobotError(
        f"it was given {what}",
        where="morph.physics.fluid.tensor.Tensor",
        fix="give a symmetric, finite 6x6 matrix, a positive volume, and proper rotations",
    )
