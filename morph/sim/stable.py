"""As much of a run as was stable."""

from __future__ import annotations

from collections.abc import Mapping

from morph.errors import SimulationFailed
from morph.sim.simulator import Command, Simulator, Trajectory


def as_far_as_stable(
    simulator: Simulator,
    *,
    seconds: float,
    start: Mapping[str, float] | None = None,
    speed: Mapping[str, float] | None = None,
    command: Mapping[str, Command] | None = None,
) -> tuple[Trajectory, SimulationFailed | None]:
    """Return a run, and why it ended early if it did: all steps before an unstable one.

    The arguments are those of `Simulator.run`.

    Raises:
        RobotError: A name is not the robot's.
        SimulationFailed: Not even the first step can be made, or the run is too long to keep.
    """
    # What is no time to run is no instability, and would be searched for one in vain.
    steps = simulator.steps(seconds)

    def moved(steps: int) -> Trajectory:
        return simulator.trajectory(
            seconds=steps * simulator.step, start=start, speed=speed, command=command
        )

    try:
        return simulator.trajectory(
            seconds=seconds, start=start, speed=speed, command=command
        ), None
    except SimulationFailed as error:
        why = error
        # What is wrong from the beginning, such as a command that is no number, is told as it is.
        best = moved(1)
    # A simulation repeats itself to the last bit, so halving finds the step at which it failed.
    good, bad = 1, steps
    while bad - good > 1:
        middle = (good + bad) // 2
        try:
            best, good = moved(middle), middle
        except SimulationFailed:
            bad = middle
    return best, why
