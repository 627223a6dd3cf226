"""Signs and units of readings that are not those of the description."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.errors import DiagnosisError
from morph.model.episodes import Episode
from morph.model.measurement import Measurement
from morph.physics.dynamics import supplied

TURNED = 1.0
"""By how much the logarithms of the joints' missing forces fall together, and at one of them alone,
where a sign is wrong. With right signs they rose on 61 of 62 simulated robots, and fell by 0.5 at
one joint of the other, an arm with a load."""
SAME = 0.1
"""Of these logarithms, by which a position must do better than a command: a pendulum under a motor
that turns the other way is the mirror image of one with such an encoder."""
DEGREES = math.log(1.5)
"""Their mean fall, beyond that of all accelerations, from which angles are in degrees. It is 0 for
small swings without a drive, at most -3.7 in 240 simulated runs of driven robots, and in degrees at
least this in 235 of them."""
INSTANTS = 2000
"""About how many instants of the runs are looked at."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Instants:
    """Instants of some runs, and the model whose forces explain them or not."""

    model: mujoco.MjModel
    measurement: Measurement
    commands: tuple[str, ...]
    """Channels of the actuators' commands."""
    motion: tuple[Array, ...]
    """Positions, velocities, accelerations and commands, shape (instants, ...) each."""

    @classmethod
    def of(cls, episodes: Sequence[Episode], robot: Robot) -> _Instants:
        every = max(1, sum(len(each.time) for each in episodes) // INSTANTS)
        parts = []
        for e in episodes:
            at = np.minimum(np.rint(e.time / e.step).astype(int), len(e.command) - 1)
            parts.append((e.position, e.velocity, e.acceleration, e.command[at]))
        return cls(
            model=spec_of(robot).compile(),
            measurement=episodes[0].measurement,
            commands=tuple(f"{actuator.name}.command" for actuator in robot.actuators),
            motion=tuple(np.concatenate(part)[::every] for part in zip(*parts, strict=True)),
        )

    def missing(self, factors: Mapping[str, float]) -> Array:
        """Return the logarithm of each joint's RMS missing force, some channels times a factor."""
        position, velocity, acceleration, command = self.motion
        space = self.measurement.coordinates
        joints = np.array([factors.get(name, 1.0) for name in self.measurement.channels])
        places = np.ones(space.positions)
        places[space.straight] = joints[space.dof]
        drives = np.array([factors.get(name, 1.0) for name in self.commands])
        moved = (places * position, joints * velocity, joints * acceleration)
        force = supplied(self.model, *moved, drives * command)
        return np.asarray(0.5 * np.log(np.mean(force**2, axis=0) + 1e-24))


def check_signs(episodes: Sequence[Episode], robot: Robot) -> None:
    """Refuse runs that need far less missing force with the sign of a joint's position turned.

    Raises:
        DiagnosisError: An encoder counts the other way than its joint.
    """
    seen = _Instants.of(episodes, robot)
    turnable = _read(episodes, robot, ("hinge", "slide"))
    if not turnable:
        return
    held = seen.missing({})
    falls = {name: held - seen.missing({name: -1.0}) for name in (*turnable, *seen.commands)}
    wrong = max(falls, key=lambda name: falls[name].sum())
    fall, at = falls[wrong], int(falls[wrong].argmax())
    drives = [falls[name].sum() + SAME for name in seen.commands]
    # A motor that turns the other way is a finding: it has a gain of -1.
    if fall.sum() > max([TURNED, *drives]) and fall[at] > TURNED:
        raise DiagnosisError(
            f"the sign of {wrong} is wrong: with it turned, the force that is missing in "
            f"{seen.measurement.channels[at]} falls to {math.exp(-fall[at]):.1%}",
            where=", ".join(dict.fromkeys(each.name for each in episodes)),
            fix=f"write scale = -1 in the line of {wrong} in recording.toml, or turn the joint's "
            "axis in the description",
        )


def check_units(episodes: Sequence[Episode], robot: Robot) -> None:
    """Refuse runs that need far less missing force, beside all forces, with angles in degrees.

    Raises:
        DiagnosisError: Angles of a run are in degrees.
    """
    degree = math.pi / 180.0
    angles = dict.fromkeys(_read(episodes, robot, ("hinge",)), degree)
    if not angles:
        return
    for name in dict.fromkeys(each.name for each in episodes):
        seen = _Instants.of([each for each in episodes if each.name == name], robot)
        turn = [seen.measurement.channels.index(channel) for channel in angles]
        fall = float(np.mean((seen.missing({}) - seen.missing(angles))[turn]))
        # Forces of inertia fall by 57 with the angles, whatever their unit.
        if fall + math.log(degree) > DEGREES:
            raise DiagnosisError(
                "angles are in degrees: as radians they need "
                f"{math.exp(fall + math.log(degree)):.2g} times the missing force, over all forces",
                where=f"recording {name}",
                fix="write a recording.toml that binds every column with its unit: "
                + ", ".join(f'"{c}" = {{ column = "{c}", unit = "deg" }}' for c in angles),
            )


def _read(episodes: Sequence[Episode], robot: Robot, kinds: Sequence[str]) -> list[str]:
    """Return the channels of joints of some kinds whose positions are no guesses in any run."""
    names = episodes[0].measurement.channels
    guessed = np.any([each.guess > 0.0 for each in episodes], axis=0)
    given = [f"{joint.name}.position" for joint in robot.joints if joint.kind in kinds]
    return [name for name in given if not guessed[names.index(name)]]
