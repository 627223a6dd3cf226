"""A motion as a film: MP4, or GIF where only that can be shown."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from morph.app.picture.camera import AZIMUTH, ELEVATION, Framing, framing
from morph.app.picture.canvas import Canvas, Picture, canvas
from morph.app.picture.encode import gif, mp4
from morph.app.picture.endings import FILMS, PICTURES
from morph.app.picture.scene import is_wet, scene_model, settle
from morph.app.picture.times import nearest_samples
from morph.arrays import Array
from morph.body.robot import Robot
from morph.errors import OutputError
from morph.physics.effect import Effect

LAMP = 8.0
"""How far the lamp is, by the radius of what moves; from nearer a slope is shaded in specks."""

MOTES = 160
"""Specks that float in water, so that one sees what moves."""


def film(
    robot: Robot,
    effects: Sequence[Effect],
    times: Array,
    positions: Array,
    path: Path,
    *,
    progress: Callable[[float], None] = lambda share: None,
) -> Path:
    """Write a film of a motion in real time and return its path.

    Args:
        robot: What moves.
        effects: What acts on it: water and ground are drawn.
        times: When, s, shape (samples,).
        positions: MuJoCo's `qpos` then, shape (samples, nq).
        path: Where to; the ending is one of `FILMS`.
        progress: Is told the share of the pictures that are drawn.

    Raises:
        OutputError: The file cannot be written, or this machine cannot draw.
        SimulationFailed: MuJoCo refuses the scene.
    """
    rate, size = FILMS[path.suffix.lower()]
    shown = positions[nearest_samples(times, rate)]
    wet = is_wet(effects)
    model = scene_model(robot, effects, size)
    view = framing(model, shown, rate)
    settle(model, view.lowest, view.radius, wet=wet)
    encode = mp4 if path.suffix.lower() == ".mp4" else gif
    with canvas(model, size) as drawn, _whole(path) as temporary:
        encode(temporary, _pictures(drawn, view, shown, wet, progress), rate, size)
    return path


def picture(robot: Robot, effects: Sequence[Effect], position: Array, path: Path) -> Path:
    """Write one picture of a robot and return its path.

    Args:
        robot: The robot.
        effects: What acts on it: water and ground are drawn.
        position: MuJoCo's `qpos`, shape (nq,).
        path: Where to; the ending is one of `PICTURES`.

    Raises:
        OutputError: As `film`.
        SimulationFailed: As `film`.
    """
    from PIL import Image

    size, shown = PICTURES[path.suffix.lower()], position[None]
    wet = is_wet(effects)
    model = scene_model(robot, effects, size)
    view = framing(model, shown, 1.0)
    settle(model, view.lowest, view.radius, wet=wet)
    with canvas(model, size) as drawn, _whole(path) as temporary:
        for each in _pictures(drawn, view, shown, wet, lambda share: None):
            Image.fromarray(np.ascontiguousarray(each)).save(temporary)
    return path


def _pictures(
    drawn: Canvas, view: Framing, shown: Array, wet: bool, progress: Callable[[float], None]
) -> Iterator[Picture]:
    stage(drawn, view)
    for at, position in enumerate(shown):
        yield snap(drawn, view, at, position, wet)
        progress((at + 1) / len(shown))


def stage(drawn: Canvas, view: Framing) -> None:
    """Set up the camera and how light behaves."""
    camera = drawn.camera
    camera.type = mujoco.mjtCamera.mjCAMERA_FREE
    camera.azimuth, camera.elevation, camera.distance = AZIMUTH, ELEVATION, view.distance
    flags = drawn.scene.flags
    flags[mujoco.mjtRndFlag.mjRND_SHADOW] = True
    flags[mujoco.mjtRndFlag.mjRND_FOG] = True
    flags[mujoco.mjtRndFlag.mjRND_SKYBOX] = True


def snap(drawn: Canvas, view: Framing, at: int, position: Array, wet: bool) -> Picture:
    """Return one picture."""
    drawn.camera.lookat[:] = view.lookat[at]
    drawn.place(position)
    for index in range(drawn.scene.nlight):
        light = drawn.scene.lights[index]
        if light.castshadow and not light.headlight:
            # A lamp far away casts shadows only near its own place: it goes with the camera.
            light.pos[:] = view.lookat[at] - LAMP * view.radius * np.asarray(light.dir)
    if wet:
        _motes(drawn.scene, view.lookat[at], view.distance)
    return drawn.draw()


def _motes(scene: Any, lookat: Array, room: float) -> None:
    """Add specks that stand still in the water, always some around where the camera looks."""
    rng = np.random.default_rng(0)
    place = rng.uniform(0.0, room, (MOTES, 3))
    # A speck that is left behind comes again in front.
    place = lookat + (place - lookat + 0.5 * room) % room - 0.5 * room
    size = room * rng.uniform(0.0008, 0.0022, MOTES)
    for where, radius in zip(place, size, strict=True):
        if scene.ngeom >= scene.maxgeom:
            return
        mujoco.mjv_initGeom(
            scene.geoms[scene.ngeom],
            mujoco.mjtGeom.mjGEOM_SPHERE.value,
            np.full(3, radius),
            where,
            np.eye(3).ravel(),
            np.array([0.85, 0.97, 1.0, 0.5], dtype=np.float32),
        )
        scene.geoms[scene.ngeom].category = mujoco.mjtCatBit.mjCAT_DECOR.value
        scene.ngeom += 1


@contextmanager
def _whole(path: Path) -> Iterator[Path]:
    """Lend a path beside a file; it takes the file's place when all went well."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=".", suffix=path.suffix.lower())
        os.close(handle)
    except OSError as error:
        raise _unwritten(path, error) from error
    temporary = Path(name)
    try:
        yield temporary
        temporary.chmod(0o644)
        os.replace(temporary, path)
    except OSError as error:
        raise _unwritten(path, error) from error
    finally:
        temporary.unlink(missing_ok=True)


def _unwritten(path: Path, error: OSError) -> OutputError:
    return OutputError(
        f"cannot write: {error.strerror or error}",
        where=str(path),
        fix="choose a folder that exists, can be written to and has room",
    )
