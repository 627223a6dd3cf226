"""Recorded motion through a fitted model: the forces that it needed and those it was given."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from scipy.signal import butter, sosfiltfilt

from morph.arrays import Array
from morph.body.actuators import strength
from morph.model.episodes import Episode
from morph.model.hypothesis import Hypothesis
from morph.model.measurement import Measurement
from morph.physics import EFFECTS
from morph.physics.body_motion import body_motions
from morph.physics.fluid.kernel import flowing
from morph.physics.motion import Motion, actuator_moments
from morph.sim.drive import all_received, unsensed
from morph.sim.rollout import Variant
from morph.sim.simulator import compiled

FEWEST = 20
"""Samples below which nothing is cut off an episode's ends."""
NUDGE = 1e-5
"""Step of a difference by a position, rad or m."""
HERTZ = 40.0
"""Rate at which motion is looked at; smoothed motion holds nothing faster."""


@dataclass(frozen=True, kw_only=True)
class Needed:
    """One episode's motion, and the force that the model cannot account for."""

    episode: Episode
    """Where it came from."""
    time: Array
    """When, s from the episode's start, shape (samples,)."""
    motion: Motion
    """The motion and the drives, smoothed alike."""
    missing: Array
    """Force needed by the motion minus force accounted for, shape (samples, dofs)."""

    def smooth(self, columns: Array) -> Array:
        """Return columns (samples, ...) smoothed as the motion was."""
        return low_pass(columns, self.time, self.episode.cutoff)


def low_pass(values: Array, time: Array, cutoff: float) -> Array:
    """Return values (samples, ...) without what is faster than `cutoff` Hz, in phase."""
    rate = 1.0 / float(np.median(np.diff(time)))
    if len(time) < 16 or cutoff >= 0.45 * rate:
        return values
    sections = butter(2, cutoff, fs=rate, output="sos")
    return np.asarray(sosfiltfilt(sections, values, axis=0, padlen=min(15, len(time) - 1)))


def needed(
    hypothesis: Hypothesis, point: Array, episode: Episode, *, suspects: bool = True
) -> Needed:
    """Return an episode's motion and the force missing from the model at a point.

    Args:
        hypothesis: The robot and effects.
        point: Where.
        episode: What to look at.
        suspects: Whether to tell how links move on which only suspects would act, and how stiff
            the model is, as suspected sensors ask.
    """
    effects = hypothesis.effects_at(point)
    # What acts step by step is told by its regressor, whole, not by its edit.
    stepped = [effect for effect in effects if effect.stepped]
    held_by_model = tuple(effect for effect in effects if not effect.stepped)
    variant = compiled(hypothesis.spec_at(point), held_by_model, hypothesis.robot)
    stride = max(1, int(1.0 / HERTZ / float(np.median(np.diff(episode.time)))))
    time = episode.time[::stride]
    measurement, pose = episode.measurement, episode.position[::stride].copy()
    space = measurement.coordinates
    for at, dof in zip(space.straight, space.dof, strict=True):
        pose[:, at] = unsensed(variant.effects, measurement.channels[dof], pose[:, at])
    sent = all_received(variant.effects, hypothesis.robot, episode.command, episode.step)
    grid = episode.step * np.arange(len(sent))
    command = (
        np.array([np.interp(time, grid, column) for column in sent.T]).reshape(-1, len(time)).T
    )
    velocity = episode.velocity[::stride]
    acceleration = episode.acceleration[::stride]
    links = _links(hypothesis, suspects)
    motion, missing = _forces(
        hypothesis, variant, time, measurement, pose, velocity, acceleration, command, links,
        stiffness=suspects,
    )  # fmt: skip
    result = Needed(episode=episode, time=time, motion=motion, missing=missing)
    smooth_drive = result.smooth(motion.drive)
    missing = missing - (smooth_drive - motion.drive).sum(axis=1)
    for effect in stepped:
        strengths = np.array([getattr(effect, name) for name in effect.strengths])
        missing = missing - result.smooth(effect.regressor(motion) @ strengths)
    smooth_rate = result.smooth(motion.drive_rate)
    motion = replace(motion, drive=smooth_drive, drive_rate=smooth_rate)
    return _within(replace(result, missing=missing, motion=motion))


def _within(result: Needed) -> Needed:
    """Return what lies away from the ends, where smoothing makes up accelerations.

    The filter's padding is felt for about 1.2 periods of its cutoff.
    """
    edge = 1.2 / result.episode.cutoff
    inside = (result.time >= result.time[0] + edge) & (result.time <= result.time[-1] - edge)
    if inside.sum() < FEWEST:
        return result
    whole = result.motion
    motion = replace(
        whole,
        position=whole.position[inside],
        pose=whole.qpos[inside],
        velocity=whole.velocity[inside],
        acceleration=whole.acceleration[inside],
        drive=whole.drive[inside],
        drive_rate=whole.drive_rate[inside],
        moment=whole.moment[inside],
        stiffness=whole.stiffness[inside],
        bodies={name: body.within(inside) for name, body in whole.bodies.items()},
        time=whole.time[inside],
        command=whole.command[inside],
    )
    return replace(result, time=result.time[inside], motion=motion, missing=result.missing[inside])


def _forces(
    hypothesis: Hypothesis,
    variant: Variant,
    time: Array,
    measurement: Measurement,
    pose: Array,
    velocity: Array,
    acceleration: Array,
    command: Array,
    links: list[str],
    *,
    stiffness: bool,
) -> tuple[Motion, Array]:
    model = variant.model
    data = mujoco.MjData(model)
    flags = model.opt.disableflags
    model.opt.disableflags = flags | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT.value
    samples, dofs = velocity.shape
    rate = np.gradient(command, time, axis=0) if command.shape[1] else command
    need, stiff = np.zeros((samples, dofs)), np.zeros((samples, dofs, dofs))
    drive, drive_rate, moment = np.zeros((3, samples, model.nu, dofs))

    def inverse() -> Array:
        mujoco.mj_inverse(model, data)
        mujoco.mj_fwdActuation(model, data)
        return np.asarray(data.qfrc_inverse - data.qfrc_actuator)

    with flowing(model):
        for k in range(samples):
            data.qpos[:], data.qvel[:], data.qacc[:] = pose[k], velocity[k], acceleration[k]
            data.ctrl[:] = command[k]
            need[k] = inverse()
            moment[k] = actuator_moments(model, data)
            drive[k] = moment[k] * data.actuator_force[:, None]
            gain = model.actuator_gainprm[:, 0]
            drive_rate[k] = moment[k] * (gain * rate[k])[:, None]
            for dof, axis in enumerate(np.eye(dofs) if stiffness else ()):
                mujoco.mj_integratePos(model, data.qpos, axis, NUDGE)
                stiff[k, :, dof] = (inverse() - need[k]) / NUDGE
                data.qpos[:] = pose[k]
    model.opt.disableflags = flags
    joints = {joint.name: model.joint(joint.name).dofadr[0] for joint in hypothesis.robot.joints}
    # Friction loss is a constraint, left out of the inverse dynamics above.
    for effect_dof in range(dofs):
        level = float(model.dof_frictionloss[effect_dof])
        if level > 0.0:
            speed = velocity[:, effect_dof]
            slow = 0.02 * float(np.sqrt(np.mean(speed**2))) + 1e-9
            need[:, effect_dof] += level * np.clip(speed / slow, -1.0, 1.0)
    motion = Motion(
        position=measurement.scalars(pose),
        pose=pose,
        velocity=velocity,
        acceleration=acceleration,
        drive=drive,
        drive_rate=drive_rate,
        stiffness=stiff,
        joints=joints,
        actuators={a.name: i for i, a in enumerate(hypothesis.robot.actuators)},
        bodies=body_motions(model, links, pose, velocity, acceleration) if links else {},
        time=time,
        command=command,
        driven={a.name: a.joint for a in hypothesis.robot.actuators},
        moment=moment / np.array([strength(model, at) for at in range(model.nu)])[:, None],
        servo=-(model.actuator_gear[:, :1] ** 2) * model.actuator_biasprm[:, 1:3],
        armature=model.dof_armature.copy(),
    )
    return motion, need


def _links(hypothesis: Hypothesis, suspects: bool) -> list[str]:
    """Return the links on which some effect acts or, among suspects, may act."""
    names = {effect.where for effect in hypothesis.effects if effect.kind == "body"}
    if suspects:
        bodies = [kind for kind in EFFECTS if kind.kind == "body"]
        names |= {place for kind in bodies for place in kind.suspects(hypothesis.robot)}
    return sorted(names)


def all_needed(
    hypothesis: Hypothesis, point: Array, episodes: Sequence[Episode], *, suspects: bool = True
) -> tuple[Needed, ...]:
    """Return `needed` of every episode."""
    return tuple(needed(hypothesis, point, each, suspects=suspects) for each in episodes)
