"""Kalman filter and smoother of a robot linearised along a motion, with a missing force."""

from __future__ import annotations

import ctypes
import functools
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from morph.arrays import Array, Mask
from morph.native import library

SOURCE = Path(__file__).with_name("filter.c")
CHUNK = 2**22
"""Whitened numbers held at once: 32 MiB of doubles."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Tangent:
    """A robot linearised along one run, and which readings of it there are."""

    step: float
    """Seconds from one sample to the next."""
    jacobian: Array
    """[dqacc/dq, dqacc/dv, dqacc/dforce], the last M^-1 but for the integrator's damping, shape
    (samples, dofs, 3 dofs)."""
    reads: Array
    """Observation matrix: each channel by position and velocity, shape (channels, 2 dofs)."""
    valid: Mask
    """Which readings there are, shape (samples, channels)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Disturbance:
    """What a linearised model leaves out: noise, a force on each joint, vibration of readings.

    Force and vibration are Ornstein-Uhlenbeck processes, of covariance scale^2 exp(-|t - t'| /
    correlation_time). The force displaces a joint for good; vibration, of flexible links and
    drives, stays a small displacement of what is read.
    Source: Rasmussen and Williams 2006, Gaussian processes for machine learning, eq. B.27.
    """

    noise: Array
    """Standard deviation of each channel's noise, in its unit, shape (channels,)."""
    scale: Array
    """Standard deviation of the force on each degree of freedom, N m or N, shape (dofs,)."""
    correlation_time: float
    """Of that force, s."""
    initial: Array
    """Standard deviation of position and velocity errors at the first sample, shape (2 dofs,)."""
    jolt: Array | None = None
    """Standard deviation of a change of velocity in each step, rad/s or m/s, shape (samples, dofs):
    commands change at times that are known only roughly. None: no such change."""
    vibration: Array | None = None
    """Standard deviation of each channel's vibration, in its unit, shape (channels,). None: no such
    state."""
    vibration_time: float = 0.1
    """Correlation time of vibration, s."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Whitened:
    """Inner products of columns, whitened by a filter's innovations, over all readings."""

    gram: Array
    """The Gram matrix D' S^-1 D of columns D, S the covariance of readings, shape (columns,
    columns)."""
    logarithm: float
    """Log determinant of S."""
    readings: int
    """How many readings there are."""

    def __add__(self, other: Whitened) -> Whitened:
        """Return the sums over two independent runs."""
        return Whitened(
            gram=self.gram + other.gram,
            logarithm=self.logarithm + other.logarithm,
            readings=self.readings + other.readings,
        )

    def likelihood(self, column: int = 0) -> float:
        """Return the log likelihood of the readings that one column holds, normalised."""
        square = float(self.gram[column, column])
        return -0.5 * (square + self.logarithm + self.readings * math.log(2.0 * math.pi))


def whitened(
    tangent: Tangent, disturbance: Disturbance, readings: Array, accelerations: Array | None = None
) -> Whitened:
    """Return the Gram matrix of columns in the metric of the readings, by one Kalman filter.

    A column changes readings directly, and through accelerations that move the state. With S the
    covariance of all readings under the disturbance and D their changes, the matrix is D' S^-1 D.

    Source: Simon 2006, Optimal State Estimation, sections 6.1 and 10.2.

    Args:
        tangent: The linearised robot.
        disturbance: What else moves it, and the noise.
        readings: Direct change of each reading, shape (samples, channels, columns).
        accelerations: Acceleration by each column, per s2, shape (samples, dofs, columns); by
            default none.

    Raises:
        KernelError: There is no C compiler, or it fails.
    """
    (whole,) = whitened_blocks(tangent, disturbance, readings, accelerations, blocks=1)
    return whole


def whitened_blocks(
    tangent: Tangent,
    disturbance: Disturbance,
    readings: Array,
    accelerations: Array | None = None,
    *,
    blocks: int,
) -> list[Whitened]:
    """Return the Gram matrices of stretches of equal length, each given all readings before it.

    Their sum is that of the run. See `whitened`, also for what is raised.

    Args:
        tangent: The linearised robot.
        disturbance: What else moves it, and the noise.
        readings: Direct change of each reading, shape (samples, channels, columns).
        accelerations: Acceleration by each column, per s2, shape (samples, dofs, columns).
        blocks: How many stretches there are.
    """
    samples = len(tangent.jacobian)
    channels, columns = tangent.reads.shape[0], readings.shape[2]
    run = _Run(tangent, disturbance, columns)
    length = max(1, CHUNK // (channels * columns))
    found = []
    for block in range(blocks):
        gram, logarithm = np.zeros((columns, columns)), 0.0
        first, last = block * samples // blocks, (block + 1) * samples // blocks
        for begin in range(first, last, length):
            part = slice(begin, min(begin + length, last))
            moved = None if accelerations is None else accelerations[part]
            white, log_determinant = run.filter(part, readings[part], moved)
            rows = white[tangent.valid[part]]
            gram += rows.T @ rows
            logarithm += log_determinant
        count = int(tangent.valid[first:last].sum())
        found.append(Whitened(gram=gram, logarithm=logarithm, readings=count))
    return found


def smoothed(
    tangent: Tangent, disturbance: Disturbance, reading: Array, acceleration: Array | None = None
) -> tuple[Array, Array]:
    """Return the mean of position and velocity errors, force and vibration, given all readings.

    With it the standard deviation of velocities, per s, shape (samples, dofs).

    Source: Bierman 1973, Automatica 9(5), 503-511 (the modified Bryson-Frazier smoother).

    Args:
        tangent: The linearised robot.
        disturbance: What moves it beside the model, and the noise.
        reading: Readings less those of the motion that it was linearised along, shape
            (samples, channels).
        acceleration: The model's acceleration less that of this motion, per s2, shape
            (samples, dofs); by default zero, as for a motion that the model simulated.

    Returns:
        The mean, shape (samples, 3 dofs + vibrating channels), and the standard deviation.

    Raises:
        KernelError: There is no C compiler, or it fails.
    """
    # The filter takes readings less the response to known inputs: hence the sign.
    known = None if acceleration is None else -acceleration[:, :, None]
    return _Run(tangent, disturbance, 1).smooth(reading, known)


class _Run:
    """A filter that goes through one run in stretches, and its state between two of them."""

    def __init__(self, tangent: Tangent, disturbance: Disturbance, columns: int) -> None:
        self._tangent = tangent
        dofs = tangent.jacobian.shape[1]
        self._keep = float(np.exp(-tangent.step / disturbance.correlation_time))
        self._jolt = None if disturbance.jolt is None else disturbance.jolt**2
        self._fade = float(np.exp(-tangent.step / disturbance.vibration_time))
        channels = len(tangent.reads)
        vibration = np.zeros(0) if disturbance.vibration is None else disturbance.vibration
        self._vibrating = len(vibration)
        self._noise = _packed(disturbance.noise**2)
        added = disturbance.scale**2 * (1.0 - self._keep**2)
        self._added = _packed(np.append(added, vibration**2 * (1.0 - self._fade**2)))
        shown = np.eye(channels)[:, : self._vibrating]
        zeros = np.zeros((channels, dofs))
        self._reads = _packed(np.concatenate([tangent.reads, zeros, shown], axis=1))
        spread = np.concatenate([disturbance.initial, disturbance.scale, vibration])
        self._delta = np.zeros((len(spread), columns))
        self._covariance = np.diag(spread**2)
        self._work = np.empty(dofs * max(columns, len(spread)))

    def filter(
        self,
        part: slice,
        readings: Array,
        accelerations: Array | None,
        kept: tuple[Array, Array, Array, Array] | None = None,
    ) -> tuple[Array, float]:
        """Return whitened innovations of some samples and the log determinant of their covariance.

        Args:
            part: The samples; each call goes on where the one before ended.
            readings: Of these samples, shape (samples, channels, columns).
            accelerations: Shape (samples, dofs, columns).
            kept: Arrays that receive what `smooth` needs.
        """
        jacobian, valid = self._tangent.jacobian[part], self._tangent.valid[part]
        samples, dofs, _ = jacobian.shape
        channels, columns = readings.shape[1:]
        white = np.empty((samples, channels, columns))
        log_determinant: float = _code().morph_filter(
            dofs, channels, self._vibrating, columns, samples,
            self._tangent.step, self._keep, self._fade,
            *map(_pointer, (
                _packed(jacobian), None if accelerations is None else _packed(accelerations),
                self._reads, np.ascontiguousarray(valid, dtype=np.uint8), _packed(readings),
                self._noise, self._added, None if self._jolt is None else _packed(self._jolt[part]),
                self._delta, self._covariance, white,
                *(kept or (None,) * 4), self._work,
            )),
        )  # fmt: skip
        return white, log_determinant

    def smooth(self, reading: Array, acceleration: Array | None) -> tuple[Array, Array]:
        """Return the smoothed state and the standard deviation of its velocities."""
        samples, channels = reading.shape
        size = self._delta.shape[0]
        kept = (
            np.empty((samples, size, size)),
            np.empty((samples, size)),
            np.empty((samples, channels, size)),
            np.empty((samples, channels)),
        )
        white, _ = self.filter(slice(None), reading[:, :, None], acceleration, kept)
        tangent = self._tangent
        state, variance = np.empty((samples, size)), np.empty((samples, tangent.jacobian.shape[1]))
        _code().morph_smooth(
            tangent.jacobian.shape[1], channels, self._vibrating, samples,
            tangent.step, self._keep, self._fade,
            *map(_pointer, (
                _packed(tangent.jacobian), self._reads,
                np.ascontiguousarray(tangent.valid, dtype=np.uint8), white, *kept, state, variance,
                np.zeros((size, size)),
            )),
        )  # fmt: skip
        return state, np.sqrt(np.maximum(variance, 0.0))


def _packed(values: Array) -> Array:
    return np.ascontiguousarray(values, dtype=np.float64)


def _pointer(values: Any) -> Any:
    # The array is passed on, so that it lives as long as the call.
    return None if values is None else np.ctypeslib.as_ctypes(values.reshape(-1))


@functools.lru_cache(maxsize=1)
def _code() -> ctypes.CDLL:
    """Return the compiled filter.

    Raises:
        KernelError: There is no C compiler, or it fails.
    """
    with library.kept_folder() as folder:
        path = library.build(SOURCE, folder, name="filter")
        code = library.load(path, fix="delete it, so that it is built again")
    number, count, at = ctypes.c_double, ctypes.c_int, ctypes.c_void_p
    code.morph_filter.restype = number
    code.morph_filter.argtypes = [count] * 4 + [ctypes.c_int64] + [number] * 3 + [at] * 16
    code.morph_smooth.restype = None
    code.morph_smooth.argtypes = [count] * 3 + [ctypes.c_int64] + [number] * 3 + [at] * 11
    return code
