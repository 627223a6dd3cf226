"""One run on a grid of equal steps, and the motion that a model makes of it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array, Integers, Mask
from morph.inference.axes import Axes, along_parent
from morph.inference.contact import Contact
from morph.inference.filter import Disturbance, Tangent
from morph.model.measurement import Measurement

FLOOR = 5e-4
"""Least scale of the missing force, as a share of the RMS force that a joint's motion needs."""
OUTLIER = 5.0
"""Local standard deviations of the error at which a single reading is left out: its time stamp, or
a bit of it, is wrong."""
NEIGHBOURS = 20
"""Readings on either side from which that standard deviation is estimated."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SampledRun:
    """One run on a grid of equal steps."""

    measurement: Measurement
    """What its first channels read; a channel for each of `rates` follows."""
    rates: Integers
    """Degrees of freedom whose velocity a sensor reads, shape (sensors,)."""
    step: float
    """Seconds from one sample to the next."""
    command: Array
    """Controls held from each sample to the next, shape (samples, actuators)."""
    reading: Array
    """Shape (samples, channels); ignored where not `valid`."""
    attitude: Array
    """Measured orientations, shape (samples, balls, 4)."""
    valid: Mask
    """Which readings there are, shape (samples, channels)."""
    placed: Array
    """Positions as read, interpolated linearly, shape (samples, nq)."""
    noise: Array
    """Standard deviation of each channel's noise, shape (channels,)."""
    guess: Array
    """Standard deviation of where joints that were not read begin, rad or m, else 0, (dofs,)."""
    time_offset: Array | float = 0.0
    """Time of a reading less that of its sample, s, shape (samples, channels)."""
    unsure: Array | None = None
    """Standard deviation of each control's integral over a step, its unit times s, shape (samples,
    actuators). None: commands are known."""
    force: Array | float = 0.0
    """Known generalized force that the model lacks, N m or N, shape (samples, dofs)."""
    slope: Array | float = 0.0
    """How that force changes with its own joint's position and velocity, (samples, 2, dofs)."""
    sticking: Array | float = 0.0
    """Damping by dry friction near rest, N m s/rad or N s/m, shape (samples, dofs)."""
    shift: Array | float = 0.0
    """Known change of readings that the model lacks, shape (samples, channels)."""
    shift_slope: Array | float = 0.0
    """How that change grows with positions and velocities, shape (channels, 2 dofs)."""

    @property
    def reads(self) -> Array:
        """Observation matrix: each channel by position and velocity, shape (channels, 2 dofs)."""
        dofs = self.measurement.coordinates.dofs
        return np.eye(2 * dofs)[[*range(dofs), *(dofs + self.rates)]] + self.shift_slope


@dataclass(frozen=True, kw_only=True, eq=False)
class Reference:
    """A motion and the model linearised along it.

    It is that of a semi-implicit integrator: position[t + 1] = position[t] + step velocity[t + 1],
    so velocities are those of half a step before. Orientations add up as rotations do. Where they
    err the error is a rotation along the axes of the parent, not those of the body as in `qvel`:
    along these its rate is the velocity's error alone. `acceleration` and `tangent` are along them.
    """

    position: Array
    """`qpos`, rad or m, shape (samples, nq)."""
    velocity: Array
    """`qvel`, per s, shape (samples, dofs)."""
    spread: Array
    """Standard deviation of that velocity, given the readings, same shape."""
    force: Array
    """Missing force: the smoothed state of the Ornstein-Uhlenbeck process, N m or N, same shape."""
    acceleration: Array
    """The model's acceleration less that of the motion, per s2, same shape. Points in contact are
    not accelerated by the model."""
    free: Array
    """The same along the axes of the body, and none that moves points in contact: these are
    accelerated as the motion shows."""
    sticking: Array
    """Damping by dry friction that `tangent` includes, N m s/rad or N s/m, same shape."""
    axes: tuple[Array, ...]
    """The body's axes as columns, by the parent's, of each orientation, shape (samples, 3, 3)."""
    local: Array
    """[dqacc/dq, dqacc/dv, M^-1] of the model alone, shape (samples, dofs, 3 dofs)."""
    tangent: Tangent
    """The linearised model, by the trapezoidal rule, and which readings are used."""
    contact: Contact
    """What forces of contact may change along it."""
    disturbance: Disturbance
    """Noise and missing force under which the readings are likeliest."""
    error: Array
    """Readings less those of the motion, zero where there is none, shape (samples, channels)."""
    sensed: Array
    """Standard deviation of each channel's noise as known beforehand, shape (channels,)."""
    unread: Mask
    """Joints that no sensor read and that follow none, shape (dofs,)."""
    inertial: Array
    """RMS inertial force of the motion on each degree of freedom, N m or N, shape (dofs,)."""

    @property
    def mobility(self) -> Array:
        """Acceleration by each force without the damping of a step, (samples, dofs, dofs)."""
        return self.local[:, :, 2 * self.velocity.shape[1] :]

    def leaving(self, share: float) -> Disturbance:
        """Return the disturbance with its force scaled, at least `FLOOR` of the inertial one."""
        scale = np.maximum(share * self.disturbance.scale, FLOOR * self.inertial)
        return replace(self.disturbance, scale=scale)


def later(sticking: Array) -> Array:
    """Return the share of the new velocity in each step's damping, shape (samples, 1, 1).

    It is one half, the trapezoidal rule; where a joint sticks damping is stiff, and the step is
    Euler's backward one.

    Args:
        sticking: Damping by dry friction, shape (samples, dofs).
    """
    return np.where(np.any(sticking > 0.0, axis=1), 1.0, 0.5)[:, None, None]


def predicted(run: SampledRun, position: Array, velocity: Array, axes: Axes) -> Array:
    """Return the readings of a motion at the times they were taken, shape (samples, channels)."""
    space = run.measurement.coordinates
    shown = run.measurement.read(position, run.attitude)
    rate = np.gradient(shown, run.step, axis=0)
    for _, dof in space.balls:
        # What is read of an orientation is the difference from one reading, not from the last.
        part = slice(dof, dof + 3)
        rate[:, part] = along_parent(space, axes, velocity)[:, part]
    bend = np.gradient(rate, run.step, axis=0)
    if len(run.rates):
        # Velocities are those of half a step before.
        gained = np.gradient(velocity[:, run.rates], run.step, axis=0)
        now = velocity[:, run.rates] + 0.5 * run.step * gained
        parts = (shown, now), (rate, gained), (bend, np.zeros_like(now))
        shown, rate, bend = (np.concatenate(part, axis=1) for part in parts)
    offset = run.time_offset
    return np.asarray(shown + (run.shift + offset * (rate + 0.5 * offset * bend)))


def outliers(error: Array, valid: Mask) -> Mask:
    """Return which readings are single outliers: far off while those before and after are not.

    Args:
        error: Readings less those of a smoothed motion, in units of their noise, shape (samples,
            channels).
        valid: Which readings there are, same shape.
    """
    result = np.zeros_like(valid)
    for channel in range(error.shape[1]):
        at = np.flatnonzero(valid[:, channel])
        off = np.abs(error[at, channel])
        if len(off) <= 2 * NEIGHBOURS:
            continue
        around = np.lib.stride_tricks.sliding_window_view(
            np.pad(off, NEIGHBOURS, mode="reflect"), 2 * NEIGHBOURS + 1
        )
        # Of a normal distribution the median is 0.6745 standard deviations.
        usual = np.maximum(np.median(around, axis=1) / 0.6745, 1.0)
        padded = np.pad(off, 1)
        alone = np.maximum(padded[:-2], padded[2:]) < 0.5 * off
        result[at[(off > OUTLIER * usual) & alone], channel] = True
    return result
