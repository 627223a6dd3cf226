"""Build a print package once for all sessions."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import cached_property

from morph.app.viewer.content import Actor
from morph.app.viewer.figure import figure
from morph.app.viewer.motion import posed
from morph.app.viewer.printed.choices import COLOURINGS
from morph.app.viewer.printed.source import excuse
from morph.app.viewer.printed.viewed_package import ViewedPackage
from morph.body.robot import Robot
from morph.errors import MorphError
from morph.fabrication.content import Package


class Works:
    """What all persons share.

    Args:
        robot: The body.
        make: Makes the package; it may take seconds.
    """

    def __init__(self, robot: Robot, make: Callable[[], Package]) -> None:
        """Prepare; `complete` makes."""
        self.robot, self._make = robot, make
        self.made: ViewedPackage | None = None
        """What is seen; None before it is made, or if it cannot be."""
        self.excuse = ""
        """Why it cannot be, a sentence."""
        self._lock = threading.Lock()

    @property
    def settled(self) -> bool:
        """Whether it is known what is printed, or why nothing is."""
        return self.made is not None or bool(self.excuse)

    def has(self, by: str) -> bool:
        """Return whether a colouring can be shown at once."""
        return bool(self.excuse) or (self.made is not None and self.made.has(by))

    def complete(self, by: str = COLOURINGS[0]) -> None:
        """Make what a colouring needs; whoever asks meanwhile waits for the same."""
        with self._lock:
            if not self.settled:
                try:
                    self.made = ViewedPackage(self.robot, self._make())
                except MorphError as error:
                    self.excuse = excuse(error)
            if self.made is not None:
                self.made.paint(by)

    @cached_property
    def described(self) -> Actor:
        """The body as it is described, at rest."""
        import mujoco

        drawn = figure(self.robot)
        start = mujoco.MjData(drawn.model).qpos[None]
        return Actor(figure=drawn, motion=posed(drawn.model, start), title=drawn.name)
