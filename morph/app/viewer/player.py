"""One actor on a scene: its links, its colours, and what is drawn about it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from morph.app.picture.shapes import PictureShape
from morph.app.viewer.colour import linears
from morph.app.viewer.content import Actor, Colour
from morph.app.viewer.layout import Layout, title
from morph.app.viewer.pose_stream import mover
from morph.app.viewer.quiver import Quiver
from morph.app.viewer.swept_bounds import gone
from morph.arrays import Array

ARROWS: dict[str, Colour] = {
    "contact": (213, 94, 0),
    "fluid": (0, 158, 205),
    "buoyancy": (0, 158, 115),
    "torque": (204, 121, 167),
    "wrench": (200, 30, 30),
    "remaining": (0, 158, 115),
}
"""Colours of the kinds of arrows."""

SAID = {
    "wrench": "force missing as described",
    "remaining": "force still missing when corrected",
}
"""What kinds of arrows are called where their own word does not say it."""

CONSTANT = "buoyancy"
"""The kind that hardly ever changes and hides the rest: it is drawn only for who asks."""

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

NOTED = 2e-3
"""Of a body's size: a name that moves less stays."""

STILL = 1e-6
"""m, or part of a quaternion: what moved less is not sent."""


class Player:
    """What is on the scene of one actor.

    Args:
        scene: A `viser.SceneApi`.
        root: Name of its node.
        layout: Where everything stands.
        at: The actor's number there.
        actor: The actor.
    """

    def __init__(self, scene: Any, root: str, layout: Layout, at: int, actor: Actor) -> None:
        """Put it on the scene; `pose` must follow."""
        self._scene, self._actor = scene, actor
        self._move = mover(scene)
        self._root = root
        self._size = float(layout.sizes[at])
        self.place: Array = layout.places[at]
        """Where its world begins, m, shape (3,)."""
        self.gone = gone(actor)
        """How far it has gone along the ground in each picture, m, shape (pictures, 2)."""
        self._chosen: int | None = None
        scene.add_frame(self._root, show_axes=False, position=self.place)
        self._links: dict[int, Any] = {}
        self._meshes: dict[int, list[tuple[Any, Colour | None]]] = {}
        self._stand()
        links = len(actor.figure.links)
        self._position, self._turn = np.full((links, 3), np.inf), np.full((links, 4), np.inf)
        self._shown: dict[int, int | None] = dict.fromkeys(self._meshes)
        text = title(actor)
        above = layout.labels[at] - self.place
        rise = np.interp(np.arange(len(self.gone)), layout.looked, layout.rise[:, at])
        self._above = above + np.column_stack((self.gone, rise))
        self._label = text and scene.add_label(
            f"{self._root}/label", text, position=above, anchor="bottom-center"
        )
        self._quivers = {
            kind: Quiver(
                scene, f"{self._root}/arrows_{kind}", arrows, self._size, ARROWS.get(kind, CHOSEN)
            )
            for kind, arrows in actor.motion.arrows.items()
        }
        self._mark = None
        if actor.motion.marks is not None:
            self._mark = scene.add_icosphere(
                f"{self._root}/mark", radius=0.03 * self._size, color=tuple(HOT.astype(int))
            )

    def pose(self, picture: int, kinds: set[str]) -> None:
        """Put it where it is in a picture, with the arrows of some kinds."""
        self._pose_links(picture)
        self._pose_arrows(picture, kinds)
        self._colour(picture)
        if self._label:
            where = self._above[picture]
            if np.abs(where - self._label.position).max() > NOTED * self._size:
                self._label.position = where

    def choose(self, link: str | None) -> None:
        """Highlight a link by name, or with None nothing any more; `pose` must follow."""
        links = self._actor.figure.links
        self._chosen = links.index(link) if link in links else None

    def picked_by(self, what: Callable[[str], None]) -> None:
        """Have links told by name when they are clicked, from a thread of viser's."""
        links = self._actor.figure.links
        for body, meshes in self._meshes.items():
            for mesh, _ in meshes:
                mesh.on_click(lambda _, link=links[body]: what(link))

    def _stand(self) -> None:
        actor, shapes = self._actor, self._actor.figure.shapes
        links = actor.figure.links
        parts = np.bincount([shape.body for shape in shapes], minlength=len(links))
        for number, shape in enumerate(shapes):
            body = shape.body
            # Numbers, not names: a name from a file may hold what a path may not.
            name = f"{self._root}/{body}"
            if parts[body] > 1:
                if body not in self._links:
                    self._links[body] = self._scene.add_frame(name, show_axes=False)
                name = f"{name}/{number}"
            tint = actor.tints.get(links[body], actor.colour)
            if shape.colours is not None and tint is None:
                # What has a colour for each corner keeps them, whatever is pointed at.
                mesh, colour = self._painted(name, shape, shape.colours), None
            else:
                colour = tint or shape.colour
                mesh = self._plain(name, shape, colour)
            self._links.setdefault(body, mesh)
            self._meshes.setdefault(body, []).append((mesh, colour))

    def _plain(self, name: str, shape: PictureShape, colour: Colour) -> Any:
        """Put a shape of one colour on the scene."""
        actor = self._actor
        opacity = shape.opacity * (GHOST if actor.ghost else 1.0)
        return self._scene.add_mesh_simple(
            name,
            shape.vertices.astype(np.float32),
            shape.faces.astype(np.uint32),
            color=colour,
            opacity=opacity if opacity < 1.0 else None,
            flat_shading=shape.flat,
            side="double",
            cast_shadow=not actor.ghost,
            receive_shadow=not actor.ghost,
        )

    def _painted(self, name: str, shape: PictureShape, colours: NDArray[np.uint8]) -> Any:
        """Put a shape on the scene that has a colour for each corner; a ghost is solid, too."""
        from trimesh import Trimesh
        from trimesh.visual import ColorVisuals

        mesh = Trimesh(shape.vertices, shape.faces, process=False)
        # Once asked for they are sent: without them a browser shows every face.
        _ = mesh.vertex_normals
        mesh.visual = ColorVisuals(mesh, vertex_colors=linears(colours))
        return self._scene.add_mesh_trimesh(name, mesh)

    def _pose_links(self, picture: int) -> None:
        motion = self._actor.motion
        position, turn = motion.position[picture], motion.turn[picture]
        moved = np.abs(position - self._position).max(axis=1) > STILL
        spun = np.abs(turn - self._turn).max(axis=1) > STILL
        for body, node in self._links.items():
            if moved[body] or spun[body]:
                self._move(
                    node,
                    position[body] if moved[body] else None,
                    turn[body] if spun[body] else None,
                )
        self._position[moved], self._turn[spun] = position[moved], turn[spun]

    def _pose_arrows(self, picture: int, kinds: set[str]) -> None:
        for kind, quiver in self._quivers.items():
            quiver.pose(picture, shown=kind in kinds)
        if self._mark is not None and self._actor.motion.marks is not None:
            mark = self._actor.motion.marks[picture]
            shown = bool(np.isfinite(mark).all())
            if shown:
                self._mark.position = mark
            self._mark.visible = shown

    def _colour(self, picture: int) -> None:
        heat = self._actor.motion.heat
        for body, meshes in self._meshes.items():
            level = -1 if heat is None or not body else _level(heat[picture, body])
            level = LEVELS + 1 if body == self._chosen else level
            if level == self._shown[body] or (level == -1 and self._shown[body] is None):
                continue
            self._shown[body] = level
            for mesh, own in meshes:
                if own is not None:
                    mesh.color = own if level == -1 else colour_of(level)


def colour_of(level: int) -> Colour:
    """Return the colour of a step of heat, 0 to `LEVELS`; beyond, of what is pointed at."""
    if level > LEVELS:
        return CHOSEN
    red, green, blue = np.rint(COLD + level / LEVELS * (HOT - COLD)).astype(int).tolist()
    return red, green, blue


def _level(heat: float) -> int:
    # Where nothing is known, nothing is told.
    return round(LEVELS * min(max(float(heat), 0.0), 1.0)) if np.isfinite(heat) else -1
