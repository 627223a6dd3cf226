"""A policy's parameters changed directly, by trials on the target alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.errors import TransferError
from morph.policy.adjusted import Adjusted, newest
from morph.policy.angles import turning
from morph.policy.policy import LARGEST, Policy
from morph.search.search import Learned, Trial
from morph.search.target import Experience, Target
from morph.task.task import Task


@dataclass(frozen=True, kw_only=True)
class DirectAdjustment:
    """A law b + W z added to a policy, its numbers found by CMA-ES on so many trials.

    It is the alternative of thesis section 3.3 to adjusting: no model, no inverse dynamics, and
    for each of its few numbers several trials.
    """

    spread: float = 0.15
    """Standard deviation of each number at first: what it adds where its feature is as great as
    in the first run, in halves of the command's range."""
    population: int = 6
    """Trials of a generation."""

    def __post_init__(self) -> None:
        """Check the settings."""
        if not (0.0 < self.spread <= 1.0 and self.population >= 4):
            raise TransferError(
                f"its spread is {self.spread:g} and its population {self.population}",
                where="changing a policy directly",
                fix="give a spread of above 0 to 1, and a population of 4 or more",
            )

    def tune(
        self, task: Task, policy: Policy, target: Target, *, trials: int, seed: int
    ) -> Learned:
        """Return the law that cost least, after the policy as it is was tried first.

        Raises:
            TransferError: There are fewer trials than two.
        """
        from cmaes import CMA

        if trials < 2:
            raise TransferError(
                f"it is given {trials} trials",
                where="changing a policy directly",
                fix="give 2 or more: one of the policy as it is, and one of another",
            )
        rng = np.random.default_rng(seed)
        shown = [target.trial(policy, rng)]
        best, least = policy, shown[0].loss
        lines = [_line(1, shown, least)]
        unit = _units(task, policy, shown[0])
        cma = CMA(
            mean=np.zeros(unit.size),
            sigma=self.spread,
            population_size=self.population,
            seed=seed,
        )
        command: list[tuple[Array, float]] = []
        while len(shown) < trials:
            point = np.asarray(cma.ask())
            tried = with_law(task, policy, point.reshape(unit.shape) * unit)
            shown.append(target.trial(tried, rng))
            command.append((point, shown[-1].loss))
            if shown[-1].loss < least:
                best, least = tried, shown[-1].loss
            lines.append(_line(len(shown), shown, least))
            if len(command) == self.population:
                cma.tell(command)
                command = []
        succeeded = min(shown, key=lambda each: each.loss).success
        return Learned(
            policy=best,
            trials=tuple(lines),
            succeeded=succeeded,
            why="" if succeeded else f"none of {trials} trials that cost less succeeded",
            experience=tuple(shown),
        )


def with_law(task: Task, policy: Policy, law: Array) -> Adjusted:
    """Return a policy to whose commands a law is added.

    Args:
        task: Whose body it commands.
        policy: What the law is added to.
        law: b and then W, shape (actions, 1 + features + actions), as `Adjusted` takes them.
    """
    angles = turning(task.robot, policy.observation)
    inputs, actions = law.shape[1] - 1, law.shape[0]
    return Adjusted(
        source=policy,
        bias=law[:, 0],
        law=law[:, 1:],
        centre=np.zeros((1, inputs)),
        width=np.ones((actions, inputs)),
        weight=np.zeros((actions, 1)),
        reach=np.full(inputs, LARGEST),
        angles=angles,
        action=policy.action,
        period=policy.period,
        observation=policy.observation,
    )


def _units(task: Task, policy: Policy, run: Experience) -> Array:
    """Return what 1 is for each number of the law: half the range, where its feature is great."""
    angles = turning(task.robot, policy.observation)
    half = np.array([0.5 * (each.high - each.low) for each in policy.action])
    now = newest(policy.observation)
    angles = angles[now]
    most = np.abs(np.concatenate([run.position, run.velocity], axis=1)).max(axis=0)
    if len(most) != len(now):
        # A choice of channels: no feature is greater than what moves most.
        most = np.full(len(now), most.max())
    plain = np.maximum(most[angles == 0.0], 1e-3)
    size = np.concatenate([[1.0], plain, np.ones(2 * int(angles.sum())), half])
    return np.asarray(half[:, None] / size)


def _line(number: int, shown: Sequence[Experience], least: float) -> Trial:
    best = min(shown, key=lambda each: each.loss)
    return Trial(
        number=number,
        loss=least,
        success=float(best.success),
        seconds=0.0,
        experience=sum(each.seconds for each in shown),
    )
