"""What bodies did, as arrays: all that a map between them is learned from."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from morph.alignment.arrays import Array, Mask
from morph.alignment.errors import SamplesError

Step = Callable[[Array, Array], Array]
"""A simulator: from states (m, n) and commands (m, nu) to the states that follow, (m, n)."""

Worth = Callable[[Array], Array]
"""What states (m, n) cost by the task, shape (m,)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Transitions:
    """What a body did: states, what was commanded there, and the states that followed."""

    state: Array
    """x_t, shape (m, n)."""
    command: Array
    """u_t, held until the next state, shape (m, nu)."""
    after: Array
    """x_t+1, shape (m, n)."""
    turns: Mask
    """Which numbers of a state are angles, rad, that may go round, shape (n,)."""

    def __post_init__(self) -> None:
        """Check the shapes."""
        m, n = self.state.shape if self.state.ndim == 2 else (0, 0)
        fits = self.after.shape == (m, n) and self.turns.shape == (n,) and m > 0
        if not (fits and self.command.ndim == 2 and len(self.command) == m):
            shapes = [self.state.shape, self.command.shape, self.after.shape, self.turns.shape]
            raise SamplesError(
                f"state, command, after and turns have the shapes {shapes}",
                where="transitions of a body",
                fix="give (m, n), (m, nu), (m, n) and (n,)",
            )
        parts = (self.state, self.command, self.after)
        if not all(np.isfinite(each).all() for each in parts):
            raise SamplesError(
                "a state or a command is no finite number",
                where="transitions of a body",
                fix="leave out what a sensor failed to see",
            )

    def and_also(self, more: Transitions) -> Transitions:
        """Return these and more of the same body."""
        return Transitions(
            state=np.concatenate([self.state, more.state]),
            command=np.concatenate([self.command, more.command]),
            after=np.concatenate([self.after, more.after]),
            turns=self.turns,
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class Pairs:
    """States of two bodies that correspond, row by row: landmarks that somebody labelled."""

    source: Array
    """Shape (pairs, n of the source)."""
    target: Array
    """Shape (pairs, n of the target)."""

    def __post_init__(self) -> None:
        """Check the shapes."""
        both = self.source.ndim == 2 and self.target.ndim == 2
        if not both or len(self.source) != len(self.target):
            raise SamplesError(
                f"pairs have the shapes {self.source.shape} and {self.target.shape}",
                where="pairs of states",
                fix="give as many states of the source as of the target, one a row",
            )
