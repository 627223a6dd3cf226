"""The floor: one plane of the world, that every effect finds or makes."""

from __future__ import annotations

from typing import Any

import mujoco

from morph.errors import EffectError

FLOOR = "floor"
"""The plane's name, and what contacts with the world are called by: `foot+floor`."""

NOWHERE = -1000.0
"""Height, m, of a floor so far down that nothing touches it."""

EVERY = 0x7FFFFFFF
"""The collision mask that meets every shape which meets anything."""


def floor_of(spec: Any, where: str) -> Any:
    """Return the world's geom named `floor`, or its only plane; made far below if it has none.

    It is the same whichever effect asks first, so that effects may come in any order. The
    plane of a description is its floor, for a second one would double every contact.

    Args:
        spec: A `mujoco.MjSpec`.
        where: Who asks, for the error.

    Raises:
        EffectError: A link's shape is named `floor`, or the description has several planes.
    """
    result = spec.geom(FLOOR) or _own_plane(spec, where)
    if result is None:
        return spec.worldbody.add_geom(
            name=FLOOR,
            type=mujoco.mjtGeom.mjGEOM_PLANE,
            size=(0.0, 0.0, 1.0),
            pos=(0.0, 0.0, NOWHERE),
            contype=EVERY,
            conaffinity=EVERY,
        )
    if result.parent.name != spec.worldbody.name:
        raise EffectError(
            f"link {result.parent.name} has a shape named {FLOOR}, which is the world's name",
            where=where,
            fix="rename that shape in the description",
        )
    return result


def _own_plane(spec: Any, where: str) -> Any:
    """Return the plane that a description has already, named if it was not; None if it has none."""
    planes = [geom for geom in spec.worldbody.geoms if geom.type == mujoco.mjtGeom.mjGEOM_PLANE]
    if len(planes) > 1:
        raise EffectError(
            f"the description has {len(planes)} planes, and none is named {FLOOR}",
            where=where,
            fix=f"name the one that is the ground {FLOOR}",
        )
    for plane in planes:
        plane.name = plane.name or FLOOR
        return plane
    return None
