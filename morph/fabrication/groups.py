"""Pieces that are alike, as one part with several copies, and those that are mirrored twins."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from morph.arrays import Array
from morph.fabrication.moments import laid
from morph.fabrication.pieces import Piece
from morph.fabrication.point_set_registration import motion
from morph.print.mesh import Mesh


@dataclass(kw_only=True, eq=False)
class PieceGroup:
    """Pieces that are one part, each with the motion from the first one's frame to its own."""

    members: list[tuple[Piece, Array]]
    """Pieces and motions, shape (4, 4), mm; the first one's is the identity."""
    twin: PieceGroup | None = None
    """The mirrored ones."""
    mirror: Array | None = None
    """Of a twin: from the frame of the first piece of its original to that of its own first."""
    points: Array = field(default_factory=lambda: np.zeros((0, 4)))
    """What it is compared by."""

    @property
    def pieces(self) -> tuple[Piece, ...]:
        """All of them, the mirrored ones too."""
        twins = self.twin.members if self.twin else []
        return tuple(piece for piece, _ in (*self.members, *twins))

    @property
    def first(self) -> Piece:
        """The piece after which it is made."""
        return self.members[0][0]


def grouped(pieces: Iterable[Piece]) -> tuple[PieceGroup, ...]:
    """Return pieces in groups, in order; twins stand in their group's `twin`."""
    results: list[PieceGroup] = []
    for piece in pieces:
        points = piece.points()
        if not any(_joins(group, piece, points) for group in results):
            results.append(PieceGroup(members=[(piece, np.eye(4))], points=points))
    return tuple(results)


def _joins(group: PieceGroup, piece: Piece, points: Array) -> bool:
    """Add a piece to a group or its twin if it is like it; return whether it was."""
    if isinstance(group.first.source, Mesh) != isinstance(piece.source, Mesh):
        return False
    result = _motion(group, piece, points)
    if result is None:
        return False
    if np.linalg.det(result[:3, :3]) > 0:
        group.members.append((piece, result))
    elif group.twin is None or group.twin.mirror is None:
        group.twin = PieceGroup(members=[(piece, np.eye(4))], mirror=result)
    else:
        group.twin.members.append((piece, result @ np.linalg.inv(group.twin.mirror)))
    return True


def _motion(group: PieceGroup, piece: Piece, points: Array) -> Array | None:
    one, other = group.first.source, piece.source
    if one is other:
        return np.eye(4)
    if not isinstance(one, Mesh) or not isinstance(other, Mesh):
        return motion(group.points, points)
    # Volumes are the quickest thing to compare.
    if abs(one.volume - other.volume) > 1e-3 * max(abs(one.volume), 1.0):
        return None
    result = motion(group.points, points)
    return result if result is not None else laid(one, other)
