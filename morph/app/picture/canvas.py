"""Where pictures are drawn: an offscreen buffer of MuJoCo's renderer."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from morph.errors import OutputError

Picture = NDArray[np.uint8]
"""Red, green and blue, shape (height, width, 3)."""

MORE_GEOMS = 2000
"""Room for what is drawn beside the model's own geoms."""


class Canvas:
    """A buffer to draw one model on, again and again."""

    def __init__(self, model: Any, size: tuple[int, int]) -> None:
        """Take up the model's meshes and textures; a GL context must be current."""
        self.model, self.data = model, mujoco.MjData(model)
        self.camera, self.options = mujoco.MjvCamera(), mujoco.MjvOption()
        self.scene = mujoco.MjvScene(model, maxgeom=model.ngeom + MORE_GEOMS)
        self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_150.value)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, self._context)
        self._rectangle = mujoco.MjrRect(0, 0, *size)
        self._picture = np.empty((size[1], size[0], 3), dtype=np.uint8)

    def place(self, position: Any) -> None:
        """Put the model where `qpos` says and update the scene for the camera."""
        self.data.qpos[:] = position
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        mujoco.mj_camlight(self.model, self.data)
        mujoco.mj_tendon(self.model, self.data)
        mujoco.mjv_updateScene(
            self.model,
            self.data,
            self.options,
            None,
            self.camera,
            mujoco.mjtCatBit.mjCAT_ALL.value,
            self.scene,
        )

    def draw(self) -> Picture:
        """Return the scene's picture; the next one is written over it."""
        mujoco.mjr_render(self._rectangle, self.scene, self._context)
        mujoco.mjr_readPixels(self._picture, None, self._rectangle, self._context)
        return self._picture[::-1]

    def close(self) -> None:
        """Give the buffer back."""
        self._context.free()


@contextmanager
def canvas(model: Any, size: tuple[int, int]) -> Iterator[Canvas]:
    """Lend a canvas that is gone afterwards.

    Raises:
        OutputError: This machine has no OpenGL that draws without a window.
    """
    context, drawn = _first_that_draws(model, size)
    try:
        yield drawn
    finally:
        drawn.close()
        context.free()


def _first_that_draws(model: Any, size: tuple[int, int]) -> tuple[Any, Canvas]:
    """Return an OpenGL context and its canvas: what MUJOCO_GL names, or the first that works."""
    tried = []
    for name in _backends():
        context = None
        try:
            with warnings.catch_warnings():
                # glfw warns of a missing screen, and goes on without.
                warnings.simplefilter("ignore")
                context = import_module(f"mujoco.{name}").GLContext(*size)
                context.make_current()
                return context, Canvas(model, size)
        # Each backend fails in its own way where its library or its device is missing.
        except Exception as error:
            tried.append(f"{name}: {' '.join(str(error).split()) or type(error).__name__}")
            if context is not None:
                context.free()
    raise OutputError(
        f"there is no OpenGL to draw with ({'; '.join(tried)})",
        where="--video",
        fix="install one that needs no screen (on Debian or Ubuntu: libegl1 and "
        "libgl1-mesa-dri), name one by MUJOCO_GL=egl, osmesa or glfw, or leave out --video",
    )


def _backends() -> tuple[str, ...]:
    named = os.environ.get("MUJOCO_GL", "").lower().strip()
    if named in {"egl", "osmesa", "glfw", "cgl"}:
        return (named,)
    if sys.platform == "darwin":
        return ("cgl", "glfw")
    if sys.platform == "win32":
        return ("glfw",)
    # A window's library would only complain where there is no screen.
    seen = ("glfw",) if os.environ.get("DISPLAY") else ()
    return ("egl", *seen, "osmesa")
