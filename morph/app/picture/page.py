"""A motion in the browser: to be turned, stopped and played again."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, redirect_stdout
from dataclasses import dataclass
from io import StringIO
from typing import Any

import mujoco
import numpy as np

from morph.app.picture.camera import Framing, framing
from morph.app.picture.scene import FLOOR, is_wet, rounded, scene_model, settle
from morph.app.picture.shapes import shapes
from morph.app.picture.times import nearest_samples
from morph.arrays import Array
from morph.body.robot import Robot
from morph.errors import OutputError
from morph.physics.effect import Effect

RATE = 30.0
"""Pictures a second."""

HOST, PORT = "127.0.0.1", 8080
"""Where the page is served: to this machine only. A port that is taken leads to the next."""

SPEEDS = ("0.1", "0.25", "0.5", "1", "2", "4")
"""How fast it may be played, by how fast it moved."""

FAR = 2.2
"""How far the camera is in the browser, by the radius of what moves, along (0.5, -0.9, 0.4)."""


@dataclass(frozen=True, kw_only=True)
class Poses:
    """Where every body is in every picture."""

    position: Array
    """m, shape (pictures, bodies, 3)."""
    turn: Array
    """Unit quaternions, w first, shape (pictures, bodies, 4)."""
    gone: Array
    """How far the camera has gone with the robot, m, shape (pictures, 3)."""


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
        ready: Is handed the server between pictures, and says whether to go on.

    Raises:
        OutputError: The page cannot be served.
    """
    from viser import ViserServer

    model = scene_model(robot, effects, (64, 64))
    shown = positions[nearest_samples(times, RATE)]
    look = framing(model, shown, RATE)
    settle(model, look.lowest, look.radius, wet=is_wet(effects))
    try:
        with _silence():
            server = ViserServer(host=HOST, port=PORT, label=f"morph: {robot.name}", verbose=False)
    except OSError as error:
        raise OutputError(
            f"no page can be served: {error.strerror or error}",
            where=f"--view, http://{HOST}:{PORT}",
            fix="free a port near it, or film it by --video",
        ) from error
    try:
        frames = _scene(server, model, look)
        sys.stderr.write(f"see http://localhost:{server.get_port()} (end with Ctrl-C)\n")
        sys.stderr.flush()
        _play(server, frames, _poses(model, shown, look), ready)
    except KeyboardInterrupt:
        # Looking ends by an interrupt; nothing is lost by it.
        sys.stderr.write("\n")
    finally:
        with _silence():
            server.stop()


def _silence() -> AbstractContextManager[Any]:
    """Keep viser's greetings off the standard output, which is for what a command answers."""
    return redirect_stdout(StringIO())


def _poses(model: Any, shown: Array, look: Framing) -> Poses:
    data = mujoco.MjData(model)
    position = np.empty((len(shown), model.nbody, 3))
    turn = np.empty((len(shown), model.nbody, 4))
    for at, coordinates in enumerate(shown):
        data.qpos[:] = coordinates
        mujoco.mj_kinematics(model, data)
        position[at], turn[at] = data.xpos, data.xquat
    return Poses(position=position, turn=turn, gone=look.lookat - look.lookat[0])


def _scene(server: Any, model: Any, look: Framing) -> dict[int, Any]:
    """Add everything to the page and return the frame of each body; the world's is 0."""
    scene = server.scene
    scene.set_up_direction("+z")
    frames = {0: scene.add_frame("/world", show_axes=False)}
    for at, shape in enumerate(shapes(model)):
        body = shape.body
        if body not in frames and body:
            frames[body] = scene.add_frame(f"/world/{body}", show_axes=False)
        scene.add_mesh_simple(
            f"/world/{body}/{at}" if body else f"/world/fixed_{at}",
            shape.vertices,
            shape.faces,
            color=shape.colour,
            opacity=shape.opacity if shape.opacity < 1.0 else None,
            flat_shading=shape.flat,
            side="double",
        )
    _ground(scene, model, look)
    server.initial_camera.look_at = look.lookat[0]
    server.initial_camera.fov = math.radians(45.0)
    server.initial_camera.position = look.lookat[0] + FAR * look.radius * np.array([0.5, -0.9, 0.4])
    return frames


def _ground(scene: Any, model: Any, look: Framing) -> None:
    plane = mujoco.mjtGeom.mjGEOM_PLANE.value
    for geom in range(model.ngeom):
        if model.geom_type[geom] != plane or model.geom_bodyid[geom] != 0:
            continue
        drawn = model.geom(geom).name == FLOOR
        cell = rounded(0.5 * look.radius)
        scene.add_grid(
            f"/world/ground_{geom}",
            infinite_grid=True,
            cell_size=cell,
            section_size=5.0 * cell,
            fade_distance=30.0 * look.radius,
            plane_color=(225, 229, 235) if drawn else (205, 214, 205),
            plane_opacity=0.9,
            position=model.geom_pos[geom],
            wxyz=model.geom_quat[geom],
        )


def _play(server: Any, frames: dict[int, Any], poses: Poses, go_on: Callable[[Any], bool]) -> None:
    """Show picture after picture, as the page's knobs say."""
    last = len(poses.position) - 1
    seconds = last / RATE
    playing = server.gui.add_checkbox("play", True)
    slider = server.gui.add_slider("time (s)", 0.0, max(seconds, 1 / RATE), 1 / RATE, 0.0)
    follow = server.gui.add_checkbox("follow", True)
    fast = server.gui.add_dropdown("speed", SPEEDS, initial_value="1")
    at, before, shown = 0.0, time.monotonic(), (-1, True)
    while go_on(server):
        now = time.monotonic()
        # A hand on the slider has moved it from where we left it.
        if abs(slider.value - min(at, seconds)) > 1.5 / RATE:
            at = float(slider.value)
        elif playing.value and server.get_clients():
            at += (now - before) * float(fast.value)
            # It rests at the end for half a second, then begins again.
            at = at if at < seconds + 0.5 else 0.0
            slider.value = round(min(at, seconds), 4)
        before = now
        wanted = (min(last, round(at * RATE)), follow.value)
        if wanted != shown:
            with server.atomic():
                _pose(frames, poses, *wanted)
            shown = wanted
        time.sleep(1.0 / RATE)


def _pose(frames: dict[int, Any], poses: Poses, picture: int, follow: bool) -> None:
    """Put every body where it is; to follow the robot, the world goes the other way."""
    for body, frame in frames.items():
        frame.position = poses.position[picture, body]
        frame.wxyz = poses.turn[picture, body]
    if follow:
        frames[0].position = -poses.gone[picture]
