"""Probabilistic differential dynamic programming: a trajectory with feedback, on beliefs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from morph.arrays import Array
from morph.errors import SearchError
from morph.model.gp.gp import GaussianProcess
from morph.policy.bound import limits
from morph.policy.policy import Policy
from morph.policy.track import Track
from morph.search.gp_rollout.memory import Memory
from morph.search.gp_rollout.plant import BeliefPlant, Beliefs, belief_plant
from morph.search.gp_rollout.search import BeliefSearch, Improved
from morph.search.gp_rollout.seeds import seeds
from morph.search.gp_rollout.task import TaskSums
from morph.search.trajectory.backward import FeedbackLaw, backward

LENGTHS = np.array([1.0, 0.5, 0.2, 0.05])
"""Shares of the change that are tried, all at once."""

MOST_DAMPING = 1e2
"""Damping at which a trajectory counts as arrived."""


@dataclass(frozen=True, kw_only=True)
class Pddp(BeliefSearch):
    """Dynamic programming on mean and covariance of the state, with bounded commands.

    Source: Pan and Theodorou 2014, Probabilistic Differential Dynamic Programming, NIPS,
    algorithm 1; bounds as in Tassa, Mansard and Todorov 2014, ICRA.
    """

    name: ClassVar[str] = "pddp"
    kind = Track

    steps: int = 20
    """Most improvements of a trajectory, at each width."""
    widths: tuple[float, ...] = (4.0, 2.0, 1.0)
    """By what the costs are widened, in turn: wide ones are felt from far off."""
    samples: int = 2000
    """Command sequences by chance that are tried on the mean before."""
    starts: int = 2
    """Trajectories that are improved, besides the one before; the best is taken."""
    margin: float = 0.15
    """Share of the commands' range that a plan leaves to its feedback."""
    effort: float = 0.01
    """What a command at its bound costs, a sample."""
    enough: float = 1e-3
    """Improvement, as a share of the cost, that counts as none."""

    def __post_init__(self) -> None:
        """Check the settings."""
        super().__post_init__()
        if min(self.steps, self.samples, self.starts) < 1 or not 0.0 < self.effort < 10.0:
            raise SearchError(
                f"it would make {self.steps} steps from {self.starts} of {self.samples} starts, "
                f"with an effort of {self.effort:g}",
                where=f"search {self.name}",
                fix="give 1 or more of each, and an effort such as 0.01",
            )

    def improved(
        self, view: TaskSums, process: GaussianProcess, memory: Memory, rng: np.random.Generator
    ) -> Improved:
        """Return the trajectory of the least expected cost that was found."""
        plant = belief_plant(view, process, self.effort)
        bounds = limits(view.action, self.margin)
        commands = list(seeds(plant, process, bounds, self.samples, self.starts, rng))
        if memory.numbers is not None:
            commands.append(memory.numbers.reshape(view.task.samples - 1, -1))
        results = [self._descended(plant, command, bounds) for command in commands]
        best = min(results, key=lambda each: float(each.cost[0]))
        return Improved(
            policy=_policy(view, best),
            numbers=best.command[0].ravel(),
            expected=float(best.cost[0]),
        )

    def _descended(
        self, plant: BeliefPlant, command: Array, bounds: tuple[Array, Array]
    ) -> Beliefs:
        """Return the trajectory that improving a sequence of commands ends at."""
        now = begun(plant, np.clip(command, *bounds))
        for width in self.widths:
            wide = plant.widened(width)
            cost = wide.costs(now.mean, now.covariance, now.command)
            now = self._improved(wide, replace(now, cost=cost), bounds)
        return replace(now, cost=plant.costs(now.mean, now.covariance, now.command))

    def _improved(self, plant: BeliefPlant, now: Beliefs, bounds: tuple[Array, Array]) -> Beliefs:
        low, high = bounds
        damping = 1e-3
        for _ in range(self.steps):
            A, B = plant.slopes(now)
            pressure = damping / (0.5 * (high - low))[None] ** 2
            law = backward(
                A, B, plant.quadratic(now), low - now.command, high - now.command, pressure
            )
            tried = followed(plant, now, law, low, high)
            fell = float(now.cost[0] - tried.cost[0])
            if fell > 0.0:
                now, damping = tried, max(damping * 0.3, 1e-6)
                if fell < self.enough * float(now.cost[0]):
                    break
            else:
                damping *= 10.0
                if damping > MOST_DAMPING:
                    break
        return now


def begun(plant: BeliefPlant, command: Array) -> Beliefs:
    """Return what is believed under commands without feedback, as one row."""
    m, S = plant.view.start
    d, (periods, size) = len(m), command.shape
    empty = Beliefs(
        mean=np.zeros((1, periods + 1, d)),
        covariance=np.zeros((1, periods + 1, d, d)),
        command=command[None],
        gain=np.zeros((1, periods, size, d)),
        cost=np.zeros(1),
    )
    law = FeedbackLaw(
        change=np.zeros((1, periods, size)),
        gain=np.zeros((1, periods, size, d + len(plant.upper[0]))),
        promised=np.zeros(1),
    )
    return _run(plant, empty, law, np.zeros(1), np.array([-np.inf]), np.array([np.inf]), m, S)


def followed(
    plant: BeliefPlant, now: Beliefs, law: FeedbackLaw, low: Array, high: Array
) -> Beliefs:
    """Return the best of all lengths, as one row."""
    m, S = plant.view.start
    tried = _run(plant, now, law, LENGTHS, low, high, m, S)
    cost = np.where(np.isfinite(tried.cost), tried.cost, np.inf)
    return tried.row(int(cost.argmin()))


def _run(
    plant: BeliefPlant,
    now: Beliefs,
    law: FeedbackLaw,
    length: Array,
    low: Array,
    high: Array,
    m: Array,
    S: Array,
) -> Beliefs:
    """Return rows of beliefs, one for each length, under a law about one row."""
    rows, periods, d = len(length), now.command.shape[1], len(m)
    mean, covariance = np.empty((rows, periods + 1, d)), np.empty((rows, periods + 1, d, d))
    command = np.empty((rows, *now.command.shape[1:]))
    mean[:, 0], covariance[:, 0] = m, S
    gain = np.repeat(law.gain[:, :, :, :d], rows, axis=0)
    least, most = plant.view.bounds
    for at in range(periods):
        off = plant.vector(mean[:, at], covariance[:, at]) - plant.vector(
            now.mean[:, at], now.covariance[:, at]
        )
        wanted = now.command[:, at] + length[:, None] * law.change[:, at]
        command[:, at] = np.clip(wanted + off @ law.gain[0, at].T, low, high)
        room = np.minimum(command[:, at] - least, most - command[:, at])
        gain[:, at] *= plant.felt(covariance[:, at], gain[:, at], room)[..., None]
        mean[:, at + 1], covariance[:, at + 1] = plant.after(
            mean[:, at], covariance[:, at], command[:, at], gain[:, at]
        )
    cost = plant.costs(mean, covariance, command)
    return Beliefs(mean=mean, covariance=covariance, command=command, gain=gain, cost=cost)


def _policy(view: TaskSums, beliefs: Beliefs) -> Policy:
    # The last knot is held after the horizon, with its gain.
    return Track(
        nominal=beliefs.mean[0, :-1],
        command=beliefs.command[0],
        gain=beliefs.gain[0],
        angles=view.angles,
        action=view.action,
        period=view.task.period,
        observation=view.observation,
    )
