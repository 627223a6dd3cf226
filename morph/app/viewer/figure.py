"""What is drawn of one body: its shapes, link by link, light enough for a browser."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mujoco

from morph.app.picture.scene import is_wet
from morph.app.picture.shapes import PictureShape, shapes
from morph.app.viewer.placeholders import placeholders
from morph.app.viewer.web_shapes import web_shapes
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.errors import SimulationFailed
from morph.physics.apply import apply
from morph.physics.effect import Effect

UNSEEN = {
    "mesh-missing",
    "mesh-outside",
    "mesh-lfs-stub",
    "mesh-unreadable",
    "mesh-empty",
    "mesh-too-large",
}
"""What was found of meshes that are not drawn, or not as described."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Figure:
    """One body as it is drawn, before it moves."""

    robot: Robot
    """The body."""
    name: str
    """What it is called in headings; from a file, so never to be trusted as HTML."""
    model: Any
    """The `mujoco.MjModel` that it was drawn from, its effects applied; 0 is the world."""
    shapes: tuple[PictureShape, ...]
    """What it looks like, each in the frame of its link."""
    wet: bool = False
    """Whether it is in water."""
    notes: tuple[str, ...] = ()
    """What could not be drawn as described, in words."""

    @property
    def links(self) -> tuple[str, ...]:
        """Names of the links in the model's order, the world first."""
        return tuple(self.model.body(at).name for at in range(self.model.nbody))


def figure(robot: Robot, effects: Sequence[Effect] = (), *, name: str | None = None) -> Figure:
    """Return what is drawn of a robot under its effects.

    Args:
        robot: The robot.
        effects: What acts on it: water and ground are drawn.
        name: What to call it; by default its own name.

    Raises:
        SimulationFailed: MuJoCo refuses the description.
    """
    spec = spec_of(robot)
    apply(spec, effects)
    try:
        model = spec.compile()
    except ValueError as error:
        raise SimulationFailed(
            f"MuJoCo refuses to draw it: {error}",
            where=f"robot {robot.name}",
            fix="see what `morph inspect` says of it",
        ) from error
    notes = tuple(
        f"{finding.where}: {finding.what}" for finding in robot.findings if finding.code in UNSEEN
    )
    return Figure(
        robot=robot,
        name=robot.name if name is None else name,
        model=model,
        shapes=_drawn(model, complete=not notes),
        wet=is_wet(effects),
        notes=notes,
    )


def _drawn(model: Any, *, complete: bool) -> tuple[PictureShape, ...]:
    """Return the shapes; what has none to be seen is told by its contacts, or its inertia."""
    result = web_shapes(shapes(model)) or web_shapes(shapes(model, groups=mujoco.mjNGROUP))
    if result and complete:
        return result
    return (*result, *placeholders(model, {shape.body for shape in result}))
