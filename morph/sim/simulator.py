"""One robot under a tuple of effects, ready to run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.errors import SimulationFailed
from morph.physics.apply import apply
from morph.physics.effect import Effect
from morph.physics.fluid.settle import settle
from morph.record.recording import Channel, Recording
from morph.sim.drive import received, sensed, stamped
from morph.sim.integrator import INTEGRATORS, Integrator, best_integrator
from morph.sim.observe import observed
from morph.sim.rollout import Variant, rollout
from morph.sim.start import started

Command = float | Channel | Callable[[Array], Array]
"""A constant, a recorded command, or a function of times (steps,) to values (steps,)."""


LONGEST = 1e6
"""Seconds that a run must be shorter than."""

MOST_NUMBERS = 2e8
"""Most numbers that the states and commands of a run may hold; 1.6 GB."""


@dataclass(frozen=True, kw_only=True)
class Trajectory:
    """Every state of one run, in MuJoCo's own coordinates."""

    time: Array
    """Seconds, shape (steps + 1,)."""
    position: Array
    """MuJoCo's `qpos`, shape (steps + 1, nq)."""
    velocity: Array
    """MuJoCo's `qvel`, shape (steps + 1, nv)."""
    command: Mapping[str, Array]
    """What each actuator was told that was told anything, shape (steps,)."""


MOST_SHOWN = 12
"""Places that an error lists before it counts the rest."""


def compiled(spec: Any, effects: tuple[Effect, ...], robot: Robot) -> Variant:
    """Return a variant: the spec with every effect's edit, compiled.

    Raises:
        SimulationFailed: MuJoCo refuses the edited description.
    """
    apply(spec, effects)
    try:
        return Variant(model=settle(spec.compile()), effects=effects)
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
        step: Seconds a step, from 1e-6 to 1; 0.5 to 5 ms suit most bodies.
        integrator: `implicitfast` for contacts and stiff joints, or `rk4` for bodies that move
            freely; if not given, the better of the two (`best_integrator`).

    Raises:
        SimulationFailed: An effect names a part that the robot does not have, the step is
            out of range, there is no such integrator, or MuJoCo refuses the body under these
            effects.
    """

    def __init__(
        self,
        robot: Robot,
        effects: tuple[Effect, ...] = (),
        *,
        step: float = 0.002,
        integrator: Integrator | None = None,
    ) -> None:
        """Check that every effect has its part, and compile."""
        for effect in effects:
            places = effect.places(robot)
            if effect.where not in places:
                more = f" and {len(places) - MOST_SHOWN} more" if len(places) > MOST_SHOWN else ""
                raise SimulationFailed(
                    f"{effect.name} acts on one of {', '.join(places[:MOST_SHOWN])}{more}; "
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
        if integrator is not None and integrator not in INTEGRATORS:
            raise SimulationFailed(
                f"there is no integrator {integrator!r}; there are {', '.join(INTEGRATORS)}",
                where=f"robot {robot.name}",
                fix="name one of these, or none to have the better of the two",
            )
        self.robot, self.effects, self.step = robot, effects, step
        self._variant = compiled(spec_of(robot, timestep=step), effects, robot)
        self.integrator: Integrator = integrator or best_integrator(self._variant.model)
        self._variant.model.opt.integrator = INTEGRATORS[self.integrator]

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

        A body that floats has `hull.position.x` and so on; a gyro, an accelerometer or a
        force sensor of the description has `imu.gyro.x` and so on, by the name of its site.

        Args:
            seconds: How long to run.
            start: Position of joints by name, rad or m, and of a floating body by
                `hull.position.z` or `hull.orientation.w`; others at the description's.
            speed: Velocity of joints by name, per s, and of a floating body by
                `hull.linear_velocity.x` or `hull.angular_velocity.z`; others at rest.
            command: What each actuator is told; others zero.
            name: What to call the recording.

        Raises:
            RobotError: A name is not the robot's.
            SimulationFailed: The simulation became unstable, or what it is told is no
                number.
        """
        moved = self.trajectory(seconds=seconds, start=start, speed=speed, command=command)
        return self.recorded(moved, name)

    def steps(self, seconds: float) -> int:
        """Return how many steps a run of so many seconds takes, at least one.

        Raises:
            SimulationFailed: It is no time to run, or its states would fill the memory.
        """
        if not 0.0 < seconds < LONGEST:
            raise SimulationFailed(
                f"a run of {seconds} s is out of range, above 0 and below 1e6",
                where=f"robot {self.robot.name}",
                fix="give the seconds to run",
            )
        steps = max(1, round(seconds / self.step))
        numbers = steps * (self.model.nq + self.model.nv + self.model.nu)
        if numbers > MOST_NUMBERS:
            raise SimulationFailed(
                f"a run of {steps:.3g} steps holds {numbers:.2g} numbers, above {MOST_NUMBERS:.2g}",
                where=f"robot {self.robot.name}",
                fix="make shorter runs, each from where the last one ended, or larger steps",
            )
        return steps

    def trajectory(
        self,
        *,
        seconds: float,
        start: Mapping[str, float] | None = None,
        speed: Mapping[str, float] | None = None,
        command: Mapping[str, Command] | None = None,
    ) -> Trajectory:
        """Return every state of one run, to be drawn or recorded; `run` says what it takes.

        Raises:
            RobotError: A name is not the robot's.
            SimulationFailed: The simulation became unstable, or what it is told is no
                number.
        """
        model: Any = self.model
        steps = self.steps(seconds)
        times: Array = np.asarray(self.step * np.arange(steps + 1), dtype=float)
        position, velocity = started(self.robot, model, start, speed)
        control = np.zeros((1, steps, model.nu))
        known: dict[str, Array] = {}
        for actuator, what in (command or {}).items():
            index = model.actuator(self.robot.actuator(actuator).name).id
            known[actuator] = self._told(actuator, what, times[:-1])
            control[0, :, index] = received(self.effects, actuator, known[actuator], self.step)
        q, v = rollout(
            [self._variant],
            np.zeros(1, dtype=int),
            position[None],
            velocity[None],
            control,
            strict=True,
        )
        return Trajectory(time=times, position=q[0], velocity=v[0], command=known)

    def recorded(self, moved: Trajectory, name: str = "simulated") -> Recording:
        """Return a motion as a recording, seen through the effects' sensors.

        A semi-implicit step is a leapfrog: its force carries the velocity from half a step before
        its time to half a step after, so commands are stamped half a step before they are given.
        Source: Hairer, Lubich and Wanner 2003, Acta Numerica 12, 399-450, section 1.
        """
        early = 0.5 * self.step if self.integrator == "implicitfast" else 0.0
        given = np.maximum(moved.time[:-1] - early, 0.0)
        channels = {
            f"{actuator}.command": Channel(time=given, value=values, hold=True)
            for actuator, values in moved.command.items()
        }
        for channel, true in observed(
            self.robot, self.model, moved.time, moved.position, moved.velocity
        ).items():
            reading = sensed(self.effects, channel, true.value)
            time = stamped(self.effects, channel, true.time)
            channels[channel] = Channel(time=time, value=reading)
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
