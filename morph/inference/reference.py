"""The most likely motion of a robot given its model, and the disturbance of the model."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.follow import chains, follow, leaders
from morph.inference.axes import Axes, along_body, along_parent, axes_of, jacobian_along_parent
from morph.inference.contact import Contact, by_contact, contact_along
from morph.inference.disturbance import likeliest_disturbance
from morph.inference.filter import Disturbance, Tangent, smoothed
from morph.inference.sampled import Reference, SampledRun, later, outliers, predicted
from morph.inference.ties import carried, inverse
from morph.physics.body_motion import times
from morph.physics.drives import Transmission, actuator_forces
from morph.physics.dynamics import accelerations, closed, jacobians

INTERVAL = 0.02
"""Seconds from one derivative of the model to the next: 3 rad/s turn a link by 0.06 rad."""
ROUNDS = 3
"""Iterations of the smoother: smooth, then linearise again."""
STEPS, FEWER_STEPS = 30, 15
"""Most steps of L-BFGS to the likeliest disturbance: from anywhere, and from one nearby."""


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
        model: The model.
        run: What was commanded and read.
        guess: Positions to begin with, shape (samples, nq).
        before: The result of a similar model, to begin with instead of `guess`. The readings that
            it left out are left out, and no others: evidences are of the same readings.
    """
    if before is not None:
        run = replace(run, valid=before.tangent.valid)
        return _smoothed(model, run, _moved(before, model, run), before.disturbance)
    position = np.array(guess)
    rate = run.measurement.coordinates.apart(position[1:], position[:-1]) / run.step
    velocity = np.concatenate([rate[:1], rate])
    # Between two readings the guess is a straight line.
    unsure = round(1.0 / max(float(run.valid.mean()), 1e-3))
    contact = contact_along(model, run.placed, position, velocity, run.step, unsure)
    result = _along(model, run, position, velocity, np.zeros_like(velocity), contact, None)
    known = likeliest_disturbance(result, steps=STEPS)
    for _ in range(ROUNDS):
        single = outliers(result.error / run.noise, run.valid)
        run = replace(run, valid=run.valid & ~single)
        result = _smoothed(model, run, result, known)
    return replace(result, disturbance=likeliest_disturbance(result, steps=FEWER_STEPS))


def _smoothed(
    model: mujoco.MjModel,
    run: SampledRun,
    result: Reference,
    known: Disturbance,
) -> Reference:
    """Return the motion of a linearised model, smoothed, and the model linearised along that.

    Args:
        model: The model.
        run: What was commanded and read.
        result: The model along another motion.
        known: The disturbance.
    """
    space = run.measurement.coordinates
    state, spread = smoothed(result.tangent, known, result.error, result.acceleration)
    change, rate, force, _ = np.split(state, [n * space.dofs for n in (1, 2, 3)], axis=1)
    position = space.moved_by(result.position, along_body(space, result.axes, change))
    velocity = result.velocity + along_body(space, result.axes, rate)
    chained = chains(model)
    if chained:
        position = closed(model, position)
    if space.balls or chained:
        # Rotations add up to the first order in the error alone, and chains close along curves.
        velocity[1:] = space.apart(position[1:], position[:-1]) / run.step
    follow(model, position, velocity)
    moved = _along(model, run, position, velocity, force, result.contact, known)
    return replace(moved, spread=spread)


def _along(
    model: mujoco.MjModel,
    run: SampledRun,
    position: Array,
    velocity: Array,
    force: Array,
    contact: Contact,
    known: Disturbance | None,
) -> Reference:
    """Return a model linearised along a motion, with a known disturbance or a first guess of it."""
    space = run.measurement.coordinates
    dofs, axes = space.dofs, axes_of(space, position)
    local = _interpolated(model, position, velocity, run)
    jacobian, acceleration, free, error = _errors(
        model, run, position, velocity, axes, local, contact.rows
    )
    mobility, moved = local[:, :, 2 * dofs :], np.gradient(velocity, run.step, axis=0)
    needed = carried(model, times(inverse(model, mobility), moved))
    needed = contact.borne(mobility, moved, needed)
    inertial = np.sqrt(np.mean(needed**2, axis=0)) + 1e-12
    if known is None:
        path = space.apart(position, position[:1])
        initial = np.stack([_initial_std(run, path), _initial_std(run, velocity)])
        # A joint that follows another errs as that does: it is placed anew after each smoothing.
        initial[:, model.jnt_dofadr[list(leaders(model))]] = 1e-12
        known = Disturbance(
            noise=run.noise,
            scale=0.05 * inertial,
            correlation_time=0.2,
            initial=initial.reshape(-1),
            vibration=run.noise[:dofs],
            contact=contact.changes(velocity) / run.step,
        )
    return Reference(
        position=position,
        velocity=velocity,
        spread=np.zeros_like(velocity),
        force=force,
        acceleration=acceleration,
        free=free,
        sticking=np.broadcast_to(run.sticking, velocity.shape),
        axes=axes,
        local=local,
        tangent=Tangent(
            step=run.step,
            jacobian=jacobian,
            reads=run.reads,
            valid=run.valid,
        ),
        contact=contact,
        disturbance=replace(known, jolt=_jolt(model, run, position, jacobian, contact.impact)),
        error=error,
        sensed=run.noise,
        unread=run.guess > 0.0,
        inertial=inertial,
    )


def _errors(
    model: mujoco.MjModel, run: SampledRun, position: Array, velocity: Array, axes: Axes,
    local: Array, touching: Array,
) -> tuple[Array, Array, Array, Array]:  # fmt: skip
    """Return a model's Jacobian along a motion, and its errors of accelerations and of readings.

    Between the first error of accelerations and that of readings stands the one along the body's
    axes to which contact adds nothing, see `Reference.free`.

    Args:
        model: The model.
        run: What was commanded and read.
        position: Shape (samples, nq).
        velocity: Shape (samples, dofs).
        axes: Of its orientations.
        local: The derivatives of the model, or of a similar one, shape (samples, dofs, 3 dofs).
        touching: The velocities of points in contact by those of joints, (samples, rows, dofs).
    """
    space = run.measurement.coordinates
    sticking = np.broadcast_to(run.sticking, velocity.shape)
    modelled = accelerations(model, position, velocity, run.command)
    modelled += times(local[:, :, 2 * space.dofs :], run.force - sticking * velocity)
    jacobian, modelled = _stepped(local, modelled, sticking, run)
    moved = np.zeros_like(modelled)
    moved[:-1] = np.diff(velocity, axis=0) / run.step
    # Nothing follows the last sample that its acceleration could be compared with.
    modelled[-1] = 0.0
    acceleration, free = modelled - moved, modelled - moved
    if touching.size:
        # Points in contact move as they will, whatever else acts, and the rest moves with them.
        contact = by_contact(touching, jacobian[:, :, 2 * space.dofs :])
        acceleration -= times(contact, times(touching, modelled))
        free -= times(contact, times(touching, free))
        jacobian -= contact @ (touching @ jacobian)
        jacobian = np.concatenate([jacobian, contact], axis=2)
    shown = np.where(run.valid, run.reading - predicted(run, position, velocity, axes), 0.0)
    return (
        jacobian_along_parent(space, axes, velocity, jacobian),
        along_parent(space, axes, acceleration),
        free,
        shown,
    )


def _stepped(
    local: Array, modelled: Array, sticking: Array, run: SampledRun
) -> tuple[Array, Array]:
    """Return a model's Jacobian and acceleration as the step that damps takes them.

    Velocities lie half a step before positions. The trapezoidal rule for damping makes the
    step of second order and stable: (1 - h/2 A_v) v' = v + h (a - A_v v / 2). Where a joint
    sticks damping is stiff, and the step is Euler's backward one.
    """
    dofs = sticking.shape[1]
    whole = np.concatenate([local, modelled[:, :, None]], axis=2)
    slope = np.broadcast_to(run.slope, (len(sticking), 2, dofs))
    whole[:, :, :dofs] += local[:, :, 2 * dofs :] * slope[:, :1]
    whole[:, :, dofs : 2 * dofs] += local[:, :, 2 * dofs :] * (slope[:, 1:] - sticking[:, None])
    damped = np.eye(dofs) - run.step * later(sticking) * whole[:, :, dofs : 2 * dofs]
    # An inverse costs half as much as solving for so many columns, and this is near the identity.
    result = np.asarray(np.linalg.inv(damped) @ whole)
    return result[:, :, :-1], result[:, :, -1]


def _interpolated(
    model: mujoco.MjModel, position: Array, velocity: Array, run: SampledRun
) -> Array:
    """Return a model's derivatives along a motion, linearly interpolated from a few samples.

    They are taken on both sides of where an actuator comes to its limit or leaves it: there its
    stiffness and damping jump.
    """
    samples, every = len(position), max(1, round(INTERVAL / run.step))
    keys = np.append(np.arange(0, samples, every), samples - 1)
    if model.actuator_forcelimited.any():
        force = actuator_forces(model, Transmission.along(model, position), velocity, run.command)
        low, high = model.actuator_forcerange.T
        changes = np.flatnonzero(np.diff((low < force) & (force < high), axis=0).any(axis=1))
        keys = np.concatenate([keys, changes, changes + 1])
    keys = np.unique(keys)
    there = jacobians(model, position[keys], velocity[keys], run.command[keys])
    place = np.interp(np.arange(samples), keys, np.arange(len(keys)))
    low = np.minimum(place.astype(int), max(len(keys) - 2, 0))
    share, high = (place - low)[:, None, None], np.minimum(low + 1, len(keys) - 1)
    return np.asarray((1.0 - share) * there[low] + share * there[high])


def _moved(before: Reference, model: mujoco.MjModel, run: SampledRun) -> Reference:
    """Return a similar model along the motion of another, by the other's derivatives.

    A smoother that is iterated once more needs them only roughly.
    """
    jacobian, acceleration, free, error = _errors(
        model, run, before.position, before.velocity, before.axes, before.local, before.contact.rows
    )
    return replace(
        before,
        acceleration=acceleration,
        free=free,
        sticking=np.broadcast_to(run.sticking, before.velocity.shape),
        tangent=replace(before.tangent, jacobian=jacobian, reads=run.reads),
        error=error,
    )


def _jolt(
    model: mujoco.MjModel, run: SampledRun, position: Array, jacobian: Array, impact: Array
) -> Array | None:
    """Return changes of velocity by unsure commands and impacts, (samples, dofs, sources)."""
    result, dofs = [], jacobian.shape[1]
    if run.unsure is not None:
        transmission = Transmission.along(model, position)
        transmission = replace(transmission, moment=np.abs(transmission.moment))
        forces = transmission.forces(run.unsure * np.abs(model.actuator_gainprm[:, 0]))
        moved = times(np.abs(jacobian[:, :, 2 * dofs : 3 * dofs]), forces)
        result.append(moved[:, :, None] * np.eye(dofs))
    if impact.any():
        result.append(impact[:, None, None] * jacobian[:, :, 3 * dofs :])
    return np.concatenate(result, axis=2) if result else None


def _initial_std(run: SampledRun, values: Array) -> Array:
    """Return how far the first values may be off: a tenth of their range, and tenfold noise.

    Of joints that were not read they are guesses.
    """
    some, noise = np.where(run.guess > 0.0, 1.0, 0.1), run.noise[: values.shape[1]]
    return np.asarray(some * np.ptp(values, axis=0) + 10.0 * noise.max() + run.guess)
