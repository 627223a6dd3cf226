"""How joints that no sensor read may have moved, given those that were read."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from morph.arrays import Array, Integers, Mask
from morph.body.follow import follow, leaders
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.errors import RecordingError
from morph.inference.filter import Disturbance, FilterRun, Tangent
from morph.model.episodes import STATE_HERTZ
from morph.model.joint_rates import JointRates
from morph.physics.dynamics import accelerations, jacobians, supplied
from morph.record.noise import noise
from morph.record.recording import Channel, Note, Recording
from morph.record.slopes import band, slopes
from morph.sim.drive import held

STEP, EVERY = 0.002, 10
"""Seconds a step of the filter, and steps from one linearisation to the next."""
HEAVY = 1e3
"""Inertia of joints that were read, over the largest of all, while the others come to rest."""
RESTING, FADES = 10.0, 0.2
"""Seconds in which these come to rest, and in which their rates fade."""
UNTOLD, CORRELATION_TIME = 0.3, 0.2
"""Missing force as a share of the RMS force that a joint's motion needs, and its correlation time,
s."""
NOISE = 1e-3
"""Least noise of a reading, as a share of its RMS motion: linearised steps err by as much."""
SPREAD, RATE = 0.3, 1.0
"""Standard deviations of where an unread joint begins, rad or m, and how fast, per s."""


def with_unmeasured(
    recording: Recording, robot: Robot, model: mujoco.MjModel | None = None
) -> Recording:
    """Return a recording with guesses of the positions of hinges and slides that were not read.

    An extended Kalman filter follows the readings, with a missing force at every joint; the joints
    begin at rest where their forces balance. It is noted. Recordings of no joint's position, of
    free links or without commands stay as they are, for others to refuse.

    Source: Simon 2006, Optimal State Estimation, section 13.2.

    Args:
        recording: What was recorded; older guesses are replaced.
        robot: Its robot.
        model: What the filter goes by; None for the description.

    Raises:
        RecordingError: The filter diverges.
    """
    given = {name for name, each in recording.channels.items() if not each.guess}
    lead = [each.name for each in robot.joints if each.mimic is None]
    read = [name for name in lead if f"{name}.position" in given]
    unread = [name for name in lead if name not in read]
    needed = [f"{actuator.name}.command" for actuator in robot.actuators]
    known = all(name in recording.channels for name in needed)
    if not (read and unread and known) or any(
        each.kind in {"free", "ball"} for each in robot.joints
    ):
        return recording
    run = _Readings.of(recording, robot, read, model or spec_of(robot).compile())
    with np.errstate(over="ignore", invalid="ignore"):
        position, spread = run.filtered()
    if not (np.isfinite(position).all() and np.isfinite(spread).all()):
        raise RecordingError(
            f"the position of {', '.join(unread)} was not read, and cannot be estimated from the "
            "other joints: the filter diverges",
            where=f"recording {recording.name}",
            fix="record it, or begin at rest and move less fast; or weld that joint in the "
            "description if it is held still",
        )
    channels = dict(recording.channels)
    for name in unread:
        at = run.model.joint(name).dofadr[0]
        guess = float(np.sqrt(np.mean(spread[:, at] ** 2)))
        channels[f"{name}.position"] = Channel(time=run.time, value=position[:, at], guess=guess)
    note = Note(
        what=f"the position of {', '.join(unread)} was not read: its motion is estimated with the "
        "rest",
        where=f"recording {recording.name}",
    )
    notes = recording.notes if note in recording.notes else (*recording.notes, note)
    return replace(recording, channels=channels, notes=notes)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Readings:
    """Readings of some joints of a robot, on a grid."""

    model: mujoco.MjModel
    time: Array
    """s, shape (steps,)."""
    dofs: Integers
    """Degrees of freedom of the joints that were read; of hinges and slides coordinates too."""
    position: Array
    """Of these, rad or m, shape (steps, joints)."""
    velocity: Array
    """Same shape."""
    acceleration: Array
    """Same shape."""
    valid: Mask
    """Where there is a reading nearby, same shape."""
    noise: Array
    """Standard deviation of the readings' noise, shape (joints,)."""
    rates: JointRates
    """What sensors of velocity read."""
    command: Array
    """Controls, shape (steps, actuators)."""

    @classmethod
    def of(
        cls, recording: Recording, robot: Robot, read: Sequence[str], model: mujoco.MjModel
    ) -> _Readings:
        """Return the readings of some joints of a recording."""
        tracks = [recording.channel(f"{name}.position") for name in read]
        start = max(float(track.time[0]) for track in tracks)
        end = min(float(track.time[-1]) for track in tracks)
        time: Array = start + STEP * np.arange(max(2, int((end - start) / STEP)), dtype=float)
        parts, valid, noises = [], np.zeros((len(time), len(read)), dtype=bool), []
        for at, track in enumerate(tracks):
            period = float(np.median(np.diff(track.time)))
            cutoff = min(0.2 / period, STATE_HERTZ, band(track))
            moved = slopes(track.time, track.value, cutoff)
            parts.append([np.interp(time, track.time, each) for each in moved])
            parts[-1][0] = np.interp(time, track.time, track.value)
            near = np.rint((track.time - start) / STEP).astype(int)
            valid[near[(near >= 0) & (near < len(time))], at] = True
            noises.append(max(noise(track.time, track.value), NOISE * float(np.std(track.value))))
        position, velocity, acceleration = np.moveaxis(np.array(parts), 0, 2)
        command = np.zeros((len(time), model.nu))
        for at, actuator in enumerate(robot.actuators):
            channel = recording.channel(f"{actuator.name}.command")
            command[:, at] = held(channel, start - 0.5 * STEP, STEP, len(time))
        return cls(
            model=model,
            time=time,
            dofs=np.array([model.joint(name).dofadr[0] for name in read]),
            position=position,
            velocity=velocity,
            acceleration=acceleration,
            valid=valid,
            noise=np.array(noises),
            rates=JointRates.of(recording, robot, start, end),
            command=command,
        )

    def rest(self) -> Array:
        """Return positions at which the other joints are at rest as a run begins, shape (nq,)."""
        model = copy.copy(self.model)
        model.opt.timestep = STEP
        data = mujoco.MjData(model)
        model.dof_armature[self.dofs] += HEAVY * model.dof_M0.max()
        data.qpos[self.dofs], data.ctrl[:] = self.position[0], self.command[0]
        for _ in range(round(RESTING / STEP)):
            mujoco.mj_step(model, data)
            data.qvel[:] *= 1.0 - STEP / FADES
            data.qpos[self.dofs], data.qvel[self.dofs] = self.position[0], 0.0
        return np.array(data.qpos)

    def filtered(self) -> tuple[Array, Array]:
        """Return positions of all joints and their standard deviations, shape (steps, dofs)."""
        model, steps, dofs = self.model, len(self.time), self.model.nv
        ties = leaders(model)
        # The filter's state is of the joints that follow none; `whole` gives all by these.
        own = np.delete(np.arange(dofs), list(ties))
        whole, count, read = np.eye(dofs)[:, own], len(own), np.searchsorted(own, self.dofs)
        for joint, (leader, ratio, _) in ties.items():
            whole[joint] = ratio * whole[leader]
        position, velocity = self.rest(), np.zeros(dofs)
        velocity[self.dofs] = self.velocity[0]
        velocity = whole @ velocity[own]
        follow(model, position[None], velocity[None])
        first = np.repeat([SPREAD, RATE], count)
        first[read] = 10.0 * self.noise
        first[count + read] = 0.1 * np.std(self.velocity, axis=0)
        rate, rated = self.rated()
        own_rates = count + np.searchsorted(own, self.rates.dofs)
        tangent = Tangent(
            step=STEP,
            jacobian=np.zeros((steps, count, 3 * count)),
            reads=np.eye(2 * count)[np.concatenate([read, own_rates])],
            valid=np.concatenate([self.valid, rated], axis=1),
        )
        disturbance = Disturbance(
            noise=np.concatenate([self.noise, self.rates.noise]),
            scale=UNTOLD * self.usual(position)[own],
            correlation_time=CORRELATION_TIME,
            initial=first + 1e-9,
        )
        run = FilterRun(tangent, disturbance, 1)
        untold, keep = np.zeros(count), float(np.exp(-STEP / CORRELATION_TIME))
        result, spread = np.empty((steps, dofs)), np.empty((steps, dofs))
        for begins in range(0, steps, EVERY):
            part = slice(begins, min(begins + EVERY, steps))
            (local,) = jacobians(model, position[None], velocity[None], self.command[part][:1])
            by_position, by_velocity, mobility = np.split(local, 3, axis=1)
            damped = np.eye(dofs) - 0.5 * STEP * by_velocity
            mobility = mobility[:, own]
            local = np.hstack([by_position @ whole, by_velocity @ whole, mobility])
            tangent.jacobian[part] = np.linalg.solve(damped, local)[own]
            for at in range(part.start, part.stop):
                result[at] = position
                before = velocity
                (push,) = accelerations(
                    model, position[None], velocity[None], self.command[at][None]
                )
                velocity = velocity + STEP * np.linalg.solve(damped, push + mobility @ untold)
                # Velocities are those of half a step before.
                rate[at] -= 0.5 * (before + velocity)[self.rates.dofs]
                position = position + STEP * velocity
                untold = keep * untold
            error = self.position[part] - result[part][:, self.dofs]
            error = np.concatenate([error, rate[part]], axis=1)
            run.filter(part, error[:, :, None], None)
            change, variance = run.moved()
            position = position + whole @ change[:count]
            velocity = velocity + whole @ change[count : 2 * count]
            untold = untold + change[2 * count :]
            spread[part] = np.sqrt(np.maximum(whole**2 @ variance[:count], 0.0))
        return result, spread

    def rated(self) -> tuple[Array, Mask]:
        """Return velocities that were read, and where there is one, (steps, sensors) each."""
        shape = len(self.time), len(self.rates.dofs)
        result, valid = np.zeros(shape), np.zeros(shape, dtype=bool)
        near = np.rint(self.rates.time / STEP).astype(int)
        row, sensor = np.nonzero(self.rates.valid & (near < len(self.time))[:, None])
        result[near[row], sensor] = self.rates.reading[row, sensor]
        valid[near[row], sensor] = True
        return result, valid

    def usual(self, rest: Array) -> Array:
        """Return the RMS force that the motion which was read needs, N m or N, shape (dofs,).

        A joint whose own motion is not known bears as much as the least of the others.
        """
        still, rates = np.tile(rest, (len(self.time), 1)), np.zeros((2, len(self.time), len(rest)))
        still[:, self.dofs] = self.position
        rates[:, :, self.dofs] = self.velocity, self.acceleration
        force = supplied(self.model, still, rates[0], rates[1], np.zeros_like(self.command))
        result = np.sqrt(np.mean(force**2, axis=0))
        return np.asarray(np.maximum(result, 1e-3 * result.max()))
