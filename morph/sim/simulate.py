"""A simulation in one call."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from morph.body.load import load
from morph.body.robot import Robot
from morph.physics.effect import Effect
from morph.record.recording import Recording
from morph.sim.integrator import Integrator
from morph.sim.simulator import Command, Simulator


def simulate(
    robot: Robot | str | Path,
    effects: Sequence[Effect] = (),
    *,
    seconds: float,
    start: Mapping[str, float] | None = None,
    speed: Mapping[str, float] | None = None,
    command: Mapping[str, Command] | None = None,
    step: float = 0.002,
    integrator: Integrator | None = None,
) -> Recording:
    """Return what a robot does under effects: positions, velocities and commands.

    To run one robot more than once, make a `Simulator` and keep it.

    Args:
        robot: A robot, or whatever `morph.load` takes.
        effects: What acts on it beyond its description.
        seconds: How long to run.
        start: Position of joints by name, rad or m; others at the description's.
        speed: Velocity of joints by name, per s; others at rest.
        command: What each actuator is told: a constant, a recorded channel, or a
            function of times; others zero.
        step: Seconds a step.
        integrator: `implicitfast` or `rk4`; if not given, the better of the two.

    Raises:
        RobotError: There is no such robot, or a name is not the robot's.
        SimulationFailed: An effect has no such part, or the simulation became unstable.
    """
    body = robot if isinstance(robot, Robot) else load(robot)
    # What is told nothing is told zero, and the recording says so.
    told = {actuator.name: 0.0 for actuator in body.actuators} | dict(command or {})
    return Simulator(body, tuple(effects), step=step, integrator=integrator).run(
        seconds=seconds, start=start, speed=speed, command=told
    )
