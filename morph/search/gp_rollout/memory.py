"""Checkpoint of a search on Gaussian-process dynamics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array
from morph.errors import SearchError, StateError
from morph.model.gp.gp import GaussianProcess
from morph.search.gp_rollout.task import TaskSums
from morph.search.search import State
from morph.search.target import Experience

RUN = ("position", "velocity", "command")
"""The arrays of an experience."""

TRIED = "tried."
"""How the numbers of policies begin in a state."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Memory:
    """Every trial, and what the last improvement began from."""

    runs: tuple[Experience, ...] = ()
    """The trials, the one with random commands first."""
    tried: tuple[Mapping[str, Array], ...] = ()
    """The numbers of the policy of each but the first, as `Policy.weights` gives them."""
    process: GaussianProcess | None = None
    """What was learned before the last trial."""
    numbers: Array | None = None
    """What the last improvement left, as one vector."""
    seconds: float = 0.0
    """Wall time until now."""

    @property
    def experience(self) -> float:
        """Time on the target, s."""
        return sum(run.seconds for run in self.runs)

    @property
    def best(self) -> int:
        """The trial that cost least, of those that reached every goal if any did.

        The first one, of random commands, does not count: no policy made it.
        """
        runs = self.runs
        return min(range(1, len(runs)), key=lambda at: (not runs[at].success, runs[at].loss))

    def after(
        self,
        run: Experience,
        *,
        tried: Mapping[str, Array] | None = None,
        process: GaussianProcess | None = None,
        numbers: Array | None = None,
    ) -> Memory:
        """Return the memory with another trial."""
        return replace(
            self,
            runs=(*self.runs, run),
            tried=self.tried if tried is None else (*self.tried, tried),
            process=process,
            numbers=numbers,
        )

    def at(self, seconds: float) -> Memory:
        """Return the memory at another time."""
        return replace(self, seconds=seconds)

    def data(self, view: TaskSums) -> tuple[Array, Array]:
        """Return inputs and targets of the change of velocity in a period, of all trials."""
        inputs, targets = [], []
        for run in self.runs:
            z = view.lifted(np.concatenate([run.position, run.velocity], axis=1))[:-1]
            inputs.append(np.concatenate([z, run.command], axis=1)[:, view.looks])
            targets.append(np.diff(run.velocity, axis=0))
        return np.concatenate(inputs), np.concatenate(targets)

    def features(self, view: TaskSums) -> Array:
        """Return what policies saw in all trials, shape (samples, features)."""
        states = [np.concatenate([run.position, run.velocity], axis=1) for run in self.runs]
        return np.asarray(view.lifted(np.concatenate(states))[:, view.sees])

    def spread(self, inputs: Array, targets: Array, most: int) -> tuple[Array, Array]:
        """Return at most so many of the data: each time the one farthest from those chosen."""
        if len(inputs) <= most:
            return inputs, targets
        x = inputs / inputs.std(axis=0)
        if self.process is not None:
            x = inputs / np.exp(np.log(self.process.lengths).mean(axis=0))
        chosen = [len(x) - 1]
        apart = np.full(len(x), np.inf)
        for _ in range(most - 1):
            apart = np.minimum(apart, np.square(x - x[chosen[-1]]).sum(axis=1))
            chosen.append(int(apart.argmax()))
        at = np.sort(np.array(chosen))
        return inputs[at], targets[at]

    def state(self) -> dict[str, Array]:
        """Return all of it as arrays by name."""
        document = {
            **{name: np.stack([getattr(run, name) for run in self.runs]) for name in RUN},
            "loss": np.array([run.loss for run in self.runs]),
            "success": np.array([float(run.success) for run in self.runs]),
            "seconds": np.array(self.seconds),
        }
        if self.process is not None:
            document |= {f"process.{name}": value for name, value in vars(self.process).items()}
        if self.numbers is not None:
            document["numbers"] = self.numbers
        for name in self.tried[0] if self.tried else ():
            document[TRIED + name] = np.stack([each[name] for each in self.tried])
        return document

    @classmethod
    def of(cls, state: State | None, period: float) -> Memory:
        """Return the memory that `state` gave; an empty one of None.

        Raises:
            StateError: It does not hold trials, and one policy for each but the first.
        """
        if state is None:
            return cls()
        try:
            memory = _recalled(state, period)
            shapes = [
                run.position.ndim + run.velocity.ndim + run.command.ndim for run in memory.runs
            ]
            if set(shapes) != {6} or len(memory.tried) != len(memory.runs) - 1:
                raise ValueError(f"{len(memory.runs)} trials, and {len(memory.tried)} policies")
        except (LookupError, TypeError, ValueError, SearchError) as error:
            raise StateError(
                f"its state cannot be read: {error}",
                where="a search to be resumed",
                fix="begin anew, or give the state as this search kept it",
            ) from error
        return memory


def _recalled(state: State, period: float) -> Memory:
    parts = ("inputs", "targets", "lengths", "signal", "noise")
    process = None
    if "process.inputs" in state:
        process = GaussianProcess(**{name: state[f"process.{name}"] for name in parts})
    runs = tuple(
        Experience(position=q, velocity=v, command=u, period=period, loss=float(c), success=bool(s))
        for q, v, u, c, s in zip(*(state[name] for name in (*RUN, "loss", "success")), strict=True)
    )
    names = [name for name in state if name.startswith(TRIED)]
    tried = tuple(
        dict(zip((name.removeprefix(TRIED) for name in names), each, strict=True))
        for each in zip(*(state[name] for name in names), strict=True)
    )
    return Memory(
        runs=runs,
        tried=tried,
        process=process,
        numbers=state.get("numbers"),
        seconds=float(state["seconds"]),
    )
