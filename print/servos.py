"""Sizes of servos, each with where they come from."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal


@dataclass(frozen=True, kw_only=True)
class Horn:
    """What a servo turns: a disc with a circle of holes, or an arm."""

    diameter_mm: float
    """Of the disc, or of the arm's hub."""
    top_mm: float
    """From the case's top to where what it turns begins."""
    centre_mm: float
    """Diameter of the hole through which its own screw is reached."""
    circle_mm: float = 0.0
    """Diameter of the circle on which its screws lie; 0 of an arm."""
    count: int = 0
    """How many screws there are, the first along x."""
    screw: str = "M2"
    """The screws."""
    arm_mm: tuple[float, float, float] | None = None
    """Of an arm: length from the axis, radius of its tip, thickness."""


@dataclass(frozen=True, kw_only=True)
class Flange:
    """Two tabs by which a servo is screwed onto a rim."""

    length_mm: float
    """Over both tabs, about the middle of the case."""
    depth_mm: float
    """From the case's top to the tabs' underside."""
    thickness_mm: float
    """Of the tabs."""


@dataclass(frozen=True, kw_only=True)
class ServoSize:
    """A servo's size, in a frame on its axis, z out of the case, x towards the far end."""

    name: str
    """The maker's name for it."""
    length_mm: float
    """Of the case along x."""
    width_mm: float
    """Of the case along y; the axis is in its middle."""
    height_mm: float
    """Of the case along z, below 0."""
    axis_mm: float
    """From the case's near end to the axis."""
    horn: Horn
    """What it turns."""
    holes_mm: tuple[tuple[float, float], ...]
    """x and y of the holes that hold it; none: their places are not known, a strap holds it."""
    hole_screw: str
    """The screws that go into them."""
    held_by: Literal["floor", "rim", "strap"]
    """Whether the holes are in the case's floor, or in the tabs of its flange."""
    wires_mm: tuple[float, float, float]
    """Window in the floor for its wires: x from, x to, and half of its width."""
    mass: float
    """kg."""
    source: str
    """Where the figures come from."""
    flange: Flange | None = None
    """Its tabs, if it has some."""


AX_12 = ServoSize(
    name="AX-12",
    length_mm=50.0,
    width_mm=32.0,
    height_mm=38.0,
    axis_mm=11.5,
    horn=Horn(diameter_mm=22.0, top_mm=2.0, centre_mm=6.0, circle_mm=16.0, count=4),
    holes_mm=(),
    hole_screw="M2",
    held_by="strap",
    wires_mm=(12.0, 30.0, 10.0),
    mass=0.0546,
    source=(
        "ROBOTIS e-manual, dxl/ax: 32 by 50 by 40 mm and the mass. From memory, not checked: 38 of "
        "the 40 mm are case, the axis is 11.5 mm from its end, horn of 22 mm, screws on a circle "
        "of 16 mm"
    ),
)
"""The AX-12A, whose case the AX-18A shares."""

SERVOS = (
    ServoSize(
        name="STS3215",
        length_mm=45.2,
        width_mm=24.7,
        height_mm=35.0,
        axis_mm=10.1,
        horn=Horn(diameter_mm=19.6, top_mm=2.7, centre_mm=7.0, circle_mm=14.0, count=4, screw="M3"),
        holes_mm=((8.3, 10.25), (8.3, -10.25), (32.75, 10.25), (32.75, -10.25)),
        hole_screw="M2",
        held_by="floor",
        wires_mm=(11.2, 16.9, 10.5),
        mass=0.055,
        source=(
            "Case, axis, horn and holes of 20.5 by 24.45 mm: plastibot/nenemiz, "
            "openscad/config.scad, for the LX-16A, which has the same case; the same holes, and "
            "the sockets, of the STS3215: tests of the robot spiderpig on GitHub; "
            "40.4 mm over both horns: mesh sts3215_03a of SO-ARM100. M3 in the horn: from memory, "
            "not checked"
        ),
    ),
    ServoSize(
        name="XL-320",
        length_mm=36.0,
        width_mm=24.0,
        height_mm=24.0,
        axis_mm=9.0,
        horn=Horn(
            diameter_mm=18.0, top_mm=3.0, centre_mm=4.0, circle_mm=12.0, count=4, screw="OLLO"
        ),
        holes_mm=((24.0, -6.0), (24.0, 0.0), (24.0, 6.0)),
        hole_screw="OLLO",
        held_by="floor",
        wires_mm=(8.0, 18.0, 8.0),
        mass=0.0167,
        source=(
            "ROBOTIS e-manual, dxl/x/xl320: 24 by 36 by 27 mm, 16.7 g. Axis, horn and holes 6 mm "
            "apart: jgrizou/robotis-scad at cdce19c, dynamixel/xl320_def.scad and xl320.scad"
        ),
    ),
    AX_12,
    replace(AX_12, name="AX-18", mass=0.0559),
    ServoSize(
        name="MX-28",
        length_mm=50.6,
        width_mm=35.6,
        height_mm=35.5,
        axis_mm=12.8,
        horn=Horn(diameter_mm=22.0, top_mm=3.0, centre_mm=6.0, circle_mm=16.0, count=8),
        holes_mm=(),
        hole_screw="M2.5",
        held_by="strap",
        wires_mm=(14.0, 30.0, 10.0),
        mass=0.072,
        source=(
            "ROBOTIS e-manual, dxl/mx/mx-28: 35.6 by 50.6 by 35.5 mm, 72 g. Axis and horn: "
            "RhobanProject/MetabotStudio at 1518e66, backends/dxl/models/mx28.scad, mx28-arm.scad"
        ),
    ),
    ServoSize(
        name="MX-64",
        length_mm=61.1,
        width_mm=40.2,
        height_mm=41.0,
        axis_mm=12.55,
        horn=Horn(
            diameter_mm=28.0, top_mm=3.0, centre_mm=6.0, circle_mm=22.0, count=8, screw="M2.5"
        ),
        holes_mm=(),
        hole_screw="M2.5",
        held_by="strap",
        wires_mm=(16.0, 34.0, 11.0),
        mass=0.126,
        source=(
            "ROBOTIS e-manual, dxl/mx/mx-64: 40.2 by 61.1 by 41 mm, 126 g. Axis and horn: "
            "RhobanProject/MetabotStudio at 1f6996e, backends/dxl/models/mx64.scad, mx64-arm.scad"
        ),
    ),
    ServoSize(
        name="SG90",
        length_mm=22.8,
        width_mm=12.6,
        height_mm=22.5,
        axis_mm=5.9,
        horn=Horn(diameter_mm=7.4, top_mm=4.3, centre_mm=2.8, arm_mm=(17.2, 2.2, 1.8)),
        holes_mm=((-8.4, 0.0), (19.4, 0.0)),
        hole_screw="M2",
        held_by="rim",
        wires_mm=(-4.0, 4.0, 3.0),
        mass=0.009,
        source=(
            "As measured by users, the greatest of figures that differ by 0.6 mm: see "
            "robots/quadruped_printed/card.toml; holes 27.8 mm apart, flange at 15.9 mm of 22.5"
        ),
        flange=Flange(length_mm=32.5, depth_mm=6.6, thickness_mm=2.5),
    ),
)
"""Every servo known by name."""
