"""The guard: whether a policy would harm a body, foreseen from few transitions of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from morph.alignment.arrays import Array
from morph.alignment.belief import Belief
from morph.alignment.errors import SettingError

Law = Callable[[Array, Array], Array]
"""From states about rest (m, n) and the time, s, (m,), to commands about rest, (m, k)."""

GONE = 3.1
"""Size of the outcome from which a body has fallen or is lost: nothing after it counts."""

LEAST = 0.01
"""Score beside which scores are compared: a twentieth of a second upright."""

DRAWS = 64
"""Bodies drawn from the belief."""

WEIGHTS = (-0.37, 0.44, -0.88, -1.03, 0.35)
"""Of the logistic law from what was foreseen to the probability of harm; found on bodies that no
figure of the guard is of (docs/guard.md)."""

SAFE, UNSAFE = 0.05, 0.5
"""Probabilities of harm up to which a policy is safe, and from which on it is unsafe."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TrialTask:
    """What a run on the target would be like, as far as its task tells."""

    outcome: Array
    """C: the task looks at z = C x, of which the first half are places and the rest rates."""
    starts: Array
    """States in which runs may begin, shape (m, n)."""
    low: Array
    """Least commands about rest, shape (k,)."""
    high: Array
    """Greatest commands about rest, shape (k,)."""
    periods: int
    """How many commands a run has."""
    period: float
    """How long each is held, s."""

    def __post_init__(self) -> None:
        """Check the shapes."""
        n = self.outcome.shape[1] if self.outcome.ndim == 2 else -1
        fits = self.starts.ndim == 2 and self.starts.shape[1] == n and len(self.starts) > 0
        bounded = self.low.shape == self.high.shape and bool((self.low <= self.high).all())
        if not (fits and bounded and self.periods > 0 and self.period > 0.0):
            raise SettingError(
                f"the outcome has the shape {self.outcome.shape}, the starts "
                f"{self.starts.shape}, and there are {self.periods} periods",
                where="a trial of a policy",
                fix="give starts of as many numbers as the outcome reads, bounds in order, and "
                "a period or more",
            )


@dataclass(frozen=True, kw_only=True, eq=False)
class PredictedScores:
    """What a policy and holding still would score on every body drawn from a belief."""

    score: Array
    """Of the policy, 0 to 1, shape (draws,)."""
    still: Array
    """Of holding still, shape (draws,)."""

    @property
    def gain(self) -> Array:
        """What the policy scores beyond holding still, shape (draws,)."""
        return self.score - self.still

    @property
    def share(self) -> float:
        """The share of the bodies that the policy harms, away from 0 and 1 as draws are few."""
        return float(((self.gain < 0.0).sum() + 0.5) / (len(self.gain) + 1.0))

    @property
    def features(self) -> Array:
        """What the probability of harm is told by, shape (5,).

        One, the log odds of the share, and of the log of the policy's score over holding still's
        its middle and its lowest and highest tenth: how clear it is, beside how probable.
        """
        share = self.share
        ratio = np.log((self.score + LEAST) / (self.still + LEAST))
        low, middle, high = np.quantile(ratio, (0.1, 0.5, 0.9))
        return np.array([1.0, np.log(share / (1.0 - share)), middle, low, high])


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """Whether a policy may be tried on a body."""

    verdict: Literal["safe", "unsafe", "unsure"]
    """`safe` if harm is improbable, `unsafe` if it is probable."""
    probability: float
    """Of harm: that it would score less than holding still."""


def foreseen(
    belief: Belief,
    law: Law,
    trial: TrialTask,
    rng: np.random.Generator,
    *,
    draws: int = DRAWS,
    still: Array | None = None,
) -> PredictedScores:
    """Return what a policy would score on bodies drawn from a belief, and what holding still.

    Every body drawn is run from every start under the policy, which sees states through the
    noise of readings, and under no command; both meet the same chance. The score of a run is the
    mean over time of exp(-|z|^2 / 2), z the outcome, and 0 from where |z| first exceeds `GONE`.

    Args:
        belief: What is known of the target near rest.
        law: The policy, about rest.
        trial: What a run is like.
        rng: The chance of bodies, of what steps add and of readings.
        draws: How many bodies.
        still: What holding still was foreseen to score, where the same chance foresaw it.
    """
    laws = belief.drawn(draws, rng)
    seed = int(rng.integers(2**63))

    def rested(x: Array, time: Array) -> Array:
        return np.zeros((len(x), len(trial.low)))

    ours = _scores(laws, belief, law, trial, np.random.default_rng(seed))
    none = still
    if none is None:
        none = _scores(laws, belief, rested, trial, np.random.default_rng(seed))
    return PredictedScores(score=ours, still=none)


def _scores(
    laws: Array, belief: Belief, law: Law, trial: TrialTask, rng: np.random.Generator
) -> Array:
    """Return the mean score of a policy on each body, shape (draws,)."""
    draws, m, n = len(laws), *trial.starts.shape
    half = trial.outcome[: len(trial.outcome) // 2]
    x = np.broadcast_to(trial.starts, (draws, m, n)).copy()
    alive, total = np.ones((draws, m)), np.zeros((draws, m))
    pushed = belief.lift @ belief.lift.T
    own = np.sqrt(np.diag(pushed) / pushed.max())
    level = belief.steady * float(belief.noise.mean())
    for at in range(trial.periods):
        size = np.square(x @ half.T).sum(axis=-1)
        alive *= size < GONE**2
        total += alive * np.exp(-0.5 * size)
        if not alive.any():
            break
        seen = x + belief.noise * rng.standard_normal(x.shape)
        time = np.full(draws * m, at * trial.period)
        command = np.nan_to_num(law(seen.reshape(-1, n), time)).reshape(draws, m, -1)
        z = np.concatenate([x, np.clip(command, trial.low, trial.high)], axis=-1)
        x = z @ laws.swapaxes(1, 2) + level * own * rng.standard_normal(x.shape)
        # What has fallen is over: its numbers must not grow until they are none.
        x = np.clip(x, -1e3, 1e3) * alive[..., None]
    return np.asarray(total.mean(axis=-1) / trial.periods)


def odds(features: Array) -> float:
    """Return the probability of harm of what was foreseen, by the logistic law of `WEIGHTS`.

    Args:
        features: As `PredictedScores.features` gives them, shape (5,).
    """
    return float(1.0 / (1.0 + np.exp(-np.clip(features @ np.array(WEIGHTS), -30.0, 30.0))))


def judge(result: PredictedScores, *, safe: float = SAFE, unsafe: float = UNSAFE) -> Verdict:
    """Return the verdict on what was foreseen.

    Args:
        result: What was foreseen.
        safe: Up to which probability of harm a policy is safe.
        unsafe: From which on it is unsafe.

    Raises:
        SettingError: The two are out of order.
    """
    if not 0.0 <= safe <= unsafe <= 1.0:
        raise SettingError(
            f"safe is {safe:g} and unsafe {unsafe:g}",
            where="the guard",
            fix="give 0 <= safe <= unsafe <= 1",
        )
    probability = odds(result.features)
    if probability <= safe:
        return Verdict(verdict="safe", probability=probability)
    return Verdict(verdict="unsafe" if probability >= unsafe else "unsure", probability=probability)
