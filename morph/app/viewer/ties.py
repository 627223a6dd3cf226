"""Lines between links of different actors, which follow both."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from morph.app.viewer.colour import linear
from morph.app.viewer.content import Actor, Tie
from morph.app.viewer.swept_bounds import matrices
from morph.arrays import Array, Integers

THIN, THICK = 1.5, 7.0
"""Width of the weakest and of the strongest tie, in pixels."""


class Ties:
    """All ties on a scene.

    Args:
        scene: A `viser.SceneApi`.
        root: Name of the node that they are below.
        ties: The lines.
        actors: What they join.
        places: Where each actor's world begins, m, shape (actors, 3).
    """

    def __init__(
        self, scene: Any, root: str, ties: Sequence[Tie], actors: Sequence[Actor], places: Array
    ) -> None:
        """Put them on the scene; `pose` must follow."""
        self._actors, self._places = actors, places
        sides = [(tie.source, tie.target) for tie in ties]
        self._at: Integers = np.array([[side[0] for side in pair] for pair in sides], dtype=int)
        self._body: Integers = np.array(
            [[actors[at].figure.links.index(link) for at, link in pair] for pair in sides],
            dtype=int,
        )
        self._on: Array = np.array([(tie.source_at, tie.target_at) for tie in ties])
        # A set of lines has one width, so that each width is a set.
        widths = [THIN + (THICK - THIN) * min(max(tie.strength, 0.0), 1.0) for tie in ties]
        self._lines: list[tuple[list[int], Any]] = []
        for width in sorted({round(each) for each in widths}):
            which = [at for at, each in enumerate(widths) if round(each) == width]
            colours = np.array([linear(ties[at].colour) for at in which], dtype=np.uint8)
            lines = scene.add_line_segments(
                f"{root}/ties_{width}",
                np.zeros((len(which), 2, 3), dtype=np.float32),
                np.repeat(colours[:, None], 2, axis=1),
                thickness=float(width),
                thickness_units="screen",
            )
            self._lines.append((which, lines))

    def pose(self, pictures: Sequence[int]) -> None:
        """Put them where they are in a picture of each actor."""
        if not self._lines:
            return
        ends = np.empty((len(self._at), 2, 3))
        for at in np.unique(self._at):
            its, motion = self._at == at, self._actors[at].motion
            body = self._body[its]
            turn = matrices(motion.turn[pictures[at], body])
            away = (turn @ self._on[its][..., None])[..., 0]
            ends[its] = motion.position[pictures[at], body] + away + self._places[at]
        for which, lines in self._lines:
            lines.points = ends[which].astype(np.float32)
