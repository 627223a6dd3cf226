"""Laws with a memory, followed along a recorded motion by compiled loops."""

from __future__ import annotations

import ctypes
import functools
from pathlib import Path
from typing import Any

import numpy as np

from morph.arrays import Array
from morph.native import library

SOURCE = Path(__file__).with_name("recorded.c")


def followed_hysteresis(place: Array, z: Array) -> Array:
    """Return the state of hysteresis along positions, in [-1, 1], shape (samples, width).

    Args:
        place: rad or m, shape (samples,).
        z: Displacements over which it builds up, shape (width,).

    Raises:
        KernelError: There is no C compiler, or it fails.
    """
    held = np.empty((len(place), len(z)))
    _code().morph_hysteresis(len(place), len(z), *_pointers(place, z, held))
    return held


def followed_backlash(
    effort: Array,
    late: Array,
    speed: Array,
    slope: Array,
    step: Array,
    *,
    motors: tuple[float, float],
    inertia: tuple[float, float],
    gap: Array,
) -> Array:
    """Return by how much play changes the force on a link, N m or N, shape (samples, width).

    Args:
        effort: What the motors produce, shape (samples,).
        late: The link's mean velocity since the sample before, same shape.
        speed: The link's velocity, same shape.
        slope: Its acceleration, same shape.
        step: Seconds to the next sample, same shape.
        motors: Their stiffness and damping.
        inertia: The rotor's, and the least that it is taken to have.
        gap: Play from one end to the other, shape (width,).

    Raises:
        KernelError: There is no C compiler, or it fails.
    """
    change = np.empty((len(effort), len(gap)))
    arrays = _pointers(effort, late, speed, slope, step)
    _code().morph_backlash(
        len(effort), len(gap), *arrays, *motors, *inertia, *_pointers(gap, change)
    )
    return change


def _pointers(*arrays: Array) -> list[Any]:
    # The arrays are passed on, so that they live as long as the call.
    packed = [np.ascontiguousarray(each, dtype=np.float64) for each in arrays]
    return [np.ctypeslib.as_ctypes(each.reshape(-1)) for each in packed]


@functools.lru_cache(maxsize=1)
def _code() -> ctypes.CDLL:
    with library.kept_folder() as folder:
        path = library.build(SOURCE, folder, name="recorded")
        code = library.load(path, fix="delete it, so that it is built again")
    at, many, number = ctypes.c_void_p, ctypes.c_int64, ctypes.c_double
    code.morph_hysteresis.restype = code.morph_backlash.restype = None
    code.morph_hysteresis.argtypes = [many, ctypes.c_int, at, at, at]
    code.morph_backlash.argtypes = [many, ctypes.c_int, *[at] * 5, *[number] * 4, at, at]
    return code
