"""Plans: bang-bang seeds, improved by dynamic programming, followed with feedback."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from morph.arrays import Array
from morph.errors import SearchError, StateError
from morph.search.plan.delayed_actuation import late
from morph.search.plan.evaluate_plan import concluded
from morph.search.plan.plan_selection import SURE, Planned, planned
from morph.search.plan.policy import track_of
from morph.search.plan.terminal_controller import grounded
from morph.search.search import Learned, Problem, Search, State, Told, Trial, ignore
from morph.search.trajectory.ddp import Trajectories
from morph.search.trajectory.delay_augmented_plant import is_late


@dataclass(frozen=True, kw_only=True)
class Plan(Search):
    """Differential dynamic programming from sampled seeds, in a simulator.

    Swings of bang-bang commands and straight paths are tried in batches, the best are improved
    by differential dynamic programming within the bounds of the commands, and of those the one
    is taken that does best with its feedback in the noise. If it fails there, another round
    begins with more seeds. Where commands are delayed or lag, plans are led in time.

    Source: Tassa, Mansard and Todorov 2014, Control-Limited Differential Dynamic Programming.
    """

    name: ClassVar[str] = "ddp"

    rows: int = 768
    """Bang-bang swings that the first round draws; each later round draws twice as many."""
    keep: int = 4
    """Guesses that a round improves."""
    most: int = 20
    """Most steps of dynamic programming in a round."""
    runs: int = 32
    """Noisy runs by which each plan is judged."""
    rounds: int = 4
    """Most rounds; fewer if a plan succeeds."""
    margin: float = 0.0
    """Share of each command's range, at both its ends, that plans leave to the feedback."""
    target: float = 0.0
    """Mean loss down to which rounds go on even if a plan succeeds already."""

    def __post_init__(self) -> None:
        """Check the numbers."""
        least = min(self.rows // 16, self.keep, self.most, self.runs, self.rounds)
        if least < 1 or not 0.0 <= self.margin < 1.0:
            raise SearchError(
                f"it draws {self.rows} rows, keeps {self.keep}, takes {self.most} steps, "
                f"{self.runs} runs and {self.rounds} rounds, with a margin of {self.margin:g}",
                where="the search ddp",
                fix="give at least 16 rows, 1 of each other, and a margin from 0 to below 1",
            )

    def solve(
        self,
        problem: Problem,
        *,
        seed: int,
        trials: int | None = None,
        progress: Told = ignore,
        state: State | None = None,
    ) -> Learned:
        """Return the best plan as a policy; the arguments are those of `Search.run`."""
        task, simulator = problem.task, problem.model
        began = time.monotonic()
        if is_late(simulator):
            # Its few tries are not worth going on from: what was killed begins anew.
            led = late(task, simulator, None, seed=seed)
            for trial in led.trials:
                progress(trial, {})
            return led
        ground = grounded(task, simulator, margin=self.margin, rng=np.random.default_rng(seed))
        best, first = (None, 1) if state is None else _restored(state)
        record: list[Trial] = []
        for number in range(first, (trials or self.rounds) + 1):
            # Before the round: one that was killed after it was content has nothing to add.
            if best is not None and self._content(best):
                break
            # Each round has chance of its own, so that one that goes on finds what it would have.
            rng = np.random.default_rng([seed, number])
            result = planned(
                ground,
                rows=self.rows * 2 ** min(number - 1, 3),
                keep=self.keep,
                most=self.most,
                runs=self.runs,
                rng=rng,
            )
            best = result if best is None or result.score < best.score else best
            record.append(
                Trial(
                    number=number,
                    loss=best.loss,
                    success=best.success,
                    seconds=time.monotonic() - began,
                )
            )
            progress(record[-1], _kept(best, number))
        if best is None:
            raise SearchError(
                "it was given no round to search in",
                where=f"the search {self.name}",
                fix="give one trial or more",
            )
        return concluded(
            problem,
            track_of(ground, best),
            tuple(record),
            seed=seed,
            what="the best plan",
            hint="more rounds, more rows or a margin may find a better one",
        )

    def _content(self, best: Planned) -> bool:
        """Return whether no further round is wanted."""
        return best.success >= SURE and (self.target <= 0.0 or best.loss <= self.target)


def _kept(best: Planned, number: int) -> Mapping[str, Array]:
    """Return the best plan so far and the number of its round, as arrays."""
    return {
        "round": np.array(float(number)),
        "gain": best.gain,
        "judged": np.array([best.loss, best.success]),
        **{f"plan.{name}": value for name, value in vars(best.plan).items()},
    }


def _restored(state: State) -> tuple[Planned, int]:
    """Return the best plan so far, and the round with which to go on.

    Raises:
        StateError: It is not what such a search keeps.
    """
    try:
        names = ("position", "velocity", "command", "cost")
        best = Planned(
            plan=Trajectories(**{name: np.asarray(state[f"plan.{name}"]) for name in names}),
            gain=np.asarray(state["gain"]),
            loss=float(state["judged"][0]),
            success=float(state["judged"][1]),
        )
        return best, int(state["round"]) + 1
    except (KeyError, IndexError, TypeError, ValueError) as error:
        raise StateError(
            f"what it is to go on from lacks a plan: {error}",
            where="the search ddp",
            fix="begin anew, or give what this search wrote",
        ) from error
