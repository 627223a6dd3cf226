"""One run of a robot, smoothed and linearised by a model, and the effects' forces along it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.inference.disturbance import likeliest_disturbance
from morph.inference.reference import FEWER_STEPS, reference
from morph.inference.sampled import Reference, SampledRun
from morph.inference.sticking import ending, friction, moved
from morph.inference.ties import inverse
from morph.model.episodes import Episode
from morph.model.measurement import unit
from morph.physics.body_motion import BodyMotion, body_motions, times
from morph.physics.drives import Transmission, actuator_forces
from morph.physics.effect import Effect
from morph.physics.motion import Motion
from morph.sim.drive import all_received

NUDGE = 1e-7
"""Step of a difference, rad or m, and per s: small beside what limits and gaps are wide."""
STICKING_ROUNDS = 2
"""Rounds of the smoother under dry friction: each finds anew where joints stick."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Observed:
    """One run, smoothed by a model and linearised along its motion."""

    run: SampledRun
    """Commands as the actuators receive them, and readings."""
    about: Reference
    """The smoothed motion and the model linearised along it."""
    motion: Motion
    """The smoothed motion as effects' regressors take it."""
    sent: Array
    """Commands as the controller sent them, shape (samples, actuators)."""


def observed(
    model: mujoco.MjModel,
    robot: Robot,
    read: Episode,
    *,
    effects: Sequence[Effect] = (),
    before: Observed | None = None,
) -> Observed:
    """Return a run smoothed and linearised by a model.

    The disturbance is the one of `before`, or the likeliest without it.

    Args:
        model: The robot's.
        robot: Its description.
        read: The run.
        effects: What acts beside the model. Forces and changes of readings act along the motion
            of `before` and are left out without it; changes of commands always act.
        before: The same run by a similar model, to start from.

    Raises:
        KernelError: There is no C compiler for the filter, or it fails.
    """
    run, guess = _sampled(read)
    run = replace(run, command=all_received(effects, robot, run.command, run.step))
    if before is None:
        about = reference(model, run, guess)
        motion = _motion(model, robot, about, run, read.name)
        return Observed(run=run, about=about, motion=motion, sent=read.command)
    about, motion = before.about, before.motion
    for _ in range(STICKING_ROUNDS if any(effect.holds for effect in effects) else 1):
        dry = friction(effects, motion, about)
        motion = replace(motion, senses=dry.senses)
        force, shift = force_of(effects, motion), shift_of(effects, motion)
        plain = replace(run, shift_slope=0.0).reads
        slope, shift_slope = _slope_of(effects, motion), _shift_slope_of(effects, motion, plain)
        run = replace(
            run, force=force, slope=slope, shift=shift, shift_slope=shift_slope,
            sticking=dry.damping,
        )  # fmt: skip
        last = motion
        about = reference(model, run, guess, before=about)
        motion = moved(dry, _motion(model, robot, about, run, read.name), about)
        if effects:
            # The motion has changed, and under a stiff servo the effects' forces with it: evaluate
            # them along the new one.
            mobility = about.tangent.mobility
            linear = force - dry.damping * ending(about)
            linear += slope[:, 0] * (motion.position - last.position)
            linear += slope[:, 1] * (motion.velocity - last.velocity)
            change = times(mobility, force_of(effects, motion) - linear)
            shift = shift_of(effects, motion) - shift
            about = replace(
                about,
                acceleration=about.acceleration + change,
                error=np.where(about.tangent.valid, about.error - shift, 0.0),
            )
    return Observed(run=run, about=about, motion=motion, sent=read.command)


def settled(seen: Observed) -> Observed:
    """Return a smoothed run with the likeliest disturbance."""
    disturbance = likeliest_disturbance(seen.about, steps=FEWER_STEPS)
    return replace(seen, about=replace(seen.about, disturbance=disturbance))


def missing(runs: Sequence[Observed]) -> float:
    """Return the missing force over the inertial force, RMS, of the worst joint."""
    return float(missing_by_joint(runs).max())


def missing_by_joint(runs: Sequence[Observed]) -> Array:
    """Return the missing force over the inertial force, RMS over runs, shape (dofs,)."""
    squared = [(run.about.disturbance.scale / run.about.inertial) ** 2 for run in runs]
    return np.asarray(np.sqrt(np.mean(squared, axis=0)))


class _Bodies(Mapping[str, BodyMotion]):
    """How links move, computed when first asked for: few effects ask."""

    def __init__(self, compute: Callable[[], dict[str, BodyMotion]]) -> None:
        self._compute = compute

    @cached_property
    def _found(self) -> dict[str, BodyMotion]:
        return self._compute()

    def __getitem__(self, name: str) -> BodyMotion:
        return self._found[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._found)

    def __len__(self) -> int:
        return len(self._found)


def force_of(effects: Sequence[Effect], motion: Motion) -> Array:
    """Return the generalized force of effects along a motion, N m or N, shape (samples, dofs)."""
    force = np.zeros_like(motion.position)
    for effect in effects:
        # Effects on a command act through the actuators, and those on a sensor on no joint.
        if type(effect).command is Effect.command and effect.kind != "sensor":
            force += effect.regressor(motion) @ effect.coefficients
    return force


def _slope_of(effects: Sequence[Effect], motion: Motion) -> Array:
    """Return how forces without a memory change with their joint's position and velocity.

    A stop is stiff where it is reached. Shape (samples, 2, dofs).
    """
    slope = np.zeros((len(motion.time), 2, motion.position.shape[1]))
    local = [e for e in effects if e.kind == "joint" and not e.holds and not e.remembers]
    if not local:
        return slope
    held = force_of(local, motion)
    for at, name in enumerate(("position", "velocity")):
        there = replace(motion, **{name: getattr(motion, name) + NUDGE})
        slope[:, at] = (force_of(local, there) - held) / NUDGE
    return slope


def shift_of(effects: Sequence[Effect], motion: Motion) -> Array:
    """Return how much effects change readings along a motion, shape (samples, channels)."""
    shift = np.zeros_like(motion.reading)
    for effect in (each for each in effects if each.kind == "sensor"):
        shift += effect.reading_regressor(motion) @ effect.coefficients
    return shift


def _shift_slope_of(effects: Sequence[Effect], motion: Motion, reads: Array) -> Array:
    """Return how changes of readings grow with positions and velocities, (channels, 2 dofs).

    Args:
        effects: What acts.
        motion: The motion.
        reads: Each channel by positions and velocities without that.
    """
    held, dofs = shift_of(effects, motion), motion.position.shape[1]
    # A position's rate is a velocity; that of a velocity is no state.
    result, of_rate = np.zeros_like(reads), np.roll(reads, dofs, axis=1)
    of_rate[dofs:] = 0.0
    for name, by_state in (("reading", reads), ("reading_rate", of_rate)):
        there = replace(motion, **{name: getattr(motion, name) + NUDGE})
        slope = (shift_of(effects, there) - held).mean(axis=0) / NUDGE
        result += slope[:, None] * by_state
    return result


def _sampled(read: Episode) -> tuple[SampledRun, Array]:
    """Return an episode on the simulation's grid, and a first guess of positions on it."""
    samples, dofs, rates = len(read.command), read.reading.shape[1], read.rates
    shape = samples, dofs + len(rates.dofs)
    reading, offset, valid = np.zeros(shape), np.zeros(shape), np.zeros(shape, dtype=bool)
    attitude = np.tile(np.eye(4)[0], (samples, read.attitude.shape[1], 1))
    for sensors, first in ((read, 0), (rates, dofs)):
        # A reading between two samples belongs to the nearer one.
        at = np.rint(sensors.time / read.step).astype(int)
        row, channel = np.nonzero(sensors.valid & (at < samples)[:, None])
        there = at[row], first + channel
        reading[there], valid[there] = sensors.reading[row, channel], True
        offset[there] = (sensors.time - at * read.step)[row]
        for ball, (_, turn) in enumerate(read.measurement.coordinates.balls if not first else ()):
            turned = row[channel == turn]
            attitude[at[turned], ball] = read.attitude[turned, ball]
    grid = read.step * np.arange(samples)
    shown = read.measurement.placed(read.reading, read.attitude)
    placed, guess = (
        np.stack([np.interp(grid, read.time, track) for track in each.T], axis=1)
        for each in (shown, read.position)
    )
    for place, _ in read.measurement.coordinates.balls:
        for each in (placed, guess):
            each[:, place : place + 4] = unit(each[:, place : place + 4])
    run = SampledRun(
        measurement=read.measurement,
        rates=rates.dofs,
        step=read.step,
        command=read.command,
        reading=reading,
        attitude=attitude,
        valid=valid,
        placed=placed,
        noise=np.concatenate([read.noise, rates.noise]),
        guess=read.guess,
        time_offset=offset,
        unsure=_unsure(read),
    )
    return run, guess


def _unsure(read: Episode) -> Array:
    """Return the standard deviation of each control's integral over a step, (samples, actuators).

    It is that of the commands as sent: a law that spreads a command's step over several samples
    does not make the time of that step better known.
    """
    times = [c.time for n, c in read.recording.channels.items() if n.endswith(".command")]
    periods = [np.diff(time) for time in times]
    # The median absolute deviation of a normal distribution is 0.6745 of its standard deviation,
    # and a period is the difference of two times; the least regular channel's counts.
    spread = [np.median(np.abs(p - np.median(p))) / 0.6745 / np.sqrt(2.0) for p in periods]
    changes = np.abs(np.diff(read.command, axis=0, prepend=read.command[:1]))
    return np.asarray(np.hypot(max(spread, default=0.0) * changes, read.step * read.unsure))


def _motion(
    model: mujoco.MjModel, robot: Robot, about: Reference, run: SampledRun, name: str
) -> Motion:
    """Return a smoothed motion as effects' regressors take it.

    Velocities and accelerations are those at the positions' times, and the acceleration is the
    model's: the missing force is not in it. Forces of contact are.
    """
    samples, dofs = about.velocity.shape
    position = run.measurement.scalars(about.position)
    acceleration = np.zeros_like(about.velocity)
    acceleration[:-1] = np.diff(about.velocity, axis=0) / run.step
    acceleration[-1] = acceleration[-2]
    velocity = about.velocity + 0.5 * run.step * acceleration
    acceleration += about.free
    transmission = Transmission.along(model, about.position)
    moments = transmission.moment
    force = actuator_forces(model, transmission, velocity, run.command)
    rate = np.gradient(run.command, run.step, axis=0) * model.actuator_gainprm[:, 0]
    local = about.local
    stiffness = -inverse(model, local[:, :, 2 * dofs :]) @ local[:, :, :dofs]
    stiffness -= np.eye(dofs) * np.broadcast_to(run.slope, (samples, 2, dofs))[:, :1]
    links, channels = [link.name for link in robot.links], run.measurement.channels
    rated = tuple(f"{channels[dof].removesuffix('.position')}.velocity" for dof in run.rates)
    return Motion(
        position=position,
        pose=about.position,
        velocity=velocity,
        acceleration=acceleration,
        drive=moments * force[:, :, None],
        drive_rate=moments * rate[:, :, None],
        stiffness=stiffness,
        joints={joint.name: model.joint(joint.name).dofadr[0] for joint in robot.joints},
        actuators={actuator.name: at for at, actuator in enumerate(robot.actuators)},
        bodies=_Bodies(lambda: body_motions(model, links, about.position, velocity, acceleration)),
        time=run.step * np.arange(samples, dtype=float),
        command=run.command,
        driven={actuator.name: actuator.joint for actuator in robot.actuators},
        moment=transmission.by_effort(model),
        servo=-(model.actuator_gear[:, :1] ** 2) * model.actuator_biasprm[:, 1:3],
        armature=model.dof_armature.copy(),
        channels={name: at for at, name in enumerate(channels + rated)},
        reading=np.concatenate([position, velocity[:, run.rates]], axis=1),
        reading_rate=np.concatenate([velocity, acceleration[:, run.rates]], axis=1),
        run=name,
        missing=about.force,
    )
