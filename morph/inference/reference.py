"""The most likely motion of a robot given its model, and the disturbance of the model."""

from __future__ import annotations

from dataclasses import dataclass, replace

import mujoco
import numpy as np

from morph.arrays import Array, Mask
from morph.inference.filter import Disturbance, Tangent, smoothed, whitened
from morph.inference.linearise import accelerations, linearised
from morph.physics.motion import actuator_moments

FLOOR = 2e-3
"""Least scale of the missing force, as a share of the RMS force that a joint's motion needs."""
CORRELATION_TIMES = (0.05, 2.0)
"""Bounds of the missing force's correlation time, s: a stroke of a servo, the drift of a run."""
NOISE_FACTORS = (0.1, 3.0)
"""Bounds of the factor of the noise that the channels are known for."""
VIBRATIONS = (0.05, 300.0)
"""Bounds of each channel's vibration, as factors of its known noise."""
MOST_SCALE = 30.0
"""Most scale of the missing force, as a share of the RMS force that a joint's motion needs."""
MOST_SAMPLES = 1500
"""Samples of a run by which its disturbance is judged."""
INTERVAL = 0.02
"""Seconds from one derivative of the model to the next: 3 rad/s turn a link by 0.06 rad."""
ROUNDS = 3
"""Iterations of the smoother: smooth, then linearise again."""
STEPS, FEWER_STEPS = 12, 4
"""Most steps of L-BFGS to the likeliest disturbance: from anywhere, and from one nearby."""
OUTLIER = 5.0
"""Local standard deviations of the error at which a single reading is left out: its time stamp, or
a bit of it, is wrong."""
NEIGHBOURS = 20
"""Readings on either side from which that standard deviation is estimated."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SampledRun:
    """One run on a grid of equal steps."""

    step: float
    """Seconds from one sample to the next."""
    command: Array
    """Controls held from each sample to the next, shape (samples, actuators)."""
    reads: Array
    """Observation matrix: each channel by position and velocity, shape (channels, 2 dofs)."""
    reading: Array
    """Shape (samples, channels); ignored where not `valid`."""
    valid: Mask
    """Which readings there are, shape (samples, channels)."""
    noise: Array
    """Standard deviation of each channel's noise, shape (channels,)."""
    time_offset: Array | float = 0.0
    """Time of a reading less that of its sample, s, shape (samples, 1)."""
    jitter: float = 0.0
    """Standard deviation of the times at which commands change, s."""
    force: Array | float = 0.0
    """Known generalized force that the model lacks, N m or N, shape (samples, dofs)."""
    shift: Array | float = 0.0
    """Known change of readings that the model lacks, shape (samples, channels)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Reference:
    """A motion and the model linearised along it.

    It is that of a semi-implicit integrator: position[t + 1] = position[t] + step velocity[t + 1],
    so velocities are those of half a step before.
    """

    position: Array
    """rad or m, shape (samples, dofs)."""
    velocity: Array
    """Per s, same shape."""
    force: Array
    """Missing force: the smoothed state of the Ornstein-Uhlenbeck process, N m or N, same shape."""
    acceleration: Array
    """The model's acceleration less that of the motion, per s2, same shape."""
    tangent: Tangent
    """The linearised model, by the trapezoidal rule, and which readings are used."""
    disturbance: Disturbance
    """Noise and missing force under which the readings are likeliest."""
    error: Array
    """Readings less those of the motion, zero where there is none, shape (samples, channels)."""
    sensed: Array
    """Standard deviation of each channel's noise as known beforehand, shape (channels,)."""
    effort: Array
    """RMS inertial force of the motion on each degree of freedom, N m or N, shape (dofs,)."""

    def leaving(self, share: float) -> Disturbance:
        """Return the disturbance with its force scaled, to at least `FLOOR` of the effort."""
        scale = np.maximum(share * self.disturbance.scale, FLOOR * self.effort)
        return replace(self.disturbance, scale=scale)


def reference(
    model: mujoco.MjModel,
    run: SampledRun,
    guess: Array,
    *,
    before: Reference | None = None,
) -> Reference:
    """Return the smoothed motion of a run and the model linearised along it.

    The model's own smoother gives the motion, not a spline: a spline's noise would enter the
    columns of masses and correlate with the readings' errors. The disturbance is the one of
    `before`, or the likeliest without it.

    Source: Bell 1994, SIAM Journal on Optimization 4(3), 626-636 (the iterated smoother).

    Args:
        model: The model; hinges and slides only.
        run: What was commanded and read.
        guess: Positions to begin with, shape (samples, dofs).
        before: The result of a similar model, to begin with instead of `guess`. Readings that it
            left out stay out.
    """
    if before is None:
        position = np.array(guess)
        rate = np.diff(position, axis=0) / run.step
        velocity = np.concatenate([rate[:1], rate])
        found = _along(model, run, position, velocity, np.zeros_like(position), None)
    else:
        position, velocity, known = before.position, before.velocity, before.disturbance
        run = replace(run, valid=before.tangent.valid)
        found = _moved(before, model, run)
    if before is None:
        known = likeliest_disturbance(found, steps=STEPS)
    for _ in range(ROUNDS if before is None else 1):
        state = smoothed(found.tangent, known, found.error, found.acceleration)
        change, rate, force, _ = np.split(state, [n * position.shape[1] for n in (1, 2, 3)], axis=1)
        position, velocity = position + change, velocity + rate
        run = replace(run, valid=run.valid & ~outliers(found.error / run.noise, run.valid))
        found = _along(model, run, position, velocity, force, known)
    if before is not None:
        return found
    return replace(found, disturbance=likeliest_disturbance(found, steps=FEWER_STEPS))


def likeliest_disturbance(about: Reference, *, steps: int) -> Disturbance:
    """Return the scales, the correlation time and the noise under which readings are likeliest.

    A few seconds from the middle of a run stand for all of it.

    Source: Rasmussen and Williams 2006, section 5.4.1 (the marginal likelihood).

    Args:
        about: The motion; its disturbance is where the search starts.
        steps: Most steps of L-BFGS.
    """
    from scipy.optimize import minimize

    whole, about = about.disturbance, _middle(about, MOST_SAMPLES)
    first, tangent = about.disturbance, about.tangent
    dofs, channels = len(first.scale), len(about.sensed)

    def at(point: Array) -> Disturbance:
        return replace(
            first,
            scale=about.effort * np.exp(point[:dofs]),
            vibration=about.sensed * np.exp(point[dofs:-2]),
            correlation_time=float(np.exp(point[-2])),
            noise=about.sensed * np.exp(point[-1]),
        )

    def cost(point: Array) -> float:
        return -_log_likelihood(tangent, at(point), about)

    limits = [(FLOOR, MOST_SCALE)] * dofs + [VIBRATIONS] * channels
    bounds = np.log([*limits, CORRELATION_TIMES, NOISE_FACTORS])
    assert first.vibration is not None
    start = np.log(
        [
            *(first.scale / about.effort),
            *(first.vibration / about.sensed),
            first.correlation_time,
            first.noise[0] / about.sensed[0],
        ]
    )
    # Once an effect is explained less force is missing: a few steps alone would not go that far.
    of_force, of_vibration = np.arange(len(start)) < dofs, np.arange(len(start)) >= dofs
    of_vibration[-2:] = False
    shares = [np.log(share) * of_force for share in (1.0, 0.3, 0.1)]
    shares += [np.log(share) * of_vibration for share in (0.1, 10.0)]
    starts = [np.clip(start + share, *bounds.T) for share in shares]
    start = min(starts, key=cost)
    best = minimize(
        cost, start, method="L-BFGS-B", bounds=bounds, options={"maxiter": steps, "eps": 1e-3}
    )
    return replace(at(best.x), jolt=whole.jolt)


def _middle(about: Reference, samples: int) -> Reference:
    """Return the middle samples of a run."""
    first = max(0, (len(about.position) - samples) // 2)
    part, known = slice(first, first + samples), about.disturbance
    tangent = about.tangent
    return replace(
        about,
        position=about.position[part],
        velocity=about.velocity[part],
        force=about.force[part],
        acceleration=about.acceleration[part],
        error=about.error[part],
        tangent=replace(tangent, jacobian=tangent.jacobian[part], valid=tangent.valid[part]),
        disturbance=replace(known, jolt=None if known.jolt is None else known.jolt[part]),
    )


def outliers(error: Array, valid: Mask) -> Mask:
    """Return which readings are single outliers: far off while those before and after are not.

    Args:
        error: Readings less those of a smoothed motion, in units of their noise, shape (samples,
            channels).
        valid: Which readings there are, same shape.
    """
    found = np.zeros_like(valid)
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
        found[at[(off > OUTLIER * usual) & alone], channel] = True
    return found


def _log_likelihood(tangent: Tangent, disturbance: Disturbance, about: Reference) -> float:
    column = about.error[:, :, None]
    return whitened(tangent, disturbance, column, -about.acceleration[:, :, None]).likelihood()


def _along(
    model: mujoco.MjModel,
    run: SampledRun,
    position: Array,
    velocity: Array,
    force: Array,
    known: Disturbance | None,
) -> Reference:
    """Return a model linearised along a motion, with a known disturbance or a first guess of it."""
    dofs = position.shape[1]
    every = max(1, round(INTERVAL / run.step))
    local = linearised(model, position, velocity, run.command, every=every)
    mobility = local.jacobian[:, :, 2 * dofs :]
    modelled = local.acceleration + np.einsum(
        "tij,tj->ti", mobility, np.broadcast_to(run.force, position.shape)
    )
    slope = np.zeros_like(position)
    slope[:-1] = np.diff(velocity, axis=0) / run.step
    # Velocities lie half a step before positions. The trapezoidal rule for damping makes the
    # step of second order and stable: (1 - h/2 A_v) v' = v + h (a - A_v v / 2).
    damped = np.eye(dofs) - 0.5 * run.step * local.jacobian[:, :, dofs : 2 * dofs]
    jacobian = np.asarray(np.linalg.solve(damped, local.jacobian))
    acceleration = np.linalg.solve(damped, modelled[:, :, None])[:, :, 0] - slope
    # Nothing follows the last sample that its acceleration could be compared with.
    acceleration[-1] = 0.0
    inertia = np.linalg.inv(mobility)
    inertial = np.einsum("tij,tj->ti", inertia, np.gradient(velocity, run.step, axis=0))
    effort = np.sqrt(np.mean(inertial**2, axis=0)) + 1e-12
    if known is None:
        initial = np.concatenate([_initial_std(run, position), _initial_std(run, velocity)])
        known = Disturbance(
            noise=run.noise,
            scale=0.05 * effort,
            correlation_time=0.2,
            initial=initial,
            vibration=run.noise,
        )
    return Reference(
        position=position,
        velocity=velocity,
        force=force,
        acceleration=acceleration,
        tangent=Tangent(step=run.step, jacobian=jacobian, reads=run.reads, valid=run.valid),
        disturbance=replace(known, jolt=_jolt(model, run, jacobian[:, :, 2 * dofs :])),
        error=np.where(run.valid, run.reading - _predicted(run, position, velocity), 0.0),
        sensed=run.noise,
        effort=effort,
    )


def _moved(before: Reference, model: mujoco.MjModel, run: SampledRun) -> Reference:
    """Return a similar model along the motion of another, by the other's derivatives.

    A smoother that is iterated once more needs them only roughly.
    """
    position, velocity, tangent = before.position, before.velocity, before.tangent
    dofs = position.shape[1]
    acceleration = accelerations(model, position, velocity, run.command)
    # Damping by the trapezoidal rule as in `_along`: (1 - h/2 A_v)^-1 = 1 + h/2 (damped A_v).
    rate = np.einsum("tij,tj->ti", tangent.jacobian[:, :, dofs : 2 * dofs], acceleration)
    force = np.broadcast_to(run.force, position.shape)
    acceleration += 0.5 * run.step * rate
    acceleration += np.einsum("tij,tj->ti", tangent.jacobian[:, :, 2 * dofs :], force)
    acceleration[:-1] -= np.diff(velocity, axis=0) / run.step
    acceleration[-1] = 0.0
    return replace(
        before,
        acceleration=acceleration,
        error=np.where(run.valid, run.reading - _predicted(run, position, velocity), 0.0),
    )


def _predicted(run: SampledRun, position: Array, velocity: Array) -> Array:
    """Return the readings of a motion at the times they were taken, shape (samples, channels)."""
    shown = np.concatenate([position, velocity], axis=1) @ run.reads.T
    rate = np.gradient(shown, run.step, axis=0)
    offset = run.time_offset
    later = offset * (rate + 0.5 * offset * np.gradient(rate, run.step, axis=0))
    return np.asarray(shown + (run.shift + later))


def _jolt(model: mujoco.MjModel, run: SampledRun, mobility: Array) -> Array:
    """Return the standard deviation of velocity changes by commands' jitter, (samples, dofs)."""
    data = mujoco.MjData(model)
    mujoco.mj_fwdPosition(model, data)
    steps = np.abs(np.diff(run.command, axis=0, prepend=run.command[:1]))
    forces = steps @ np.abs(model.actuator_gainprm[:, :1] * actuator_moments(model, data))
    return np.asarray(run.jitter * np.einsum("tij,tj->ti", np.abs(mobility), forces))


def _initial_std(run: SampledRun, values: Array) -> Array:
    """Return how far the first values may be off: a tenth of their range, and tenfold noise."""
    deviation: Array = 0.1 * np.ptp(values, axis=0) + 10.0 * run.noise.max()
    return deviation
