"""Mismatch: the recording solid, the simulation as a ghost, and where they part."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

from morph.app.viewer.content import Content
from morph.app.viewer.given import Given
from morph.app.viewer.view import View


class Mismatch(View):
    """A recording and the simulation of it on one clock."""

    name: ClassVar[str] = "mismatch"
    title: ClassVar[str] = "Mismatch"

    def content(self) -> Content:
        """Return the recording and its ghost."""
        return Content(actors=())


def maker(given: Given) -> Callable[[], View]:
    """Return what makes this view for a person who opens the page."""
    return Mismatch
