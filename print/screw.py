"""Screws by name: the holes that they pass through, and those that they cut their thread into."""

from __future__ import annotations

from dataclasses import dataclass

from morph.print.errors import SeatError


@dataclass(frozen=True, kw_only=True)
class Screw:
    """A metric screw with a coarse thread."""

    name: str
    """Such as `M3`."""
    thread_mm: float
    """Outer diameter of its thread."""
    clear_mm: float
    """Diameter of a hole that it passes through."""
    tap_mm: float
    """Diameter of a hole in plastic that it cuts its thread into."""
    head_mm: float
    """Diameter of its head."""


SCREWS = (
    # Holes to pass: ISO 273, medium. Holes to cut into: the thread less about 0.8 of its
    # pitch (ISO 261: 0.4, 0.45, 0.5, 0.7, 0.8, 1.25 mm), as printed holes come out narrower.
    # Heads: cap screws, ISO 4762. ISO 273 from kapycad.com/en/learn/standards/metric-fasteners
    # (M3 to M5); the others and the heads from memory, not checked.
    Screw(name="M2", thread_mm=2.0, clear_mm=2.4, tap_mm=1.7, head_mm=3.8),
    Screw(name="M2.5", thread_mm=2.5, clear_mm=2.9, tap_mm=2.1, head_mm=4.5),
    Screw(name="M3", thread_mm=3.0, clear_mm=3.4, tap_mm=2.6, head_mm=5.5),
    Screw(name="M4", thread_mm=4.0, clear_mm=4.5, tap_mm=3.4, head_mm=7.0),
    Screw(name="M5", thread_mm=5.0, clear_mm=5.5, tap_mm=4.3, head_mm=8.5),
    Screw(name="M8", thread_mm=8.0, clear_mm=9.0, tap_mm=7.0, head_mm=13.0),
    # Not a screw: the rivet of ROBOTIS' OLLO series, which sits in a hole of 4 mm
    # (jgrizou/robotis-scad at 4c391d3, ollo/ollo_def.scad).
    Screw(name="OLLO", thread_mm=4.0, clear_mm=4.2, tap_mm=4.0, head_mm=6.0),
)
"""Every screw known by name."""


def screw(name: str) -> Screw:
    """Return a screw by its name.

    Raises:
        SeatError: There is no such screw.
    """
    for known in SCREWS:
        if known.name.lower() == name.lower():
            return known
    raise SeatError(
        f"no screw is called {name[:100]!r}; there are {', '.join(s.name for s in SCREWS)}",
        where="morph.print.screw",
        fix="name one of these",
    )
