"""What stands around bodies: the ground with its squares, a ruler, and water."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from morph.app.picture.scene import rounded
from morph.app.viewer.content import Actor
from morph.app.viewer.layout import Layout
from morph.arrays import Array

PLANE = (152, 161, 172)
"""The ground, drawn translucent so that it suits a bright page and a dark one."""

CELL, SECTION = (176, 184, 194), (138, 147, 158)
"""Lines of squares, and of five squares."""

INK = (116, 127, 141)
"""The ruler."""

WATER = (38, 132, 178)
"""Water."""

LENGTH = 0.3
"""How long the ruler is, about, by the radius of what is seen."""

SHORE = 0.1
"""Water around a swimmer's room, by its size: less than half of what parts it from others."""


def squares(layout: Layout) -> float:
    """Return how wide a square of the ground is, m: 1, 2 or 5 times a power of ten."""
    return rounded(0.2 * layout.radius)


def add_ground(scene: Any, root: str, layout: Layout) -> None:
    """Add the ground below the node of a name."""
    cell = squares(layout)
    scene.add_grid(
        f"{root}/ground",
        infinite_grid=True,
        cell_size=cell,
        cell_color=CELL,
        cell_thickness=0.8,
        section_size=5.0 * cell,
        section_color=SECTION,
        section_thickness=1.0,
        fade_distance=16.0 * layout.radius,
        fade_strength=2.0,
        plane_color=PLANE,
        plane_opacity=0.3,
        shadow_opacity=0.22,
        position=(0.0, 0.0, -1e-3 * layout.radius),
    )


def ruler(layout: Layout) -> Array:
    """Return the ends of a bar on the ground before the bodies, m, shape (2, 3).

    It lies along the row that they stand in, on the side of the camera, and is 1, 2 or 5
    times a power of ten long.
    """
    long = rounded(LENGTH * layout.radius)
    least, most = layout.seen.min(axis=0), layout.seen.max(axis=0)
    middle = 0.5 * (least + most)
    ends = np.zeros((2, 3))
    half = np.array([-0.5, 0.5]) * long
    # Near the edge of what is seen anyway: the bodies hardly become smaller for it.
    spare = 0.05 * layout.radius
    if abs(layout.towards[0]) > abs(layout.towards[1]):
        right = layout.towards[0] > 0.0
        ends[:, 0] = most[0] + spare if right else least[0] - spare
        ends[:, 1] = middle[1] + (half if right else -half)
    else:
        ends[:, 0] = middle[0] + half
        ends[:, 1] = least[1] - spare
    return ends


def add_ruler(scene: Any, root: str, layout: Layout) -> None:
    """Add the ruler, whose label says how long it is."""
    first, last = ruler(layout)
    along = (last - first) / np.linalg.norm(last - first)
    tick = 0.02 * layout.radius * np.array([-along[1], along[0], 0.0])
    bars = [(first, last), *((end - tick, end + tick) for end in (first, last))]
    scene.add_line_segments(
        f"{root}/ruler",
        np.array(bars, dtype=np.float32),
        INK,
        thickness=3.0,
        thickness_units="screen",
    )
    long = float(np.linalg.norm(last - first))
    scene.add_label(
        f"{root}/ruler/length",
        f"{long:g} m",
        position=last + 0.02 * layout.radius * along,
        anchor="center-left",
    )


def add_water(scene: Any, root: str, layout: Layout, actors: Sequence[Actor]) -> None:
    """Add the water around those that are in it: one pool for all, or one for each."""
    wet = [at for at, actor in enumerate(actors) if actor.figure.wet]
    pools = [wet] if len(wet) == len(actors) else [[at] for at in wet if not actors[at].ghost]
    for number, pool in enumerate(pools):
        if pool:
            spare = SHORE * float(layout.sizes[pool].max())
            low, high = layout.low[pool].min(axis=0) - spare, layout.high[pool].max(axis=0) + spare
            low[2] = 0.0
            _pool(scene, root, number, low, high)


def _pool(scene: Any, root: str, number: int, low: Array, high: Array) -> None:
    wide, deep, tall = (float(each) for each in high - low)
    middle = 0.5 * (low + high)
    sheet = 1e-3 * max(wide, deep)
    # The far walls alone: near ones would veil what swims.
    for name, side, thick, opacity in (
        ("water", "back", tall, 0.16),
        ("surface", "front", sheet, 0.22),
    ):
        scene.add_box(
            f"{root}/{name}/{number}",
            color=WATER,
            dimensions=(wide, deep, thick),
            opacity=opacity,
            position=(float(middle[0]), float(middle[1]), float(high[2]) - 0.5 * thick),
            side=side,
            cast_shadow=False,
            receive_shadow=False,
        )
