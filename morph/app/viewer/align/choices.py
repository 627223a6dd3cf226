"""What one person has chosen to see of a story, and how it is kept as JSON."""

from __future__ import annotations

from dataclasses import dataclass

from morph.app.viewer.align.lines import COMMANDS, STATES
from morph.arrays import JSON
from morph.errors import ViewError
from morph.policy.fields import most_of

SORTS = (STATES, COMMANDS)
"""The sorts of lines."""


@dataclass(frozen=True, kw_only=True)
class AlignChoices:
    """What is chosen."""

    hop: int
    """Number of a hop from 1 on; 0 for the whole chain."""
    way: str
    """What moves; empty for nothing."""
    sort: str = STATES
    """Which lines are drawn."""
    part: str = ""
    """Label of the arrow that is pointed at; empty for none."""
    large: bool = True
    """Whether motions are enlarged so that they are seen."""

    def said(self) -> JSON:
        """Return it as JSON."""
        return dict(vars(self))


def choices_of(document: JSON, hops: int) -> AlignChoices:
    """Return what an earlier `document` held, for a story of so many hops.

    Raises:
        ViewError: It is something else, or of another story.
    """
    names = AlignChoices.__dataclass_fields__
    if not isinstance(document, dict) or set(document) != set(names):
        raise _refused(f"it holds {most_of(document)}, and needs {', '.join(names)}")
    for name, kind in (("hop", int), ("way", str), ("sort", str), ("part", str), ("large", bool)):
        # True is an int to Python.
        if not isinstance(document[name], kind) or (
            kind is int and isinstance(document[name], bool)
        ):
            raise _refused(f"{name} is {most_of(document[name])}")
    if not 0 <= document["hop"] <= hops:
        raise _refused(f"hop is {document['hop']}, and there are {hops} hops")
    if document["sort"] not in SORTS:
        raise _refused(f"sort is {most_of(document['sort'])}, not {' or '.join(SORTS)}")
    return AlignChoices(**document)


def _refused(what: str) -> ViewError:
    return ViewError(
        what,
        where="the state of the view align",
        fix="give a state that was saved of this transfer, or open the transfer without one",
    )
