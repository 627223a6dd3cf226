"""A motion in the browser: the viewer with one body that has moved already."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from morph.app.viewer.content import Actor, Content
from morph.app.viewer.figure import figure
from morph.app.viewer.motion import motion
from morph.app.viewer.server import Viewer
from morph.app.viewer.view import View
from morph.arrays import Array
from morph.body.robot import Robot
from morph.errors import OutputError
from morph.physics.effect import Effect


class MotionView(View):
    """One motion, and nothing to choose."""

    name = "motion"
    title = "Motion"

    def __init__(self, content: Content) -> None:
        """Take what is shown."""
        self._content = content

    def content(self) -> Content:
        """Return what is shown."""
        return self._content


def view(
    robot: Robot,
    effects: Sequence[Effect],
    times: Array,
    positions: Array,
    *,
    ready: Callable[[Any], bool] = lambda server: True,
) -> None:
    """Serve a page that shows a motion, until the keyboard interrupts.

    Args:
        robot: What moved.
        effects: What acted on it: water and ground are drawn.
        times: When, s, shape (samples,).
        positions: MuJoCo's `qpos` then, shape (samples, nq).
        ready: Is handed the server some times a second, and says whether to go on.

    Raises:
        OutputError: The page cannot be served.
    """
    drawn = figure(robot, effects)
    moved = motion(drawn.model, times, positions)
    content = Content(actors=(Actor(figure=drawn, motion=moved),), notes=drawn.notes)
    try:
        viewer = Viewer(lambda: (MotionView(content),), label=f"morph: {robot.name}")
    except OutputError as error:
        raise OutputError(
            error.what,
            where=f"--view, {error.where}",
            fix="free a port near it, or film it by --video",
        ) from error
    viewer.wait(lambda: ready(viewer.door.server))
