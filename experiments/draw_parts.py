"""Draws the parts of `robots/quadruped_printed`: `python -m experiments.draw_parts`.

All lengths are in millimetres, as slicers take them. Each part lies in the frame of its link:
the body's in the middle of its plate, the upper leg's on the hip's axis in the plane of the
horn, the lower leg's on the knee's axis in the middle of its thickness.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from manifold3d import Manifold

from morph.body.mesh import Mesh, as_stl
from morph.files import write_whole

FOLDER = Path(__file__).resolve().parent.parent / "robots" / "quadruped_printed" / "meshes"

ROUND = 48
"""Sides of a cylinder; of a small one half as many."""
SMALL = 3.0
"""Radius up to which a cylinder is small."""
CUT = 1.0
"""How far a cut reaches beyond what it cuts."""


@dataclass(frozen=True, kw_only=True)
class MicroServo:
    """A 9 g servo of the size of the SG90, mm.

    Sources: nnarain/openscad-servos, TimPhillip/3d-printing, mariolukas/openexposer and
    Elektro8p/Vitamins, who each measured one and agree within 0.5; a pocket takes the greatest.
    """

    length: float = 22.8
    """Of the case, across the flange's holes."""
    width: float = 12.6
    """Of the case."""
    base: float = 15.9
    """From the case's bottom to the flange."""
    flange: float = 2.5
    """Thickness of the flange."""
    flange_length: float = 32.5
    """Of the flange."""
    top: float = 26.8
    """From the case's bottom to where the spline begins, and the horn sits."""
    offset: float = 5.5
    """From the middle of the case to the axis."""
    holes: float = 27.8
    """Between the flange's holes, which are slots: 27.5 to 28.5."""


SERVO = MicroServo()

GAP = 0.2
"""Room on each side between a servo and its pocket."""
PILOT = 0.85
"""Radius of a hole that a screw of 2 mm cuts its thread into."""
HORN_LENGTH, HORN_HUB, HORN_TIP, HORN_THICK = 17.2, 3.7, 2.2, 1.8
"""One arm of the horn that comes with the servo: length from the axis, radii, thickness."""
HORN_SCREW, HORN_HEAD = 1.4, 2.9
"""Radius of the horn's own screw, and of its head."""

PLATE = 3.0
"""Thickness of the body's plate."""
HIP = 35.0
"""Of a hip from the middle, forward and to the side."""
HORN = PLATE / 2 + SERVO.top - SERVO.base
"""Of the plane of the hips' horns above the middle of the plate."""
CORNER = 14.0
"""Radius of the plate about a hip."""
BOARD = (58.0, 23.0)
"""Between the holes of a Raspberry Pi Zero, from its mechanical drawing."""

ARM, ARM_THICK = 8.0, 5.0
"""Half the width, and the thickness, of the upper leg's arm."""
KNEE = (50.0, 0.0, -8.5)
"""Of the knee's axis from the hip's: outward, left, up."""
NECK = 16.0
"""Length along which the arm and the shelf over the wall are one."""
WALL = 3.0
"""Thickness of the wall that holds the knee's servo."""
SHIN, SHIN_THICK, FOOT = 65.0, 5.0, 5.0
"""Length, thickness and foot's radius of the lower leg."""
SEAT = -(SHIN_THICK / 2 + SERVO.top - SERVO.base)
"""Where the flange of the knee's servo rests on the wall, to the side of the leg's middle."""


def box(low: tuple[float, ...], high: tuple[float, ...]) -> Manifold:
    """Return the box between two corners."""
    size = tuple(b - a for a, b in zip(low, high, strict=True))
    return Manifold.cube(size).translate(low)


def rod(radius: float, low: float, high: float, at: tuple[float, ...] = (0, 0)) -> Manifold:
    """Return a cylinder along z, between two heights."""
    sides = ROUND if radius > SMALL else ROUND // 2
    return Manifold.cylinder(high - low, radius, radius, sides).translate((at[0], at[1], low))


def pocket(depth: float) -> Manifold:
    """Return what to cut for a servo from a wall below z = 0, on which its flange rests.

    Its axis is z, and its case lies along -x.
    """
    length, width = SERVO.length / 2 + GAP, SERVO.width / 2 + GAP
    case = box((-length, -width, -depth - CUT), (length, width, CUT))
    screws = [rod(PILOT, -depth - CUT, CUT, (side * SERVO.holes / 2, 0)) for side in (-1, 1)]
    return sum(screws, case).translate((-SERVO.offset, 0, 0))


def horn(thickness: float) -> Manifold:
    """Return what to cut for a horn, whose arm lies along x, from what is above z = 0."""
    hub = rod(HORN_HUB, -CUT, HORN_THICK)
    tip = rod(HORN_TIP, -CUT, HORN_THICK, (HORN_LENGTH - HORN_TIP, 0))
    screw = rod(HORN_SCREW, -CUT, thickness + CUT)
    head = rod(HORN_HEAD, thickness - 1.6, thickness + CUT)
    return Manifold.batch_hull([hub, tip]) + screw + head


def body() -> Manifold:
    """Return the plate, with a pocket for a servo at each hip and holes for a board."""
    corners = list(itertools.product((-HIP, HIP), repeat=2))
    half = PLATE / 2
    plate = Manifold.batch_hull([rod(CORNER, -half, half, corner) for corner in corners])
    for angle in (45.0, 135.0, 225.0, 315.0):
        reach = math.hypot(HIP, HIP)
        plate -= pocket(PLATE).translate((reach, 0, half)).rotate((0, 0, angle))
    for x, y in itertools.product((-0.5, 0.5), repeat=2):
        plate -= rod(1.35, -half - CUT, half + CUT, (x * BOARD[0], y * BOARD[1]))
    return plate - rod(9.0, -half - CUT, half + CUT)


def upper_leg() -> Manifold:
    """Return the arm on the hip's horn, with the wall that holds the knee's servo."""
    middle = KNEE[0] - SERVO.offset
    near, far = middle - SERVO.flange_length / 2 - 3.0, middle + SERVO.flange_length / 2 + 3.0
    low = KNEE[2] - SERVO.width / 2 - GAP - 3.0
    arm = rod(ARM, 0, ARM_THICK) + box((0, -ARM, 0), (near + NECK, ARM, ARM_THICK))
    shelf = box((near, SEAT - WALL, 0), (far, -SHIN_THICK / 2 - 1.5, ARM_THICK))
    wall = box((near, SEAT - WALL, low), (far, SEAT, ARM_THICK))
    # The pocket's axis turns from z to y: its case then lies along -x, below the flange in -y.
    cut = pocket(WALL).rotate((-90, 0, 0)).translate((KNEE[0], SEAT, KNEE[2]))
    return arm + shelf + wall - cut - horn(ARM_THICK)


def lower_leg() -> Manifold:
    """Return the leg from the knee's horn, on its right, down to a round foot."""
    half = SHIN_THICK / 2
    knee = rod(7.5, -half, half)
    ankle = rod(FOOT, -half, half, (SHIN, 0))
    foot = rod(FOOT, -half - 2.5, half + 2.5, (SHIN, 0))
    flat = Manifold.batch_hull([knee, ankle]) + foot - horn(SHIN_THICK).translate((0, 0, -half))
    # Drawn along x with the horn below; x turns down, and what was below to the right.
    return flat.rotate((-90, 90, 0))


PARTS = {"body": body, "upper_leg": upper_leg, "lower_leg": lower_leg}
"""Every part, by the name of its file."""


def mesh_of(part: Manifold) -> Mesh:
    """Return a part as a mesh, mm."""
    drawn = part.to_mesh64()
    return Mesh(
        vertices=np.asarray(drawn.vert_properties, dtype=np.float64)[:, :3],
        faces=np.asarray(drawn.tri_verts, dtype=np.int64),
    )


def main() -> None:
    """Write the parts as STL."""
    for name, draw in PARTS.items():
        mesh = mesh_of(draw())
        write_whole(FOLDER / f"{name}.stl", as_stl(mesh))
        print(f"{name}: {mesh.volume / 1000:.2f} cm3, {len(mesh.faces)} faces")


if __name__ == "__main__":
    main()
