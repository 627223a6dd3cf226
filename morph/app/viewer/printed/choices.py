"""What one person chose in the view Print."""

from __future__ import annotations

from dataclasses import dataclass

from morph.arrays import JSON
from morph.errors import ViewError

APART, STEPS, PLATES = "taken apart", "step by step", "every plate"
"""Ways to show a body that are always there; a single plate goes by its name."""

COLOURINGS = ("part", "overhang", "wall thickness", "mass")
"""What colours may tell."""

LONGEST = 200
"""Characters of a name in a saved state."""


@dataclass(frozen=True, kw_only=True)
class PrintChoices:
    """What is shown, and how."""

    show: str = APART
    """One of the ways, or the name of a plate."""
    by: str = COLOURINGS[0]
    """What colours tell."""
    part: str = ""
    """The part that is pointed at; empty for none."""

    def said(self) -> JSON:
        """Return it as JSON."""
        return dict(vars(self))


def choices_of(state: JSON) -> PrintChoices:
    """Return what an earlier `said` says; a plate or a part may be gone since.

    Raises:
        ViewError: It is not of this view.
    """
    known = vars(PrintChoices())
    for name, value in state.items():
        if name not in known:
            raise _wrong(f"it says {str(name)[:80]!r}, which it does not know")
        if not isinstance(value, str) or len(value) > LONGEST:
            raise _wrong(f"{name} is no name")
    chosen = PrintChoices(**state)
    if chosen.by not in COLOURINGS:
        raise _wrong(f"colours cannot tell {chosen.by!r}; they tell {', '.join(COLOURINGS)}")
    return chosen


def _wrong(what: str) -> ViewError:
    return ViewError(
        what, where="the state of the view print", fix="give a state that was saved by this view"
    )
