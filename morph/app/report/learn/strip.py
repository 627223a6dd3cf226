"""A film strip: a few pictures of one run, side by side."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.physics.effect import Effect

PICTURES = 8
"""How many there are."""

SIZE = (480, 270)
"""Width and height of each, pixels: as the camera frames it, 16 to 9."""

HIDDEN = 5
"""A group of geoms that no camera looks for."""

ACROSS = 4
"""Pictures in a row of the strip."""


@dataclass(frozen=True, kw_only=True)
class Still:
    """One picture."""

    time: float
    """When, s."""
    jpeg: bytes
    """The picture."""

    @property
    def address(self) -> str:
        """The picture as an address that a page can show without loading anything."""
        return "data:image/jpeg;base64," + base64.b64encode(self.jpeg).decode()


def strip(
    robot: Robot, effects: Sequence[Effect], times: Array, positions: Array
) -> tuple[tuple[Still, ...], bytes]:
    """Return pictures of a run, evenly in time, and all of them as one JPEG.

    Args:
        robot: What moves.
        effects: What acts on it: water and ground are drawn.
        times: When, s, shape (samples,).
        positions: MuJoCo's `qpos` then, shape (samples, nq).

    Raises:
        OutputError: This machine cannot draw.
        SimulationFailed: MuJoCo refuses the scene.
    """
    from PIL import Image

    from morph.app.picture.camera import framing
    from morph.app.picture.canvas import canvas
    from morph.app.picture.scene import is_wet, scene_model, settle
    from morph.app.picture.video import snap, stage

    which = np.unique(np.linspace(0, len(times) - 1, PICTURES).round().astype(int))
    shown, wet = positions[which], is_wet(effects)
    model = scene_model(robot, effects, SIZE)
    rate = len(which) / max(float(times[-1] - times[0]), 1e-9)
    lowest = framing(model, shown, rate).lowest
    with _only_what_moves(model):
        view = framing(model, shown, rate)
    settle(model, lowest, view.radius, wet=wet)
    with canvas(model, SIZE) as drawn:
        stage(drawn, view)
        images = [
            Image.fromarray(np.ascontiguousarray(snap(drawn, view, at, position, wet)))
            for at, position in enumerate(shown)
        ]
    rows = -(-len(images) // ACROSS)
    whole = Image.new("RGB", (ACROSS * SIZE[0], rows * SIZE[1]), "white")
    stills = []
    for at, image in enumerate(images):
        whole.paste(image, (at % ACROSS * SIZE[0], at // ACROSS * SIZE[1]))
        stills.append(Still(time=float(times[which[at]]), jpeg=_saved(image)))
    return tuple(stills), _saved(whole)


@contextmanager
def _only_what_moves(model: Any) -> Iterator[None]:
    """Hide what stands still from the camera's framing: a long rail would make the robot small."""
    groups = model.geom_group.copy()
    moves = model.body_weldid[model.geom_bodyid] > 0
    if moves.any():
        model.geom_group[~moves] = HIDDEN
    try:
        yield
    finally:
        model.geom_group[:] = groups


def _saved(image: Any) -> bytes:
    buffer = io.BytesIO()
    image.save(buffer, "JPEG", quality=88)
    return buffer.getvalue()
