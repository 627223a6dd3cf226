"""One robot under a tuple of effects, ready to run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.errors import SimulationFailed
from morph.physics.effect import Effect
from morph.record.recording import Channel, Recording
from morph.sim.drive import received, sensed
from morph.sim.rollout import Variant, rollout

Command = float | Channel | Callable[[Array], Array]
"""A constant, a recorded command, or a function of times (steps,) to values (steps,)."""


def compiled(spec: Any, effects: tuple[Effect, ...], robot: Robot) -> Variant:
    """Return a variant: the spec with every effect's edit, compiled.

    Raises:
        SimulationFailed: MuJoCo refuses the edited description.
    """
    for effect in effects:
        effect.edit(spec)
    try:
        return Variant(model=spec.compile(), effects=effects)
    except ValueError as error:
        raise SimulationFailed(
            f"MuJoCo refuses the description under these effects: {error}",
            where=f"robot {robot.name}",
            fix="check the effects' parameters against the robot's masses",
        ) from error


class Simulator:
    """A robot under effects.

    Args:
        robot: The body.
        effects: What acts on it beyond its description.
        step: Seconds a step; the effects' own limits allow 0.5 to 5 ms.

    Raises:
        SimulationFailed: An effect names a part that the robot does not have, the step is
            out of range, or MuJoCo refuses the body under these effects.
    """

    def __init__(
        self, robot: Robot, effects: tuple[Effect, ...] = (), *, step: float = 0.002
    ) -> None:
        """Check that every effect has its part, and compile."""
        for effect in effects:
            if effect.where not in effect.places(robot):
                raise SimulationFailed(
                    f"{effect.name} acts on one of {', '.join(effect.places(robot))}; "
                    f"there is no {effect.kind} {effect.where!r}",
                    where=f"robot {robot.name}",
                    fix="name a part of this robot",
                )
        if not 1e-6 <= step <= 1.0:
            raise SimulationFailed(
                f"a step of {step} s is out of range, 1e-6 to 1",
                where=f"robot {robot.name}",
                fix="take 0.002 s, or less where the simulation is stiff",
            )
        self.robot, self.effects, self.step = robot, effects, step
        self._variant = compiled(spec_of(robot, timestep=step), effects, robot)

    @property
    def model(self) -> mujoco.MjModel:
        """The compiled model, every effect's edit applied."""
        return self._variant.model

    def run(
        self,
        *,
        seconds: float,
        start: Mapping[str, float] | None = None,
        speed: Mapping[str, float] | None = None,
        command: Mapping[str, Command] | None = None,
        name: str = "simulated",
    ) -> Recording:
        """Return a recording of one run: positions, velocities and commands.

        Args:
            seconds: How long to run.
            start: Position of joints by name, rad or m; others at the description's.
            speed: Velocity of joints by name, per s; others at rest.
            command: What each actuator is told; others zero.
            name: What to call the recording.

        Raises:
            RobotError: A name is not the robot's.
            SimulationFailed: The simulation became unstable, or what it is told is no
                number.
        """
        if not 0.0 < seconds < 1e6:
            raise SimulationFailed(
                f"a run of {seconds} s is out of range, above 0 and below 1e6",
                where=f"robot {self.robot.name}",
                fix="give the seconds to run",
            )
        model: Any = self.model
        steps = max(1, round(seconds / self.step))
        times: Array = np.asarray(self.step * np.arange(steps + 1), dtype=float)
        position, velocity = model.qpos0.copy(), np.zeros(model.nv)
        for joint, value in (start or {}).items():
            position[model.joint(self.robot.joint(joint).name).qposadr[0]] = value
        for joint, value in (speed or {}).items():
            velocity[model.joint(self.robot.joint(joint).name).dofadr[0]] = value
        control = np.zeros((1, steps, model.nu))
        channels = {}
        for actuator, told in (command or {}).items():
            index = model.actuator(self.robot.actuator(actuator).name).id
            values = self._told(actuator, told, times[:-1])
            control[0, :, index] = received(self.effects, actuator, values, self.step)
            channels[f"{actuator}.command"] = Channel(time=times[:-1], value=values, hold=True)
        q, v = rollout(
            [self._variant],
            np.zeros(1, dtype=int),
            position[None],
            velocity[None],
            control,
            strict=True,
        )
        for moving in self.robot.joints:
            if moving.kind in {"hinge", "slide"}:
                for quantity, values in (
                    ("position", q[0, :, model.joint(moving.name).qposadr[0]]),
                    ("velocity", v[0, :, model.joint(moving.name).dofadr[0]]),
                ):
                    channel = f"{moving.name}.{quantity}"
                    reading = sensed(self.effects, channel, values)
                    channels[channel] = Channel(time=times, value=reading)
        return Recording(name=name, channels=channels)

    def _told(self, actuator: str, command: Command, times: Array) -> Array:
        if isinstance(command, Channel):
            values = command.at(times)
        elif callable(command):
            values = np.asarray(command(times), dtype=float)
        else:
            values = np.full(len(times), float(command))
        if values.shape != times.shape or not np.isfinite(values).all():
            raise SimulationFailed(
                f"its command is not one finite number for each of {len(times)} steps",
                where=f"robot {self.robot.name}, actuator {actuator}",
                fix="give a number, a channel, or a function of times (steps,) to (steps,)",
            )
        return values
