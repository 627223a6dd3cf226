"""Skeletons of the links that are drawn by simple solids."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from morph.arrays import Array
from morph.make.bought import Item
from morph.make.drawing import Drawing
from morph.make.pieces import fusions, plastic, printed_links
from print.mesh import Mesh
from print.skeleton import Skeleton


def skeletons(drawing: Drawing, bought: Sequence[Item]) -> dict[str, Skeleton]:
    """Return a skeleton for each printed link that is drawn by simple solids, by its name.

    What is fused into a link is in that link's skeleton.
    """
    printed = printed_links(drawing)
    into = fusions(drawing, printed)
    solids: dict[str, list[Mesh]] = {}
    for link in printed:
        root = into.get(link, link)
        for shape in plastic(drawing, link, bought):
            if shape.kind != "mesh":
                solids.setdefault(root, []).append(
                    shape.mesh.moved(between(drawing, link, root) @ shape.pose)
                )
    return {
        link: Skeleton(name=link, solids=tuple(solids[link])) for link in printed if link in solids
    }


def between(drawing: Drawing, link: str, other: str) -> Array:
    """Return the transform from one link's frame to another's with all joints at zero."""
    pose: Array = np.linalg.inv(drawing.world(other)) @ drawing.world(link)
    return pose
