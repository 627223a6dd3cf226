"""Compare: bodies side by side on one ground."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import ClassVar

from morph.app.viewer.content import Actor, Content, Table
from morph.app.viewer.figure import figure
from morph.app.viewer.given import Given
from morph.app.viewer.motion import posed
from morph.app.viewer.view import View
from morph.body.robot import Robot


class Compare(View):
    """Up to eight bodies at once."""

    name: ClassVar[str] = "compare"
    title: ClassVar[str] = "Compare"

    def __init__(self, robots: Sequence[Robot]) -> None:
        """Show robots as they stand."""
        figures = [figure(robot) for robot in robots]
        self._actors = tuple(
            Actor(figure=each, motion=posed(each.model, each.model.qpos0[None])) for each in figures
        )

    def content(self) -> Content:
        """Return the bodies and the table that compares them."""
        rows = tuple(
            (
                actor.figure.name,
                f"{actor.figure.robot.mass:.4g}",
                str(len(actor.figure.robot.joints)),
            )
            for actor in self._actors
        )
        table = Table(title="Bodies", head=("body", "mass (kg)", "joints"), rows=rows)
        return Content(actors=self._actors, tables=(table,))


def maker(given: Given) -> Callable[[], View]:
    """Return what makes this view for a person who opens the page."""
    return lambda: Compare(given.robots)
