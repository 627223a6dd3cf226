"""With what a page opens, beside its views."""

from __future__ import annotations

from dataclasses import dataclass

from morph.app.viewer.state import Saved
from morph.app.viewer.view_request import ViewRequest


@dataclass(frozen=True, kw_only=True, eq=False)
class Opening:
    """What every person's page begins with."""

    given: ViewRequest | None = None
    """What the viewer was given; None where something else made its views."""
    saved: Saved | None = None
    """What is shown again."""
    notes: tuple[str, ...] = ()
    """What is to be known of it, a sentence each."""
    command: str = ""
    """The command that was given, which an exported page names."""
