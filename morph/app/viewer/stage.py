"""Bodies on a page's scene: put there once, then posed picture after picture."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from morph.app.viewer.camera import turn
from morph.app.viewer.content import Content
from morph.app.viewer.framing import ASPECT, FIELD, Frame, framed
from morph.app.viewer.layout import Layout, laid_out
from morph.app.viewer.player import ARROWS as ARROWS
from morph.app.viewer.player import CONSTANT, Player
from morph.app.viewer.surroundings import add_ground, add_ruler, add_water, ruler
from morph.app.viewer.ties import Ties
from morph.arrays import Array


class Stage:
    """What is shown on one scene.

    Args:
        scene: A `viser.SceneApi`, of a server or of one client.
    """

    def __init__(self, scene: Any) -> None:
        """Begin with nothing."""
        self._scene = scene
        self._content: Content | None = None
        self._layout: Layout | None = None
        self._players: list[Player] = []
        self._ties: Ties | None = None
        self._shows, self._root = 0, ""
        self._held = np.zeros(3)
        self._aimed: tuple[float, Frame] | None = None
        self._anew = False
        self.shown_arrows: set[str] = set(ARROWS) - {CONSTANT}
        """The kinds of arrows that are drawn."""
        self.following = True
        """Whether the camera goes with what travels."""
        self.picked: Callable[[int, str], None] | None = None
        """Told an actor's number and a link's name when the link is clicked, from a thread of
        viser's; ghosts are looked through. It holds for what is shown after it is set."""

    @property
    def layout(self) -> Layout:
        """Where everything stands; there must be content."""
        if self._layout is None:
            raise RuntimeError("nothing is shown yet")
        return self._layout

    @property
    def hidden_arrows(self) -> frozenset[str]:
        """The kinds of arrows that are not drawn."""
        return frozenset(ARROWS) - self.shown_arrows

    def show(self, content: Content, *, still: bool = False) -> None:
        """Replace all that is shown; `pose` must follow.

        Args:
            content: What is shown.
            still: Whether the first actor stays where it stands, such as a body whose size
                changes under a designer's eyes.
        """
        scene = self._scene
        if self._content is not None:
            scene.remove_by_name(self._root)
        # A name that no node had before: where a slow page takes removal and addition at once, it
        # keeps the old pose for the new node, and viser sends none that equals the default.
        self._shows += 1
        self._root = f"/world_{self._shows}"
        layout = laid_out(content.actors)
        self._held = self._shift(layout) if still else np.zeros(3)
        self._content, self._layout = content, layout
        self._world = scene.add_frame(self._root, show_axes=False)
        add_ground(scene, self._root, layout)
        add_ruler(scene, self._root, layout)
        self._players = [
            Player(scene, f"{self._root}/{at}", layout, at, actor)
            for at, actor in enumerate(content.actors)
        ]
        if self.picked is not None:
            for at, actor in enumerate(content.actors):
                if not actor.ghost:
                    self._players[at].picked_by(partial(self.picked, at))
        add_water(scene, self._root, layout, content.actors)
        self._ties = Ties(scene, self._root, content.ties, content.actors, layout.places)

    def pose(self, time: float) -> None:
        """Put everything where it is at a time on the shared clock, s."""
        content = self._content
        if content is None:
            return
        pictures = [actor.motion.at(time) for actor in content.actors]
        for player, picture in zip(self._players, pictures, strict=True):
            player.pose(picture, self.shown_arrows)
        if self._ties is not None:
            self._ties.pose(pictures)
        self._world.position = self._held - self._gone(pictures)

    def choose(self, actor: int, link: str | None) -> None:
        """Highlight a link of an actor by name, or with None nothing any more.

        It is seen with the next `pose`.
        """
        for at, player in enumerate(self._players):
            player.choose(link if at == actor else None)

    def aim(self, camera: Any, aspect: float | None = None) -> None:
        """Turn a camera so that it sees everything from as near as can be.

        Args:
            camera: Of a client, or the initial one of a server.
            aspect: Width of its picture by its height; by default as a client's camera tells.
        """
        layout = self.layout
        self._held = np.zeros(3)
        if aspect is None:
            aspect = float(getattr(camera, "aspect", ASPECT))
        points = np.concatenate((layout.seen, ruler(layout)))
        frame = framed(points, layout.towards, aspect)
        self._aimed, self._anew = (aspect, frame), False
        camera.fov = FIELD
        turn(camera, frame.position, frame.target)
        camera.near, camera.far = 0.01 * frame.distance, 100.0 * frame.distance

    def reaim(self) -> None:
        """Have a client's camera aimed with the next `refit`, if nobody moved it since."""
        self._anew = True

    def refit(self, camera: Any) -> None:
        """Aim a client's camera anew if that was asked for, or its picture has another shape.

        A camera that a person has moved since it was aimed stays where it is. It is asked
        before every picture: a browser tells the shape some time after the panel is there.
        """
        if self._aimed is None:
            return
        aspect, frame = self._aimed
        now = float(getattr(camera, "aspect", aspect))
        if not self._anew and abs(now - aspect) < 0.01 * aspect:
            return
        moved = camera.position - frame.position, camera.look_at - frame.target
        if max(map(np.linalg.norm, moved)) < 1e-3 * frame.distance:
            self.aim(camera)

    def _shift(self, layout: Layout) -> Array:
        """Return how the ground must move so that the first actor seems to stay, m, shape (3,)."""
        before = self._layout
        if before is None or not len(before.places) or not len(layout.places):
            return np.zeros(3)
        moved = self._held + before.places[0] - layout.places[0]
        return np.array([moved[0], moved[1], 0.0])

    def _gone(self, pictures: list[int]) -> Array:
        """Return how far the bodies have gone along the ground on the whole, m, shape (3,)."""
        gone = np.zeros(3)
        if self.following and self._players:
            ways = [player.gone[at] for player, at in zip(self._players, pictures, strict=True)]
            gone[:2] = np.mean(ways, axis=0)
        return gone
