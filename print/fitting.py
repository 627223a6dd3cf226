"""What a part gets so that it holds something: plastic that is added, room that is cut, seats."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from morph.print.part import Seat
from morph.print.solid import union


@dataclass(frozen=True, kw_only=True, eq=False)
class Fitting:
    """One thing that a part holds, as solids in the part's frame."""

    name: str
    """What to call it in a message, such as `the pocket of an MX-28`."""
    added: tuple[Any, ...] = ()
    """Plastic that carries it."""
    removed: tuple[Any, ...] = ()
    """What must be empty."""
    seats: tuple[Seat, ...] = ()
    """What is held, and where."""
    notes: tuple[str, ...] = ()
    """What a reader should know."""


def all_removed(fittings: Sequence[Fitting]) -> list[Any]:
    """Return everything that must be empty."""
    return [solid for fitting in fittings for solid in fitting.removed]


def all_added(fittings: Sequence[Fitting]) -> list[Any]:
    """Return all plastic that carries something."""
    return [solid for fitting in fittings for solid in fitting.added]


def carried(fitting: Fitting, part: Any) -> float:
    """Return how much of the plastic that carries it is in a part, 0 to 1, room not counted."""
    if not fitting.added:
        return 1.0
    wanted = union(fitting.added) - union(fitting.removed)
    volume = float(wanted.volume())
    return float((wanted ^ part).volume()) / volume if volume > 0 else 1.0
