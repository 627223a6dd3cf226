"""Internal states of effects where a rollout starts within a recording."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from morph.arrays import Array, Integers
from morph.model.episodes import Episode
from morph.model.hypothesis import Hypothesis
from morph.model.segments import Segments
from morph.physics.drives import Transmission, actuator_forces
from morph.physics.effect import Effect
from morph.physics.motion import Motion
from morph.sim.drive import all_received
from morph.sim.rollout import Variant


def recalled(
    hypothesis: Hypothesis, segments: Segments, variants: Sequence[Variant], which: Integers
) -> dict[int, Array]:
    """Return what effects remember at the start of each segment, by their index.

    Those are left out of which a simulation soon knows it.

    Args:
        hypothesis: The robot.
        segments: Where rollouts start.
        variants: Versions of the robot.
        which: Index of the variant of each row and segment, shape (rows, segments).

    Returns:
        Of each effect an array, shape (..., rows times segments).
    """
    slots = [at for at, each in enumerate(variants[0].effects) if _remembers(each)]
    results: dict[int, Array] = {}
    for number, variant in enumerate(variants if slots else ()):
        for index, episode in enumerate(segments.episodes):
            row, segment = np.nonzero((which == number) & (segments.episode == index))
            motion = _motion(hypothesis, variant, episode)
            for slot in slots:
                state = variant.effects[slot].recalled(motion)[..., segments.first[segment]]
                whole = results.setdefault(slot, np.zeros((*state.shape[:-1], which.size)))
                whole[..., row * which.shape[1] + segment] = state
    return results


def _remembers(effect: Effect) -> bool:
    return type(effect).recalled is not Effect.recalled


def _motion(hypothesis: Hypothesis, variant: Variant, episode: Episode) -> Motion:
    """Return positions, velocities and actuators' forces of an episode at each step."""
    robot, model = hypothesis.robot, variant.model
    time = episode.step * np.arange(len(episode.command), dtype=float)
    state = np.stack([np.interp(time, episode.time, each) for each in episode.state.T], axis=1)
    measurement = episode.measurement
    pose, velocity = np.split(state, [measurement.coordinates.positions], axis=1)
    position = measurement.scalars(pose)
    command = all_received(variant.effects, robot, episode.command, episode.step)
    transmission = Transmission.along(model, pose)
    force = actuator_forces(model, transmission, velocity, command)
    drive = transmission.moment * force[..., None]
    none = np.zeros_like(velocity)
    return Motion(
        pose=pose,
        position=position,
        velocity=velocity,
        acceleration=none,
        drive=drive,
        drive_rate=np.zeros_like(drive),
        stiffness=none,
        joints={joint.name: model.joint(joint.name).dofadr[0] for joint in robot.joints},
        actuators={actuator.name: at for at, actuator in enumerate(robot.actuators)},
        driven={actuator.name: actuator.joint for actuator in robot.actuators},
        moment=transmission.by_effort(model),
        time=time,
        command=command,
    )
