"""Closed-loop rollout of a policy, as far as it is stable."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from morph.arrays import Array
from morph.errors import SimulationFailed
from morph.policy.observing import Observer
from morph.policy.policy import Policy
from morph.sim.closed_loop import ClosedLoopRuns, closed_loop
from morph.sim.simulator import Simulator, Trajectory
from morph.sim.start import started


def driven(
    simulator: Simulator,
    policy: Policy,
    *,
    seconds: float,
    start: Mapping[str, float] | None = None,
    speed: Mapping[str, float] | None = None,
    command: Mapping[str, float] | None = None,
    state: tuple[Array, Array] | None = None,
) -> tuple[Trajectory, SimulationFailed | None]:
    """Return a run under a policy that observes, and why it ended early if it did.

    It sees the true state: a simulation at the terminal draws nothing by chance.

    Args:
        simulator: The body under its effects.
        policy: What commands it.
        seconds: How long to run.
        start: Where it starts, as `Simulator.run` takes it.
        speed: How fast.
        command: What single actuators are told all along, whatever the policy says.
        state: MuJoCo's `qpos` and `qvel` at the start, instead of `start` and `speed`.

    Raises:
        RobotError: A name is not the robot's.
        SimulationFailed: Not even the first step can be made, or the run is too long to keep.
        PolicyError: The body lacks what the policy observes.
    """
    robot, model = simulator.robot, simulator.model
    position, velocity = started(robot, model, start, speed) if state is None else state
    steps = simulator.steps(seconds)
    fixed = {
        [each.name for each in robot.actuators].index(robot.actuator(name).name): value
        for name, value in (command or {}).items()
    }

    def ran(periods: int) -> ClosedLoopRuns:
        # It remembers what it saw, so each run needs a new one.
        observer = Observer(policy, robot, model, 1, effects=simulator.effects)

        def act(q: Array, v: Array, time: float) -> Array:
            given = np.array(policy.act(observer.see(q, v), np.full(1, time)))
            for at, value in fixed.items():
                given[:, at] = value
            return given

        return closed_loop(
            simulator,
            act,
            position[None],
            velocity[None],
            period=policy.period,
            seconds=periods * policy.period,
            every_step=True,
        )

    periods = max(1, int(np.ceil(steps * simulator.step / policy.period - 1e-9)))
    loop = ran(periods)
    if loop.stable[0]:
        return _moved(loop, simulator, steps), None
    good, bad = 0, periods
    # A simulation repeats itself to the last bit, so halving finds the period in which it failed.
    while bad - good > 1:
        middle = (good + bad) // 2
        part = ran(middle)
        if part.stable[0]:
            loop, good = part, middle
        else:
            bad = middle
    why = SimulationFailed(
        f"the simulation became unstable within {policy.period:g} s after "
        f"{good * policy.period:g} s",
        where=f"robot {robot.name}",
        fix="take a smaller --step, or start it where the policy was made for",
    )
    if not good:
        raise why
    return _moved(loop, simulator, steps), why


def _moved(loop: ClosedLoopRuns, simulator: Simulator, most: int) -> Trajectory:
    """Return a run's states, its last control period cut where the run was to end."""
    steps = min(most, len(loop.time) - 1)
    return Trajectory(
        time=loop.time[: steps + 1],
        position=loop.position[0, : steps + 1],
        velocity=loop.velocity[0, : steps + 1],
        command={
            actuator.name: loop.command[0, :steps, at]
            for at, actuator in enumerate(simulator.robot.actuators)
        },
    )
