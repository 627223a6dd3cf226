"""Inverse dynamics of a target from its runs: which command leads from a state to the next."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from morph.alignment.arrays import Array, Mask
from morph.alignment.errors import SettingError
from morph.alignment.regression import Regression, regression
from morph.alignment.samples import Transitions
from morph.alignment.states import change, features

Guess = Callable[[Array, Array], Array]
"""From states (m, n) and those that follow (m, n) to commands (m, nu)."""


class Inverse(ABC):
    """g of u_t = g(x_t, x_t+1), learned, with how well it is known."""

    @abstractmethod
    def predict(self, state: Array, after: Array) -> tuple[Array, Array]:
        """Return commands that lead from states to others, and their variance, (m, nu) each.

        Args:
            state: x_t, shape (m, n).
            after: x_t+1, shape (m, n).
        """


@dataclass(frozen=True, kw_only=True, eq=False)
class GaussianInverse(Inverse):
    """A guess, and a Gaussian process for what the guess misses.

    The guess is best the inverse dynamics of a simulator: sixty transitions then only have to
    say in what the target differs, as in thesis eq. 12 for the dynamics themselves. What is
    missed is taken for a linear law of state and change, which viscous friction and a heavier
    body are, and a smooth rest.
    """

    turns: Mask
    """Which numbers of a state are angles."""
    guess: Guess | None
    """What is expected before all data; None for no command."""
    missed: tuple[Regression, ...]
    """What the guess misses of each command, as a function of `joint`."""

    def predict(self, state: Array, after: Array) -> tuple[Array, Array]:
        """Return the guess and what it misses; the variance is that of the function alone."""
        x = joint(state, after, self.turns)
        mean, variance = (
            np.stack(each, axis=1)
            for each in zip(*(part.predict(x) for part in self.missed), strict=True)
        )
        return mean + guessed(self.guess, state, after, len(self.missed)), variance


def gaussian_inverse(seen: Transitions, guess: Guess | None = None) -> GaussianInverse:
    """Return the inverse dynamics that a target's transitions make most probable.

    Args:
        seen: What the target did.
        guess: What is expected before any data, such as a simulator's inverse dynamics.

    Raises:
        SamplesError: There are too few or too many transitions.
    """
    x = joint(seen.state, seen.after, seen.turns)
    left = seen.command - guessed(guess, seen.state, seen.after, seen.command.shape[1])
    return GaussianInverse(
        turns=seen.turns, guess=guess, missed=tuple(regression(x, each) for each in left.T)
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class LocalInverse(Inverse):
    """Locally weighted regression: a plane through the nearest transitions, fitted anew each time.

    Source: Atkeson, Moore and Schaal 1997, Locally Weighted Learning, Artificial Intelligence
    Review 11, sections 4 and 5 (tricube kernel, width by the k-th neighbour, ridge).
    """

    seen: Transitions
    """The target's transitions."""
    guess: Guess | None
    """What is expected before all data; None for no command."""
    nearest: int
    """How many transitions have a say."""
    ridge: float
    """What a slope of 1 per spread costs, as a share of the weight of the data."""

    def __post_init__(self) -> None:
        """Check the settings."""
        if not (3 <= self.nearest <= len(self.seen.state) and self.ridge > 0.0):
            raise SettingError(
                f"{self.nearest} of {len(self.seen.state)} transitions have a say, "
                f"and the ridge is {self.ridge:g}",
                where="a local inverse",
                fix="let at least 3 and at most all have a say, and give a positive ridge",
            )

    def predict(self, state: Array, after: Array) -> tuple[Array, Array]:
        """Return the planes at each transition asked; the variance is of the planes' heights."""
        seen = self.seen
        data = joint(seen.state, seen.after, seen.turns)
        middle, spread = data.mean(axis=0), data.std(axis=0)
        spread = np.where(spread > 1e-9, spread, 1.0)
        z, requested = (data - middle) / spread, (joint(state, after, seen.turns) - middle) / spread
        count = seen.command.shape[1]
        left = seen.command - guessed(self.guess, seen.state, seen.after, count)
        planes = [self._plane(z, left, each) for each in requested]
        mean = np.stack([each[0] for each in planes])
        variance = np.stack([each[1] for each in planes])
        return mean + guessed(self.guess, state, after, count), variance

    def _plane(self, z: Array, left: Array, at: Array) -> tuple[Array, Array]:
        away = np.sqrt(np.square(z - at).sum(axis=1))
        width = max(float(np.partition(away, self.nearest - 1)[self.nearest - 1]), 1e-9)
        weight = np.clip(1.0 - (away / (1.001 * width)) ** 3, 0.0, 1.0) ** 3
        columns = np.concatenate([np.ones((len(z), 1)), z - at], axis=1)
        price = self.ridge * weight.sum() * np.eye(columns.shape[1])
        price[0, 0] = 1e-9
        inner = np.linalg.inv((columns * weight[:, None]).T @ columns + price)
        hat = inner @ (columns * weight[:, None]).T
        plane = hat @ left
        rest = left - columns @ plane
        freedom = max(float(weight.sum() - (hat * columns.T).sum(axis=0) @ weight), 1.0)
        noise = (weight @ np.square(rest)) / freedom
        return plane[0], np.asarray(noise * float(np.square(hat[0]).sum()))


def local_inverse(
    seen: Transitions, guess: Guess | None = None, *, nearest: int = 30, ridge: float = 0.05
) -> LocalInverse:
    """Return inverse dynamics by locally weighted regression.

    Args:
        seen: What the target did.
        guess: What is expected before any data, such as a simulator's inverse dynamics.
        nearest: How many transitions have a say; all if there are fewer.
        ridge: What a slope of 1 per spread costs, as a share of the weight of the data.

    Raises:
        SettingError: A setting is out of range.
    """
    nearest = min(nearest, len(seen.state))
    return LocalInverse(seen=seen, guess=guess, nearest=nearest, ridge=ridge)


def joint(state: Array, after: Array, turns: Mask) -> Array:
    """Return what an inverse is a function of: features of a state, and its change."""
    return np.concatenate([features(state, turns), change(state, after, turns)], axis=1)


def guessed(guess: Guess | None, state: Array, after: Array, count: int) -> Array:
    """Return what a guess says, or no command, shape (m, count)."""
    if guess is None:
        return np.zeros((len(state), count))
    return np.asarray(guess(state, after), dtype=float).reshape(len(state), count)
