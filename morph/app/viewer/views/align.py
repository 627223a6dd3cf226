"""Align: which part is which, the chain of bodies, and the guard's verdict."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

from morph.app.viewer.content import Content
from morph.app.viewer.given import Given
from morph.app.viewer.view import View


class Align(View):
    """Source and target, with lines between the parts that a map joins."""

    name: ClassVar[str] = "align"
    title: ClassVar[str] = "Align"

    def content(self) -> Content:
        """Return the bodies of the chosen hop."""
        return Content(actors=())


def maker(given: Given) -> Callable[[], View]:
    """Return what makes this view for a person who opens the page."""
    return Align
