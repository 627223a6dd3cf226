"""Bodies on a page's scene: put there once, then posed picture after picture."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from morph.app.picture.scene import rounded
from morph.app.viewer.content import Actor, Colour, Content, Tie
from morph.app.viewer.layout import Layout, laid_out
from morph.arrays import Array

ARROWS: dict[str, Colour] = {
    "contact": (213, 94, 0),
    "fluid": (0, 158, 205),
    "buoyancy": (0, 158, 115),
    "torque": (204, 121, 167),
    "wrench": (200, 30, 30),
}
"""Colours of the kinds of arrows."""

CHOSEN: Colour = (255, 196, 0)
"""What a link is coloured in while it is pointed at."""

HOT = np.array([213.0, 30.0, 20.0])
"""What a link is coloured in where it is worst."""

COLD = np.array([185.0, 192.0, 200.0])
"""And where nothing is wrong with it."""

LEVELS = 12
"""Steps between the two: a colour is only sent when its step changes."""

GHOST = 0.32
"""Opacity of a ghost."""

STILL = 1e-6
"""m, or part of a quaternion: what moved less is not sent."""

THIN, THICK = 1.5, 7.0
"""Width of the weakest and of the strongest tie, in pixels."""

FAR = 2.6
"""How far the camera is, by the radius of what it sees."""


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
        self._links: list[dict[int, Any]] = []
        self._meshes: list[list[tuple[int, Any, Colour]]] = []
        self._arrows: dict[tuple[int, str], Any] = {}
        self._marks: dict[int, Any] = {}
        self._ties: list[tuple[list[int], Any]] = []
        self._chosen: tuple[int, str] | None = None
        self._levels: dict[int, Array] = {}
        self._sent: list[tuple[Array, Array]] = []
        self.shown_arrows: set[str] = set(ARROWS)
        """The kinds of arrows that are drawn."""
        self.following = True
        """Whether the camera goes with what travels."""

    @property
    def layout(self) -> Layout:
        """Where everything stands; there must be content."""
        if self._layout is None:
            raise RuntimeError("nothing is shown yet")
        return self._layout

    def show(self, content: Content) -> None:
        """Replace all that is shown; `pose` must follow."""
        scene = self._scene
        if self._content is not None:
            scene.remove_by_name("/world")
        self._content, self._layout = content, laid_out(content.actors)
        self._links, self._meshes, self._sent = [], [], []
        self._arrows, self._marks, self._levels, self._ties = {}, {}, {}, []
        self._world = scene.add_frame("/world", show_axes=False)
        _ground(scene, self._layout)
        for at, actor in enumerate(content.actors):
            self._stand(at, actor)
        self._tie(content.ties)

    def pose(self, time: float) -> None:
        """Put everything where it is at a time on the shared clock, s."""
        content = self._content
        if content is None:
            return
        for at, actor in enumerate(content.actors):
            picture = actor.motion.at(time)
            self._pose_links(at, actor, picture)
            self._pose_arrows(at, actor, picture)
            self._colour(at, actor, picture)
        for which, lines in self._ties:
            ends = [self._ends(content, content.ties[tie], time) for tie in which]
            lines.points = np.array(ends, dtype=np.float32)
        self._world.position = -self._gone(content, time)

    def choose(self, actor: int, link: str | None) -> None:
        """Highlight a link of an actor by name, or with None nothing any more."""
        chosen = None if link is None else (actor, link)
        if chosen == self._chosen or self._content is None:
            return
        self._chosen = chosen
        for at, meshes in enumerate(self._meshes):
            links = self._content.actors[at].figure.links
            for body, mesh, own in meshes:
                mesh.color = CHOSEN if chosen == (at, links[body]) else own
        self._levels = {}

    def aim(self, camera: Any) -> None:
        """Turn a camera (of a client, or the initial one of a server) to see everything."""
        layout = self.layout
        camera.position = layout.middle + FAR * layout.radius * layout.towards
        camera.look_at = layout.middle
        camera.fov = math.radians(45.0)
        camera.near, camera.far = 0.01 * layout.radius, 200.0 * layout.radius

    def _stand(self, at: int, actor: Actor) -> None:
        scene, figure, root = self._scene, actor.figure, f"/world/{at}"
        scene.add_frame(root, show_axes=False, position=self.layout.places[at])
        frames: dict[int, Any] = {}
        meshes: list[tuple[int, Any, Colour]] = []
        links = figure.links
        for number, shape in enumerate(figure.shapes):
            body = shape.body
            if body not in frames:
                # Numbers, not names: a name from a file may hold what a path may not.
                frames[body] = scene.add_frame(f"{root}/{body}", show_axes=False)
            colour = actor.tints.get(links[body], actor.colour or shape.colour)
            opacity = shape.opacity * (GHOST if actor.ghost else 1.0)
            mesh = scene.add_mesh_simple(
                f"{root}/{body}/{number}",
                shape.vertices.astype(np.float32),
                shape.faces.astype(np.uint32),
                color=colour,
                opacity=opacity if opacity < 1.0 else None,
                flat_shading=shape.flat,
                side="double",
                cast_shadow=not actor.ghost and len(self.layout.places) == 1,
            )
            meshes.append((body, mesh, colour))
        self._links.append(frames)
        self._meshes.append(meshes)
        pictures = (len(figure.links), 3), (len(figure.links), 4)
        self._sent.append((np.full(pictures[0], np.inf), np.full(pictures[1], np.inf)))
        self._label(at, actor)
        if figure.wet:
            self._water(at)
        for kind in actor.motion.arrows:
            self._arrows[at, kind] = self._arrow(f"{root}/arrows_{kind}", kind, at)
        if actor.motion.marks is not None:
            self._marks[at] = scene.add_icosphere(
                f"{root}/mark", radius=0.05 * self._size(at), color=HOT.astype(int).tolist()
            )

    def _size(self, at: int) -> float:
        return float(np.linalg.norm(self.layout.high[at] - self.layout.low[at])) or 1.0

    def _label(self, at: int, actor: Actor) -> None:
        title = actor.figure.name if actor.title is None else actor.title
        if title:
            low, high = self.layout.low[at], self.layout.high[at]
            top = 0.5 * (low + high)
            top[2] = high[2] + 0.06 * self._size(at)
            self._scene.add_label(f"/world/label_{at}", title, position=top)

    def _water(self, at: int) -> None:
        low, high = self.layout.low[at], self.layout.high[at]
        room = 0.15 * (high - low) + 0.1 * self._size(at)
        low = np.array([*(low - room)[:2], 0.0])
        high = high + room
        self._scene.add_box(
            f"/world/water_{at}",
            color=(40, 140, 190),
            dimensions=tuple(high - low),
            opacity=0.16,
            position=0.5 * (low + high),
            side="double",
            cast_shadow=False,
            receive_shadow=False,
        )

    def _arrow(self, name: str, kind: str, at: int) -> Any:
        size = 0.012 * self._size(at)
        return self._scene.add_arrows(
            name,
            np.zeros((1, 2, 3), dtype=np.float32),
            ARROWS[kind],
            shaft_radius=size,
            head_radius=2.2 * size,
            head_length=4.0 * size,
            visible=False,
        )

    def _pose_links(self, at: int, actor: Actor, picture: int) -> None:
        position, turn = actor.motion.position[picture], actor.motion.turn[picture]
        sent, turned = self._sent[at]
        moved = np.abs(position - sent).max(axis=1) > STILL
        spun = np.abs(turn - turned).max(axis=1) > STILL
        for body, frame in self._links[at].items():
            if moved[body]:
                frame.position, sent[body] = position[body], position[body]
            if spun[body]:
                frame.wxyz, turned[body] = turn[body], turn[body]

    def _pose_arrows(self, at: int, actor: Actor, picture: int) -> None:
        for kind, all_arrows in actor.motion.arrows.items():
            handle, arrows = self._arrows[at, kind], all_arrows[picture]
            there = arrows[np.isfinite(arrows).all(axis=(1, 2))]
            shown = kind in self.shown_arrows and len(there) > 0
            if shown:
                handle.points = there.astype(np.float32)
            handle.visible = shown
        if at in self._marks and actor.motion.marks is not None:
            mark = actor.motion.marks[picture]
            shown = bool(np.isfinite(mark).all())
            if shown:
                self._marks[at].position = mark
            self._marks[at].visible = shown

    def _colour(self, at: int, actor: Actor, picture: int) -> None:
        heat = actor.motion.heat
        if heat is None:
            return
        levels = np.rint(np.clip(heat[picture], 0.0, 1.0) * LEVELS).astype(int)
        before = self._levels.get(at)
        for body, mesh, _ in self._meshes[at]:
            if body and (before is None or before[body] != levels[body]):
                share = levels[body] / LEVELS
                red, green, blue = np.rint(COLD + share * (HOT - COLD)).astype(int).tolist()
                mesh.color = (red, green, blue)
        self._levels[at] = levels

    def _tie(self, ties: Sequence[Tie]) -> None:
        # A set of lines has one width, so that each width is a set.
        widths = [THIN + (THICK - THIN) * min(max(tie.strength, 0.0), 1.0) for tie in ties]
        for width in sorted({round(each) for each in widths}):
            which = [at for at, each in enumerate(widths) if round(each) == width]
            colours = np.array([ties[at].colour for at in which], dtype=np.uint8)
            lines = self._scene.add_line_segments(
                f"/world/ties_{width}",
                np.zeros((len(which), 2, 3), dtype=np.float32),
                np.repeat(colours[:, None], 2, axis=1),
                line_width=float(width),
            )
            self._ties.append((which, lines))

    def _ends(self, content: Content, tie: Tie, time: float) -> list[Array]:
        """Return where a tie's two ends are, m, shape (3,) each."""
        ends = []
        for (at, link), place in ((tie.source, tie.source_at), (tie.target, tie.target_at)):
            actor = content.actors[at]
            body, picture = actor.figure.links.index(link), actor.motion.at(time)
            away = np.empty(3)
            mujoco.mju_rotVecQuat(away, np.array(place), actor.motion.turn[picture, body])
            where = actor.motion.position[picture, body] + away
            ends.append(where + self.layout.places[at])
        return ends

    def _gone(self, content: Content, time: float) -> Array:
        """Return how far the bodies have gone along the ground on the whole, m, shape (3,)."""
        if not self.following or not content.actors:
            return np.zeros(3)
        gone = np.zeros(3)
        for actor in content.actors:
            where = actor.motion.position[:, min(1, actor.motion.position.shape[1] - 1)]
            gone[:2] += (where[actor.motion.at(time)] - where[0])[:2] / len(content.actors)
        return gone


def _ground(scene: Any, layout: Layout) -> None:
    cell = rounded(0.35 * layout.radius)
    scene.add_grid(
        "/world/ground",
        infinite_grid=True,
        cell_size=cell,
        section_size=5.0 * cell,
        fade_distance=30.0 * layout.radius,
        plane_color=(228, 232, 238),
        plane_opacity=0.85,
        position=(0.0, 0.0, -1e-3 * layout.radius),
    )
