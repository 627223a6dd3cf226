"""Design: joints and parameters of one body under a designer's hand."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

from morph.app.viewer.content import Actor, Content
from morph.app.viewer.figure import figure
from morph.app.viewer.given import Given
from morph.app.viewer.motion import posed
from morph.app.viewer.view import View
from morph.body.robot import Robot


class Design(View):
    """One body whose joints and parameters are moved by sliders."""

    name: ClassVar[str] = "design"
    title: ClassVar[str] = "Design"

    def __init__(self, robot: Robot) -> None:
        """Show a robot as it stands."""
        self._figure = figure(robot)

    def content(self) -> Content:
        """Return the body in the pose of the sliders."""
        model = self._figure.model
        return Content(actors=(Actor(figure=self._figure, motion=posed(model, model.qpos0[None])),))


def maker(given: Given) -> Callable[[], View]:
    """Return what makes this view for a person who opens the page."""
    return lambda: Design(given.robots[0])
