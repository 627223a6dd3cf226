"""Every check that a part goes through before a slicer is asked."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from morph.print.check.bed_fit import bed_fit
from morph.print.check.extent import extent
from morph.print.check.manifold import manifold
from morph.print.check.one_solid import one_solid
from morph.print.check.overlap import overlap
from morph.print.check.seat_fit import seat_fit
from morph.print.check.subject import Subject
from morph.print.check.wall import wall
from morph.print.part import Check


@dataclass(frozen=True, kw_only=True)
class Rule:
    """One check, and whether those after it mean anything where it refuses."""

    name: str
    """What it is called in reports."""
    look: Callable[[Subject], Check]
    """Looks at a part."""
    first: bool = False
    """Whether nothing else can be said of a part that it refuses."""


CHECKS = (
    Rule(name="extent", look=extent, first=True),
    Rule(name="manifold", look=manifold, first=True),
    Rule(name="one solid", look=one_solid),
    Rule(name="overlap", look=overlap),
    Rule(name="wall", look=wall),
    Rule(name="bed fit", look=bed_fit),
    Rule(name="seat fit", look=seat_fit),
)
"""In the order in which they are made and told; the first is made before anything is mended."""
