"""One parametric policy for a target, fitted to many trajectories of its source."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from morph.alignment.adjust import Adjustment
from morph.arrays import Array
from morph.errors import TransferError
from morph.policy.adjusted import newest
from morph.policy.angles import turning
from morph.policy.observing import Observer
from morph.policy.policy import Policy
from morph.policy.radial import Radial
from morph.policy_transfer.adjustment.adjust import applied
from morph.policy_transfer.adjustment.adjusted_rollout import Pretended, foreseen, judged
from morph.policy_transfer.adjustment.source import SimulatedTask
from morph.search.evaluate import Score
from morph.search.trajectory.plant import Stepped


@dataclass(frozen=True, kw_only=True)
class Many:
    """How one policy of radial functions is trained on what many trajectories command."""

    units: int = 300
    """Radial functions."""
    rows: int = 40
    """Trajectories of each plan, each from a start and with noise of its own."""
    rounds: int = 4
    """How often the policy runs itself, and is told what the plans would have commanded there."""
    width: float = 1.2
    """Width of the functions, in spreads of the features."""
    ridge: float = 1e-8
    """Price of weights, as a share of the data: wide functions that add up to a steep feedback have
    great weights of both signs."""

    def __post_init__(self) -> None:
        """Check the numbers."""
        if min(self.units, self.rows, self.rounds + 1) < 1 or min(self.width, self.ridge) <= 0.0:
            raise TransferError(
                f"{self.units} units, {self.rows} rows, {self.rounds} rounds, a width of "
                f"{self.width:g} and a ridge of {self.ridge:g}",
                where="a policy from many trajectories",
                fix="give at least 1 unit and row, 0 rounds, and a positive width and ridge",
            )

    def trained(
        self,
        source: SimulatedTask,
        result: Adjustment,
        policies: Sequence[Policy],
        *,
        rng: np.random.Generator,
    ) -> tuple[Radial, Score]:
        """Return the policy that does best in what the target is taken to do, and how.

        Plans of the source run there under the adjustment, from many starts. A radial policy is
        fitted to states and adjusted commands by least squares; then it runs itself, its states
        with what the plans would have commanded at that time join the data, and it is fitted
        again. The best of all rounds is given back.

        Source: Gamboa Higuera 2015, section 3.3, the improved scheme; Ross, Gordon and Bagnell
        2011, AISTATS, algorithm 3.1 (the rounds).

        Args:
            source: Where the plans were made.
            result: The adjustment to the target.
            policies: Plans of the source; the most promising of them under the adjustment, alone.
            rng: Chance.
        """
        stepped = Pretended(source, result, policies[0].observation)
        guides = [applied(result, each) for each in policies]
        shown = [_run(source, stepped, each, each, self.rows, rng) for each in guides]
        x = np.concatenate([each[0] for each in shown])
        u = np.concatenate([each[1] for each in shown])
        tried: list[tuple[Radial, Score]] = []
        while True:
            policy = self._fitted(source, policies[0], x, u, rng)
            score = foreseen(source, stepped, policy, rows=32, rng=rng)
            tried.append((policy, score))
            if len(tried) > self.rounds or score.share == 1.0:
                return min(tried, key=lambda each: judged(each[1]))
            more = [_run(source, stepped, policy, guide, self.rows, rng) for guide in guides]
            x = np.concatenate([x, *(each[0] for each in more)])
            u = np.concatenate([u, *(each[1] for each in more)])

    def _fitted(
        self, source: SimulatedTask, like: Policy, x: Array, u: Array, rng: np.random.Generator
    ) -> Radial:
        """Return radial functions at some of the states, their weights by ridge regression."""
        seen = tuple(replace(each, history=1) for each in like.observation)
        angles = turning(source.task.robot, seen)
        some = rng.choice(len(x), size=min(self.units, len(x)), replace=False)
        count = int((angles == 0.0).sum()) + 2 * int(angles.sum())
        blank = Radial(
            centre=np.zeros((1, count)),
            width=np.ones(count),
            weight=np.zeros((len(like.action), 1)),
            angles=angles,
            action=like.action,
            period=like.period,
            observation=seen,
        )
        z = blank.features(x)
        width = self.width * np.maximum(z.std(axis=0), 1e-3)
        centre = z[some]
        near = np.exp(-0.5 * np.square(z[:, None] / width - centre / width).sum(axis=-1))
        inner = near.T @ near + self.ridge * len(x) * np.eye(near.shape[1])
        weight = np.linalg.solve(inner, near.T @ u)
        return Radial(
            centre=centre,
            width=width,
            weight=weight.T,
            angles=angles,
            action=like.action,
            period=like.period,
            observation=seen,
        )


def _run(
    source: SimulatedTask,
    stepped: Stepped,
    policy: Policy,
    guide: Policy,
    rows: int,
    rng: np.random.Generator,
) -> tuple[Array, Array]:
    """Return the newest that is seen in runs of one policy, and what a guide would command there.

    Shapes (rows * periods, channels) and (rows * periods, actions). The guide may see the past;
    another policy than the guide sees the newest alone.
    """
    task = source.task
    q, v = task.start.sample(task.robot, source.plant.model, rows, rng)
    observer = Observer(guide, task.robot, source.plant.model, rows, rng=rng, noise=task.noise)
    now = newest(guide.observation)
    seen, command = [], []
    for at in range(task.samples - 1):
        time = np.full(rows, at * task.period)
        o = observer.see(q, v)
        fine = np.asarray(np.isfinite(o).all(axis=1))
        o = np.where(fine[:, None], o, 0.0)
        seen.append(o[fine][:, now])
        command.append(guide.act(o, time)[fine])
        q, v = stepped.advance(q, v, policy.act(o if policy is guide else o[:, now], time))
    return np.concatenate(seen), np.concatenate(command)
