"""Where servos sit in parts that are drawn as meshes, so that it is seen whether they fit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from morph.fabrication.drawing import LinkShape
from morph.fabrication.off_the_shelf_parts import Item
from morph.print.part import Seat
from morph.print.servo import case


def seats(
    shape: LinkShape, others: Sequence[LinkShape], bought: Sequence[Item]
) -> tuple[Seat, ...]:
    """Return the seats of a link's servos in one of its meshes, in the mesh's own frame.

    Args:
        shape: The mesh.
        others: All meshes of the link; a servo sits in the one that comes nearest to it.
        bought: What is bought.
    """
    results = []
    back = np.linalg.inv(shape.pose)
    for item in bought:
        if item.servo is None or item.seated is None or item.entry.link != shape.link:
            continue
        if min(others, key=lambda each: _away(each, item)) is not shape:
            continue
        pose = back @ item.seated.pose
        results.append(
            Seat(
                holds=item.servo.name,
                position=pose[:3, 3],
                axis=pose[:3, 2],
                bore_mm=0.0,
                # Drawn by somebody with a play of their own: the case itself must go in.
                pocket=case(item.servo).moved(pose),
            )
        )
    return tuple(results)


def _away(shape: LinkShape, item: Item) -> float:
    """Return how far a mesh's corners are from the middle of a servo, mm."""
    if item.servo is None or item.seated is None:
        return float("inf")
    which = item.servo
    middle = np.array([which.length_mm / 2 - which.axis_mm, 0.0, -which.height_mm / 2])
    at = item.seated.pose[:3, :3] @ middle + item.seated.pose[:3, 3]
    return float(np.linalg.norm(shape.placed.vertices - at, axis=1).min())
