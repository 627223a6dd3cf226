"""A link in a fluid from 15 published numbers: the way of those who measured their robot."""

from __future__ import annotations

import math
from collections.abc import Sequence

from morph.errors import RobotError
from morph.physics.effect import Effect
from morph.physics.fluid.added_mass import AddedMass
from morph.physics.fluid.buoyancy import Buoyancy
from morph.physics.fluid.quadratic_drag import QuadraticDrag
from morph.physics.fluid.wet import AXES
from morph.physics.fluid.wetted.fit import check_density
from morph.physics.fluid.wetted.panels import box_drag


def boxed(
    body: str,
    *,
    sides: Sequence[float],
    added: Sequence[float],
    drag: Sequence[float],
    density: float,
    centre: Sequence[float] = (0.0, 0.0, 0.0),
    volume: float | None = None,
) -> tuple[Effect, ...]:
    """Return what a fluid does to a link that is taken for a box: 15 numbers and a density.

    Source: Georgiades 2005, "Simulation and control of an underwater hexapod robot", McGill
    University: added mass as measured or estimated, quadratic drag by `box_drag`.

    Args:
        body: The link's name.
        sides: Of the box along the link's axes, m, 3.
        added: Added mass along the link's axes, kg, and about them through the centre, kg m2; 6.
        drag: Drag coefficients of the faces square to the link's axes, 3.
        density: Of the fluid, kg/m3.
        centre: Of the box, in the link's frame, m, 3.
        volume: Displaced, m3; by default that of the box.

    Raises:
        RobotError: There are not as many numbers, a side or the volume is not positive, or
            a coefficient or an added mass is negative.
        EffectError: The density is not a positive number.
    """
    where = f"link {body} as a box"
    for name, values, count in (
        ("sides", sides, 3),
        ("centre", centre, 3),
        ("added", added, 6),
        ("drag", drag, 3),
    ):
        if len(values) != count or not all(math.isfinite(value) for value in values):
            raise RobotError(
                f"its {name} are {list(values)}", where=where, fix=f"give {count} finite numbers"
            )
    if min(added) < 0.0:
        raise RobotError(
            f"its added masses are {list(added)}", where=where, fix="give six numbers, 0 or more"
        )
    check_density(density, where=where)
    q = density * box_drag(sides, drag)
    displaced = math.prod(sides) if volume is None else volume
    if not (math.isfinite(displaced) and displaced > 0.0):
        raise RobotError(f"it displaces {displaced:g} m3", where=where, fix="give a volume above 0")
    place = dict(zip(("cx", "cy", "cz"), (float(value) for value in centre), strict=True))
    return (
        AddedMass(body=body, **dict(zip(AXES, map(float, added), strict=True)), **place),
        Buoyancy(body=body, volume=displaced, density=density, **place),
        QuadraticDrag(body=body, **dict(zip(AXES, q.tolist(), strict=True)), **place),
    )
