"""What the motors of a body need, as it was designed and as it was printed, beside their limits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from morph.arrays import Array
from morph.body.holding import Holding
from morph.body.poses import drawn
from morph.body.posture import Posture
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.fabrication.rematch import Matched
from morph.policy.policy import Policy
from morph.search.evaluate import attempt
from morph.task.task import Task

RUNS = 8
"""Noisy runs along which the policy's efforts are looked at."""

RUNNING = 2**31 - 6
"""Names the chance of these runs."""


@dataclass(frozen=True, kw_only=True)
class Margin:
    """One motor's greatest efforts, N m or N."""

    actuator: str
    """Its name."""
    joint: str
    """The joint that it drives."""
    unit: str
    """`N m` or `N`."""
    limit: float | None
    """Greatest effort that it has; None if none is known."""
    designed: float
    """Greatest effort to hold the designed body still in any pose, its base held, in air."""
    printed: float
    """The same of the printed body."""
    run_designed: float | None = None
    """Greatest effort along runs of the policy as it was learned, on the designed body; None
    without a policy."""
    run_printed: float | None = None
    """The same of the policy that was matched, on the printed body."""

    @property
    def needed(self) -> float:
        """Greatest effort that the printed body needs, held still or along its runs."""
        return max(self.printed, self.run_printed or 0.0)

    @property
    def left(self) -> float | None:
        """Share of the limit that is left to the printed body held still; below 0 it sags."""
        return None if not self.limit else 1.0 - self.printed / self.limit


def margins(
    designed: Robot,
    printed: Robot,
    *,
    learned: tuple[Policy, Task] | None = None,
    matched: Matched | tuple[Policy, Task] | None = None,
    seed: int = 0,
) -> tuple[Margin, ...]:
    """Return a margin for every motor of a hinge or slide, in the order of the robot.

    Both bodies are held in the same poses: at rest and in 200 drawn over all ranges.

    Args:
        designed: The body as it was designed.
        printed: The same with the masses that its parts have.
        learned: The policy as it was learned, and its task on the designed body.
        matched: What became of it on the printed body: the policy there, and its task.
        seed: Of the noise of the runs.

    Raises:
        SimulationFailed: A body cannot be simulated.
    """
    before, after = _held(designed), _held(printed)
    ran = {} if learned is None else _ran(*learned, seed)
    now = (matched.policy, matched.task) if isinstance(matched, Matched) else matched
    runs = {} if now is None else _ran(*now, seed)
    return tuple(
        Margin(
            actuator=motor.name,
            joint=motor.joint,
            unit=motor.unit,
            limit=motor.limit,
            designed=before[motor.name],
            printed=after.get(motor.name, 0.0),
            run_designed=ran.get(motor.name),
            run_printed=runs.get(motor.name),
        )
        for motor in _holding(designed)[0].motors
    )


def _holding(robot: Robot) -> tuple[Holding, Posture]:
    posture = Posture(spec_of(robot).compile())
    return Holding(robot, posture), posture


def _held(robot: Robot) -> dict[str, float]:
    """Return the greatest effort of each motor over the poses of a body, by its name."""
    holding, posture = _holding(robot)
    if not holding.motors:
        return {}
    efforts = np.abs([holding.at(pose) for pose in drawn(posture)]).max(axis=0)
    return {
        motor.name: float(effort) for motor, effort in zip(holding.motors, efforts, strict=True)
    }


def _ran(policy: Policy, task: Task, seed: int) -> dict[str, float]:
    """Return the greatest effort of each motor at the control times of some runs, by its name."""
    simulator = task.simulator()
    rng = np.random.default_rng([seed, RUNNING])
    moved = attempt(task, policy, simulator, rows=RUNS, rng=rng)
    model: Any = simulator.model
    flat = [
        each.reshape(-1, each.shape[-1]) for each in (moved.position, moved.velocity, moved.command)
    ]
    result = np.abs(_efforts(model, *flat)).max(axis=0)
    return {str(model.actuator(at).name): float(result[at]) for at in range(model.nu)}


def _efforts(model: Any, position: Array, velocity: Array, command: Array) -> Array:
    """Return what each actuator gives at its joint, N m or N, shape (states, nu)."""
    import mujoco

    data = mujoco.MjData(model)
    result = np.empty((len(position), model.nu))
    gear = model.actuator_gear[:, 0]
    states = np.concatenate([position, velocity], axis=1)
    fine = np.asarray(np.isfinite(states).all(axis=1))
    for at in range(len(position)):
        if not fine[at]:
            result[at] = 0.0
            continue
        data.qpos[:], data.qvel[:], data.ctrl[:] = position[at], velocity[at], command[at]
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        mujoco.mj_fwdActuation(model, data)
        result[at] = data.actuator_force * gear
    return result
