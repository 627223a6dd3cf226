"""Ball bearings by name, and the seats that they are pressed into."""

from __future__ import annotations

from dataclasses import dataclass

from morph.print.errors import SeatError
from morph.print.mesh import Mesh, from_manifold
from morph.print.solid import rod


@dataclass(frozen=True, kw_only=True)
class Bearing:
    """A deep groove ball bearing."""

    name: str
    """Its number."""
    bore_mm: float
    """Diameter of its bore."""
    outer_mm: float
    """Its outer diameter."""
    width_mm: float
    """Its width."""
    mass: float
    """kg."""
    screw: str
    """The screw that fills its bore."""


BEARINGS = (
    # Sizes of ISO 15: softsolder.com/2011/02/18/miniature-ball-bearing-sizes (623, 608);
    # villagekit/gridbot-tahi, scad/lib.scad (688); 624 and MR105 as NopSCADlib's users have
    # them. Masses are those of steel rings of these sizes, of which a third is empty:
    # 7850 kg/m3 * 2/3 * pi / 4 * (outer2 - bore2) * width.
    Bearing(name="MR105", bore_mm=5.0, outer_mm=10.0, width_mm=4.0, mass=0.0012, screw="M5"),
    Bearing(name="623", bore_mm=3.0, outer_mm=10.0, width_mm=4.0, mass=0.0015, screw="M3"),
    Bearing(name="624", bore_mm=4.0, outer_mm=13.0, width_mm=5.0, mass=0.0031, screw="M4"),
    Bearing(name="688", bore_mm=8.0, outer_mm=16.0, width_mm=5.0, mass=0.0039, screw="M8"),
    Bearing(name="608", bore_mm=8.0, outer_mm=22.0, width_mm=7.0, mass=0.0121, screw="M8"),
)
"""Every bearing known by name."""


def bearing(name: str) -> Bearing:
    """Return a bearing by its name.

    Raises:
        SeatError: There is no such bearing.
    """
    for known in BEARINGS:
        if known.name.lower() == name.lower():
            return known
    raise SeatError(
        f"no bearing is called {name[:100]!r}; there are {', '.join(b.name for b in BEARINGS)}",
        where="morph.print.bearing",
        fix="name one of these",
    )


def seat(which: Bearing, play_mm: float) -> Mesh:
    """Return what to cut for a bearing below z = 0, its face flush, its axis z.

    Args:
        which: The bearing.
        play_mm: Room around it, on each side.
    """
    return from_manifold(rod(which.outer_mm / 2 + play_mm, -which.width_mm, 0.01))
