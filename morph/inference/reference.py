"""The motion that a robot most likely made, given its model, and what disturbs the model."""

from __future__ import annotations

from dataclasses import dataclass, replace

import mujoco
import numpy as np

from morph.arrays import Array, Mask
from morph.inference.filter import Disturbance, Tangent, smoothed, whitened
from morph.inference.linearise import linearised
from morph.physics.motion import actuator_moments

FLOOR = 2e-3
"""Least share of a joint's RMS force that a model is taken to leave out."""
TIMES = (0.02, 2.0)
"""Correlation times that are tried, s: from a stroke of a servo to the drift of a run."""
ROUNDS = 3
"""How often a motion is smoothed and linearised again."""
STEPS, FEWER_STEPS = 12, 4
"""Most steps to the likeliest disturbance, and from one that was likeliest nearby."""
STRAY = 5.0
"""Standard deviations from its neighbours at which a single reading is left out: its time stamp is
wrong, or a bit of it."""
BESIDE = 20
"""Readings on either side that tell how far readings are off around one."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SampledRun:
    """One run on a grid of equal steps."""

    step: float
    """s."""
    command: Array
    """Controls from each sample to the next, shape (samples, actuators)."""
    reads: Array
    """Each channel by position and velocity, shape (channels, 2 dofs)."""
    reading: Array
    """Shape (samples, channels); anything where `valid` is not."""
    valid: Mask
    """Which readings there are, shape (samples, channels)."""
    noise: Array
    """Standard deviation of each channel's noise, shape (channels,)."""
    late: Array | float = 0.0
    """By how much a reading was taken after its sample, s, shape (samples, 1)."""
    clock: float = 0.0
    """Standard deviation of the times at which commands change, s."""
    force: Array | float = 0.0
    """Generalized force beside the model's, shape (samples, dofs)."""
    shift: Array | float = 0.0
    """What channels read beside the state, shape (samples, channels)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Reference:
    """A motion and the model along it: position' = position + step velocity'."""

    position: Array
    """Shape (samples, dofs)."""
    velocity: Array
    """Same shape."""
    force: Array
    """Generalized force that the model leaves out, same shape."""
    acceleration: Array
    """By which the model's acceleration is above that of the motion, same shape."""
    tangent: Tangent
    """The model linearised along it."""
    disturbance: Disturbance
    """What the model leaves out, by evidence."""
    error: Array
    """Readings less those of the motion, shape (samples, channels)."""
    sensed: Array
    """Standard deviation of noise that each channel is known for, shape (channels,)."""
    effort: Array
    """RMS force on each degree of freedom that the motion needs, shape (dofs,)."""

    def leaving(self, share: float) -> Disturbance:
        """Return the disturbance with a share of its force, yet no less than models err by."""
        scale = np.maximum(share * self.disturbance.scale, FLOOR * self.effort)
        return replace(self.disturbance, scale=scale)


def reference(
    model: mujoco.MjModel,
    run: SampledRun,
    guess: Array,
    *,
    before: Reference | None = None,
    settle: bool = True,
) -> Reference:
    """Return the motion along which a model is linearised: its own smoother's, not a spline's.

    Noise of a spline would enter the columns of masses and correlate with the readings' errors.
    Source: Bell 1994, SIAM Journal on Optimization 4(3), 626-636 (the iterated smoother).

    Args:
        model: The model; hinges and slides only.
        run: What was commanded and read.
        guess: Positions to begin with, shape (samples, dofs).
        before: What was found with a model that differed a little, to begin with instead.
        settle: Whether the disturbance is the likeliest of the motion, not that of the last.
    """
    if before is None:
        position = np.array(guess)
        velocity = np.gradient(position, run.step, axis=0)
        velocity[1:] = np.diff(position, axis=0) / run.step
        found = _along(model, run, position, velocity, np.zeros_like(position), None)
    else:
        position, velocity, known = before.position, before.velocity, before.disturbance
        run = replace(run, valid=before.tangent.valid)
        found = _along(model, run, position, velocity, before.force, known)
    if before is None:
        known = likeliest(found, steps=STEPS)
    for _ in range(ROUNDS if before is None else 1):
        state = smoothed(found.tangent, known, found.error, found.acceleration)
        change, rate, force = np.split(state, 3, axis=1)
        position, velocity = position + change, velocity + rate
        run = replace(run, valid=run.valid & ~strays(found.error / run.noise, run.valid))
        found = _along(model, run, position, velocity, force, known)
    return replace(found, disturbance=likeliest(found, steps=FEWER_STEPS)) if settle else found


def likeliest(about: Reference, *, steps: int = STEPS) -> Disturbance:
    """Return the scales, the correlation time and the noise under which readings are likeliest.

    Source: Rasmussen and Williams 2006, section 5.4.1 (the marginal likelihood).

    Args:
        about: The motion; its disturbance is where the search starts.
        steps: Most steps of L-BFGS.
    """
    from scipy.optimize import minimize

    first, tangent = about.disturbance, about.tangent
    dofs = len(first.scale)

    def at(point: Array) -> Disturbance:
        return replace(
            first,
            scale=about.effort * np.exp(point[:dofs]),
            time=float(np.exp(point[dofs])),
            noise=about.sensed * np.exp(point[dofs + 1]),
        )

    def cost(point: Array) -> float:
        return -_evidence(tangent, at(point), about)

    bounds = [(np.log(FLOOR), np.log(30.0))] * dofs
    bounds += [tuple(np.log(TIMES)), (np.log(0.3), np.log(3.0))]
    noisier = np.log(first.noise[0] / about.sensed[0])
    start = np.array([*np.log(first.scale / about.effort), np.log(first.time), noisier])
    # What was explained since leaves less force: a few steps alone would not go that far.
    shares = [np.log(share) * (np.arange(dofs + 2) < dofs) for share in (1.0, 0.3, 0.1)]
    starts = [np.clip(start + share, *np.transpose(bounds)) for share in shares]
    start = min(starts, key=cost)
    best = minimize(
        cost, start, method="L-BFGS-B", bounds=bounds, options={"maxiter": steps, "eps": 1e-3}
    )
    return at(best.x)


def strays(error: Array, valid: Mask) -> Mask:
    """Return which readings are far off while those before and after are not.

    Args:
        error: Readings less those of a smoothed motion, in units of their noise, shape (samples,
            channels).
        valid: Which readings there are, same shape.
    """
    found = np.zeros_like(valid)
    for channel in range(error.shape[1]):
        at = np.flatnonzero(valid[:, channel])
        off = np.abs(error[at, channel])
        if len(off) <= 2 * BESIDE:
            continue
        around = np.lib.stride_tricks.sliding_window_view(
            np.pad(off, BESIDE, mode="reflect"), 2 * BESIDE + 1
        )
        # Of a normal distribution the median is 0.6745 standard deviations.
        usual = np.maximum(np.median(around, axis=1) / 0.6745, 1.0)
        padded = np.pad(off, 1)
        alone = np.maximum(padded[:-2], padded[2:]) < 0.5 * off
        found[at[(off > STRAY * usual) & alone], channel] = True
    return found


def _evidence(tangent: Tangent, disturbance: Disturbance, about: Reference) -> float:
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
    """Linearise a model along a motion; what disturbs it is yet to be found."""
    dofs = position.shape[1]
    local = linearised(model, position, velocity, run.command)
    mobility = local.jacobian[:, :, 2 * dofs :]
    modelled = local.acceleration + np.einsum(
        "tij,tj->ti", mobility, np.broadcast_to(run.force, position.shape)
    )
    slope = np.zeros_like(position)
    slope[:-1] = np.diff(velocity, axis=0) / run.step
    # Velocities lie half a step before positions. By the trapezoidal rule of what damps them a
    # step is of second order and stable: (1 - h/2 A_v) v' = v + h (a - A_v v / 2).
    damped = np.eye(dofs) - 0.5 * run.step * local.jacobian[:, :, dofs : 2 * dofs]
    jacobian = np.asarray(np.linalg.solve(damped, local.jacobian))
    acceleration = np.linalg.solve(damped, modelled[:, :, None])[:, :, 0] - slope
    acceleration[-1] = 0.0
    tangent = Tangent(step=run.step, jacobian=jacobian, reads=run.reads, valid=run.valid)
    shown = np.concatenate([position, velocity], axis=1) @ run.reads.T
    rate = np.gradient(shown, run.step, axis=0)
    shown += run.shift + run.late * (rate + 0.5 * run.late * np.gradient(rate, run.step, axis=0))
    inertia = np.linalg.inv(mobility)
    at_work = np.einsum("tij,tj->ti", inertia, np.gradient(velocity, run.step, axis=0))
    scale = np.sqrt(np.mean(at_work**2, axis=0)) + 1e-12
    data = mujoco.MjData(model)
    mujoco.mj_fwdPosition(model, data)
    steps = np.abs(np.diff(run.command, axis=0, prepend=run.command[:1]))
    forces = steps @ np.abs(model.actuator_gainprm[:, :1] * actuator_moments(model, data))
    jolt = run.clock * np.einsum("tij,tj->ti", np.abs(jacobian[:, :, 2 * dofs :]), forces)
    if known is None:
        wide = np.concatenate([_spread(run, position), _spread(run, velocity)])
        known = Disturbance(noise=run.noise, scale=0.05 * scale, time=0.2, start=wide)
    return Reference(
        position=position,
        velocity=velocity,
        force=force,
        acceleration=acceleration,
        tangent=tangent,
        disturbance=replace(known, jolt=jolt),
        error=np.where(run.valid, run.reading - shown, 0.0),
        sensed=run.noise,
        effort=scale,
    )


def _spread(run: SampledRun, values: Array) -> Array:
    """Return how far the first values may be off: a tenth of what they cover."""
    spread: Array = 0.1 * np.ptp(values, axis=0) + 10.0 * run.noise.max()
    return spread
