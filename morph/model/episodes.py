"""Recordings laid on a simulation's grid: commands by step, readings, smooth motion."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from morph.arrays import Array, Mask
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.errors import DiagnosisError
from morph.model.joint_rates import JointRates
from morph.model.measurement import Measurement
from morph.physics.body_motion import body_motions
from morph.record.clock import period, thinned
from morph.record.noise import noise
from morph.record.recording import Channel, Recording
from morph.record.slopes import band, slopes
from morph.sim.drive import completed, held

QUIETEST = 1e-5
"""rad or m: least noise that a sensor is credited with."""
SHORTEST = 0.5
"""Least seconds of an episode: in less friction does not show."""
STATE_HERTZ = 15.0
"""Band of the motion that a rollout's start is read from."""
TURN, INSTANTS = 0.05, 1000
"""Most rad by which a link turns in a step, and most instants of a run at which that is seen."""


@dataclass(frozen=True, kw_only=True)
class Episode:
    """One recording of a robot, with a guess of the motion of joints that were not measured."""

    measurement: Measurement
    """What its readings are of."""
    recording: Recording
    """Where it came from."""
    step: float
    """Seconds a step of simulation."""
    command: Array
    """Mean command about the start of each step, shape (steps, actuators)."""
    unsure: Array
    """Standard deviation of commands that the logger lost or that measured efforts stand for, zero
    elsewhere, same shape. Of each step alone: it is larger than that of their mean over the time of
    one sample."""
    time: Array
    """When readings were taken, s from the start, shape (readings,)."""
    reading: Array
    """What each channel reads, shape (readings, channels); interpolated where not `valid`."""
    valid: Mask
    """Which channels were read then, same shape: each has its own clock, and may lose samples."""
    guess: Array
    """Standard deviation of the positions of joints that no sensor read, which are guesses; 0 of
    others, and of what follows from these; shape (dofs,)."""
    attitude: Array
    """Measured orientations of what moves freely, shape (readings, balls, 4)."""
    rates: JointRates
    """What sensors of velocity read."""
    noise: Array
    """Standard deviation of each reading's noise, shape (channels,)."""
    state: Array
    """Positions, then velocities, lightly smoothed, shape (readings, nq + nv)."""
    state_cutoff: Array
    """Frequency, Hz, above which motion is taken for noise in `state`, shape (channels,)."""
    position: Array
    """Positions smoothed to the band of the motion, shape (readings, nq)."""
    velocity: Array
    """How they change, per s, shape (readings, nv)."""
    acceleration: Array
    """How that changes, per s2, same shape."""
    cutoff: float
    """Frequency, Hz, above which motion is taken for noise in the three above."""
    begin: float = 0.0
    """Seconds from the recording's first reading to its first step; within half a step of 0 for a
    whole recording."""
    whole: bool = True
    """Whether it is all of its recording."""

    @property
    def name(self) -> str:
        """How reports call it."""
        name = self.recording.name
        return name if self.whole else f"{name} from {self.begin:.1f} s"

    @property
    def session(self) -> str:
        """Same day and same setup."""
        return self.recording.session


RARELY = 0.1
"""Of the period between readings of a single body, its step."""


def step_for(recordings: Sequence[Recording], robot: Robot, *, longest: float = math.inf) -> float:
    """Return the seconds a step: whole parts or multiples of the fastest clock's median period.

    About 4 ms, 2.5 ms where servos add stiff damping; of a single body that touches
    nothing and is read more rarely, a tenth of its period; and never above `longest`.
    """
    measurement = Measurement.of(robot)
    periods = [min(map(period, measurement.clocks(each))) for each in recordings]
    usual = float(np.median(periods))
    wanted = 0.0025 if any(a.kind == "position" for a in robot.actuators) else 0.004
    if [joint.kind for joint in robot.joints] == ["free"] and not _meets(robot):
        # No contact, spring or motor is faster than what is read.
        wanted = max(wanted, RARELY * usual)
    wanted = min(wanted, longest)
    if usual > wanted:
        return usual / float(np.ceil(usual / wanted - 0.1))
    return usual * max(1.0, float(np.floor(wanted / usual + 0.1)))


def _meets(robot: Robot) -> bool:
    """Return whether any shape may touch another."""
    model = spec_of(robot).compile()
    return bool(model.npair or (model.geom_contype.any() and model.geom_conaffinity.any()))


def longest_step(robot: Robot, episodes: Sequence[Episode]) -> float:
    """Return the seconds in which the fastest link turns by 0.05 rad, where forces are large.

    With the starts fitted, the error of a semi-implicit step is of second order: (w h)^2 / 24 of
    the force, 1e-4 here. Forces of a motion at w rad/s grow with its square, so the mean is taken
    of squares by their squares.
    """
    model = spec_of(robot).compile()
    fastest = 0.0
    for each in episodes:
        motion = _instants(each)
        for link in body_motions(model, [link.name for link in robot.links], *motion).values():
            square = (link.velocity[:, 3:] ** 2).sum(axis=1)
            fastest = max(fastest, float((square**4).mean() / max((square**2).mean(), 1e-12)))
    return float(TURN / max(fastest, 1e-12) ** 0.25)


def velocity_lag(robot: Robot, episodes: Sequence[Episode], step: float) -> Array:
    """Return what a step leaves of Coriolis forces over the inertial force, RMS, shape (dofs,).

    A semi-implicit step has the velocity of half a step before its positions, v - h a / 2 for v.
    Much of that is like another mass or inertia; at a joint that others move, not all.
    """
    model = spec_of(robot).compile()
    data, squares = mujoco.MjData(model), np.zeros((2, model.nv))
    for each in episodes:
        for position, velocity, acceleration in zip(*_instants(each), strict=True):
            data.qpos[:], data.qacc[:] = position, acceleration
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            forces = np.zeros((3, model.nv))
            for force, late, moved in zip(forces, (0.0, step, 0.0), (0, 0, 1), strict=True):
                data.qvel[:] = velocity - 0.5 * late * acceleration
                mujoco.mj_comVel(model, data)
                mujoco.mj_rne(model, data, moved, force)
            forces[2] += model.dof_armature * acceleration
            squares += (forces[1:] - forces[0]) ** 2
    return np.asarray(np.sqrt(squares[0] / np.maximum(squares[1], 1e-300)))


def _instants(episode: Episode) -> tuple[Array, Array, Array]:
    """Return positions, velocities and accelerations at some instants of a run."""
    some = slice(None, None, -(-len(episode.position) // INSTANTS))
    return episode.position[some], episode.velocity[some], episode.acceleration[some]


def episode(recording: Recording, robot: Robot, step: float) -> Episode:
    """Lay one recording on the grid of a simulation.

    Raises:
        RecordingError: A joint's position or an actuator's command is missing.
        DiagnosisError: The recording is shorter than half a second.
    """
    measurement = Measurement.of(robot)
    tracks = measurement.tracks(recording)
    commands = [recording.channel(f"{actuator.name}.command") for actuator in robot.actuators]
    start = max(float(track.time[0]) for track in tracks)
    end = min(float(track.time[-1]) for track in tracks)
    if end - start < SHORTEST:
        raise DiagnosisError(
            f"it lasts {end - start:.3g} s; friction shows only over half a second or more",
            where=f"recording {recording.name}",
            fix="record for longer; without --held-out a quarter of a recording is set aside",
        )
    begin = _phase(robot, commands, start - 0.5 * step, step)
    start += begin
    clocks = [thinned(clock, start, end) for clock in measurement.clocks(recording)]
    kept = np.unique(np.concatenate(clocks))
    light = np.minimum([0.2 / period(track.time) for track in tracks], STATE_HERTZ)
    cutoff = np.minimum(light, max(band(track) for track in tracks))
    quick, smooth = (_moving(measurement, tracks, kept, hertz) for hertz in (light, cutoff))
    raw = np.stack([np.interp(kept, track.time, track.value) for track in tracks], axis=1)
    read = [np.isin(kept, track.time) & (track.guess is None) for track in tracks]
    steps = int((end - start) / step + 1e-6)
    # A semi-implicit step is a leapfrog: the force of step n carries the velocity from
    # half a step before it to half a step after, so its command is centred on it.
    drive, unsure = [np.zeros((steps, 0))], [np.zeros((steps, 0))]
    for channel in commands:
        whole, error = completed(channel)
        drive.append(held(whole, start - 0.5 * step, step, steps)[:, None])
        # One error a sample acts as an independent one of each of its steps.
        error = np.hypot(error, channel.noise or 0.0)
        of_steps = error * np.sqrt(max(1.0, float(np.median(np.diff(whole.time))) / step))
        lost = replace(channel, time=whole.time, value=of_steps, hold=True)
        unsure.append(lost.at(start + step * np.arange(steps, dtype=float))[:, None])
    return Episode(
        recording=recording,
        step=step,
        command=np.concatenate(drive, axis=1),
        unsure=np.concatenate(unsure, axis=1),
        time=kept - start,
        measurement=measurement,
        reading=measurement.spread(raw),
        valid=measurement.by_channel(np.stack(read, axis=1).astype(float)) > 0.0,
        guess=measurement.by_channel(np.array([track.guess or 0.0 for track in tracks])),
        attitude=measurement.attitude(raw),
        rates=JointRates.of(recording, robot, start, end),
        noise=_floored(measurement.noise(np.array([_noise(track) for track in tracks]))),
        state=np.concatenate(quick[:2], axis=1),
        state_cutoff=measurement.by_channel(light),
        position=smooth[0],
        velocity=smooth[1],
        acceleration=smooth[2],
        cutoff=float(cutoff.max()),
        begin=begin,
    )


def _phase(robot: Robot, commands: Sequence[Channel], edge: float, step: float) -> float:
    """Return the shift, at most half a step, that lets steps begin when commands change.

    An actuator that comes to its limit within a step gives another force than at the mean command.
    """
    whole = 0.0j
    if spec_of(robot).compile().actuator_forcelimited.any():
        for channel in commands:
            turn = np.exp(2j * np.pi * (channel.time[1:] - edge) / step)
            size = np.std(channel.value)
            whole += np.abs(np.diff(channel.value)) @ turn / size if size > 0.0 else 0.0
    return float(np.angle(whole) / (2.0 * np.pi) * step)


def _moving(
    measurement: Measurement, tracks: Sequence[Channel], times: Array, cutoffs: Array
) -> tuple[Array, Array, Array]:
    """Return smoothed positions, velocities and accelerations at some times."""
    parts = [slopes(t.time, t.value, hertz) for t, hertz in zip(tracks, cutoffs, strict=True)]
    columns = [
        np.stack(
            [np.interp(times, t.time, p[k]) for t, p in zip(tracks, parts, strict=True)], axis=1
        )
        for k in range(3)
    ]
    return measurement.motion(*columns)


def _noise(track: Channel) -> float:
    """Return the standard deviation of a track's noise, as it shows or as it is known."""
    shown = noise(track.time, track.value)
    return shown if track.noise is None else max(shown, track.noise)


def _floored(noises: Array) -> Array:
    """Return noises, none so small that one still or simulated joint outvotes the others."""
    return np.maximum(noises, max(QUIETEST, 0.01 * float(noises.max())))


def fills(episode: Episode) -> list[str]:
    """Return in how many places commands were interpolated, as the logger lost them, in words."""
    # An effort that stands for a command errs everywhere.
    lost = (episode.unsure > episode.unsure.min(axis=0)).any(axis=1)
    count = int(np.count_nonzero(np.diff(lost, prepend=False) & lost))
    return [f"commands that the logger lost are interpolated, gaps: {count}"] if count else []
