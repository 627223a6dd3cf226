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


@dataclass(frozen=True, kw_only=True, eq=False)
class Tangent:
    """A robot linearised along one run, and which readings of it there are."""

    step: float
    """Seconds from one sample to the next."""
    jacobian: Array
    """[dqacc/dq, dqacc/dv, dqacc/dforce], the last M^-1 but for the integrator's damping, and
    acceleration by that of each point in contact; shape (samples, dofs, 3 dofs + contacts)."""
    reads: Array
    """Observation matrix: each channel by position and velocity, shape (channels, 2 dofs)."""
    valid: Mask
    """Which readings there are, shape (samples, channels)."""

    @property
    def mobility(self) -> Array:
        """Acceleration by each force, shape (samples, dofs, dofs)."""
        dofs = self.jacobian.shape[1]
        return self.jacobian[:, :, 2 * dofs : 3 * dofs]

    @property
    def contacts(self) -> int:
        """How many directions points in contact may move in."""
        return int(self.jacobian.shape[2]) - 3 * int(self.jacobian.shape[1])


@dataclass(frozen=True, kw_only=True, eq=False)
class Disturbance:
    """What a linearised model leaves out: noise, forces on joints and of contact, and vibration.

    Forces and vibration are Ornstein-Uhlenbeck processes, of covariance scale^2 exp(-|t - t'| /
    correlation_time). A force displaces a joint for good; vibration, of flexible links and
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
    """Changes of velocity in each step by sources of unit variance, rad/s or m/s, shape (samples,
    dofs, sources): commands change at times that are known only roughly, and impacts begin. None:
    no such change."""
    vibration: Array | None = None
    """Standard deviation of each channel's vibration, in its unit, shape (channels,). None: no such
    state."""
    vibration_time: float = 0.1
    """Correlation time of vibration, s."""
    contact: float = 0.0
    """Standard deviation of the mass-weighted acceleration of points in contact and of joints at
    their ends, sqrt(J)/s."""
    contact_time: float = 0.1
    """Correlation time of that acceleration, s."""


def smoothed(
    tangent: Tangent, disturbance: Disturbance, reading: Array, acceleration: Array | None = None
) -> tuple[Array, Array]:
    """Return the mean of position and velocity errors, forces and vibration, given all readings.

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
        The mean, shape (samples, 3 dofs + contacts + vibrating channels), and the deviation.

    Raises:
        KernelError: There is no C compiler, or it fails.
    """
    # The filter takes readings less the response to known inputs: hence the sign.
    known = None if acceleration is None else -acceleration[:, :, None]
    return FilterRun(tangent, disturbance, 1).smooth(reading, known)


@dataclass(frozen=True, kw_only=True, eq=False)
class LikelihoodScore:
    """A log likelihood, and its derivatives by the logarithms of what a disturbance consists of."""

    log_likelihood: float
    """Log likelihood of the readings, nats."""
    scale: Array
    """By the force's scale, shape (dofs,)."""
    vibration: Array
    """By each channel's vibration, shape (channels,); empty where none vibrates."""
    contact: float
    """By the acceleration of points in contact."""
    noise: float
    """By the noise of all channels together."""


def scored(
    tangent: Tangent, disturbance: Disturbance, reading: Array, acceleration: Array
) -> LikelihoodScore:
    """Return the log likelihood of readings and its derivatives, by one filter and smoother.

    Source: Koopman and Shephard 1992, Biometrika 79(4), 823-826.

    Args:
        tangent: The linearised robot.
        disturbance: What moves it beside the model, and the noise.
        reading: Readings less those of the motion, shape (samples, channels).
        acceleration: The model's acceleration less that of this motion, shape (samples, dofs).

    Raises:
        KernelError: There is no C compiler, or it fails.
    """
    return FilterRun(tangent, disturbance, 1).scored(reading, -acceleration[:, :, None])


class FilterRun:
    """A filter that goes through one run in stretches, and its state between two of them."""

    def __init__(self, tangent: Tangent, disturbance: Disturbance, columns: int) -> None:
        self.tangent = tangent
        self._dofs = dofs = tangent.jacobian.shape[1]
        contacts = tangent.contacts
        self._jolt = disturbance.jolt
        channels = len(tangent.reads)
        vibration = np.zeros(0) if disturbance.vibration is None else disturbance.vibration
        self._vibrating = len(vibration)
        self._noise = _packed(disturbance.noise**2)
        self._forces = dofs + contacts
        lasting = [
            *[disturbance.correlation_time] * dofs,
            *[disturbance.contact_time] * contacts,
            *[disturbance.vibration_time] * self._vibrating,
        ]
        scale = np.concatenate([disturbance.scale, [disturbance.contact] * contacts, vibration])
        self._keep = np.exp(-tangent.step / np.array(lasting))
        self._added = _packed(scale**2 * (1.0 - self._keep**2))
        shown = np.eye(channels)[:, : self._vibrating]
        zeros = np.zeros((channels, self._forces))
        self._reads = _packed(np.concatenate([tangent.reads, zeros, shown], axis=1))
        self._spread = np.concatenate([disturbance.initial, scale])
        self._delta = np.zeros((len(self._spread), columns))
        self._covariance = np.diag(self._spread**2)

    def filter(
        self,
        part: slice,
        readings: Array,
        accelerations: Array | None,
        kept: tuple[Array | None, ...] = (None,) * 4,
    ) -> tuple[Array, float]:
        """Return whitened innovations of some samples and the log determinant of their covariance.

        Args:
            part: The samples; each call goes on where the one before ended.
            readings: Of these samples, shape (samples, channels, columns).
            accelerations: Shape (samples, dofs, columns).
            kept: Arrays that receive what `smooth` needs.
        """
        jacobian, valid = self.tangent.jacobian[part], self.tangent.valid[part]
        samples, dofs, _ = jacobian.shape
        channels, columns = readings.shape[1:]
        white = np.empty((samples, channels, columns))
        log_determinant: float = _code().morph_filter(
            dofs, channels, self._forces, self._vibrating,
            0 if self._jolt is None else self._jolt.shape[2], columns, samples, self.tangent.step,
            *map(_pointer, (
                self._keep, _packed(jacobian),
                None if accelerations is None else _packed(accelerations),
                self._reads, np.ascontiguousarray(valid, dtype=np.uint8), _packed(readings),
                self._noise, self._added, None if self._jolt is None else _packed(self._jolt[part]),
                self._delta, self._covariance, white,
                *kept,
            )),
        )  # fmt: skip
        return white, log_determinant

    def moved(self) -> tuple[Array, Array]:
        """Return the mean of the state at the next sample, and its variance, shape (states,).

        The mean is zero after that: the filter goes on about the motion that it has changed.
        """
        mean = -self._delta[:, 0]
        self._delta[:] = 0.0
        return mean, np.diag(self._covariance).copy()

    def smooth(self, reading: Array, acceleration: Array | None) -> tuple[Array, Array]:
        """Return the smoothed state, (samples, states), and the velocities' std, (samples, dofs).

        Args:
            reading: Readings less those of the motion, shape (samples, channels).
            acceleration: The motion's acceleration less the model's, per s2, shape (samples, dofs,
                1); None for zero.
        """
        (samples, channels), size = reading.shape, len(self._delta)
        states = np.empty((samples, size, size)), np.empty((samples, size))
        gains = np.empty((samples, channels, size)), np.empty((samples, channels))
        white, _ = self.filter(slice(None), reading[:, :, None], acceleration, (*states, *gains))
        state, variance = np.empty((samples, size)), np.empty((samples, self._dofs))
        self._backwards(white, (*states, *gains), (state, variance))
        return state, np.sqrt(np.maximum(variance, 0.0))

    def scored(self, reading: Array, acceleration: Array) -> LikelihoodScore:
        """Return the log likelihood and its derivatives."""
        (samples, channels), size, dofs = reading.shape, len(self._delta), self._dofs
        kept = None, None, np.empty((samples, channels, size)), np.empty((samples, channels))
        white, logarithm = self.filter(slice(None), reading[:, :, None], acceleration, kept)
        step, initial, readings = np.split(
            0.5 * self._backwards(white, kept, (None, None)), [size, 2 * size]
        )
        # The derivative of a variance by the logarithm of its root is twice the variance.
        square = float(np.sum(white**2))
        constant = int(self.tangent.valid.sum()) * math.log(2.0 * math.pi)
        by_scale = 2.0 * self._added * step[2 * dofs :]
        by_scale += 2.0 * self._spread[2 * dofs :] ** 2 * initial[2 * dofs :]
        return LikelihoodScore(
            log_likelihood=-0.5 * (square + logarithm + constant),
            scale=by_scale[:dofs],
            vibration=by_scale[self._forces :],
            contact=float(by_scale[dofs : self._forces].sum()),
            noise=float(2.0 * self._noise @ readings),
        )

    def _backwards(
        self,
        white: Array,
        kept: tuple[Array | None, ...],
        smoothed: tuple[Array | None, Array | None],
    ) -> Array:
        """Return twice the derivatives of the log likelihood by variances, and fill the smoothed.

        They are of what each step adds to a state, of the initial state and of readings.
        """
        tangent, size, channels = self.tangent, len(self._delta), white.shape[1]
        score = np.empty(2 * size + channels)
        _code().morph_smooth(
            self._dofs, channels, self._forces, self._vibrating, len(white), tangent.step,
            *map(_pointer, (
                self._keep, _packed(tangent.jacobian), self._reads,
                np.ascontiguousarray(tangent.valid, dtype=np.uint8), white, *kept, *smoothed,
                score, np.zeros((size, size)),
            )),
        )  # fmt: skip
        return score


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
    code.morph_filter.argtypes = [*[count] * 6, ctypes.c_int64, number, *[at] * 16]
    code.morph_smooth.restype = None
    code.morph_smooth.argtypes = [*[count] * 4, ctypes.c_int64, number, *[at] * 13]
    return code
