"""Certify a model on the transitions of a target: good enough, not good enough, or undecided."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from morph.arrays import Array
from morph.errors import DiagnosisError
from morph.model.gaussian.information import Information
from morph.model.hypothesis import Hypothesis
from morph.model.kwik.belief import ModelPosterior, belief
from morph.model.kwik.e_values import bets, worst
from morph.model.kwik.refine_linearisation import units
from morph.model.kwik.transition_evidence import Visit, visit
from morph.model.latent.run import Run
from morph.model.latent.transition_model import Transit
from morph.sim.integrator import Integrator

Answer = Literal["good", "not good", "cannot say"]

EPSILONS = 2.0
"""Epsilon if none is said, in standard deviations of the observations: what a policy that sees
this noise takes for noise in any single period, a larger error it takes for a push."""

DRAWS = 400
"""Draws of the unknowns from which probabilities are counted."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ModelVerdict:
    """Whether a model is good enough for the transitions that a target made.

    Good is a model that errs, over one control period, by less than epsilon in every state at a
    share of at least 1 - `share` of the transitions.
    """

    verdict: Answer
    """`good`: adjust the policy; `not good`: repair the model; `cannot say`: run again."""
    probability: float
    """That the model is good."""
    transitions: Array
    """For each transition, the probability that the model errs by less than epsilon there."""
    error: Array
    """The model's most probable error over each period, shape (transitions, n)."""
    for_good: float
    """log of the bet against "not good": beyond log(1 / delta) it is refuted."""
    for_bad: float
    """log of the bet against "good", likewise."""
    epsilon: Array
    """What is still good, of each state, shape (n,)."""
    delta: float
    """How often a verdict may be wrong."""

    @property
    def text(self) -> str:
        """The verdict in two sentences."""
        inside = float(self.transitions.mean())
        largest = float((np.abs(self.error) / self.epsilon).max())
        return (
            f"{SAID[self.verdict]} (probability {self.probability:.2f}). Over "
            f"{len(self.transitions)} transitions it is expected to err by less than epsilon in "
            f"{inside:.0%}, at most by {largest:.1f} epsilon."
        )


SAID = {
    "good": "The model is good enough here: adjust the policy",
    "not good": "The model is not good enough here: repair the model",
    "cannot say": "What was seen does not say whether the model is good enough: run again",
}
"""What each answer advises."""


def judge(
    hypothesis: Hypothesis,
    runs: Sequence[Run],
    noise: Array,
    *,
    integrator: Integrator = "implicitfast",
    epsilon: Array | None = None,
    delta: float = 0.05,
    share: float = 0.05,
    rng: np.random.Generator,
) -> ModelVerdict:
    """Return whether a model is good enough for the transitions of some runs.

    The model's error is a Gaussian process about the simulator: named figures (`unknowns`) and
    effects of the hypothesis act through the simulator itself, and what none of them says is a
    smooth process in state and command. Source: thesis (Gamboa Higuera 2015) section 3.4 and
    eq. 12. States are filtered, so that noise, which makes neighbouring transitions err alike,
    counts once; errors at all transitions are drawn together.

    `good` and `not good` are settled by bets (`wager.bets`), so they hold whenever the recording
    is stopped, and are given only if the probability agrees.

    Args:
        hypothesis: The model as it stands, and what may be wrong in it.
        runs: What was observed on the target, all on one clock.
        noise: Standard deviation of each observation, positions then velocities, shape (n,).
        integrator: What the model steps with.
        epsilon: Error over one control period that is still good, shape (n,); None for
            `EPSILONS` standard deviations of the observations.
        delta: How often a verdict may be wrong.
        share: Share of the transitions at which the model may err by more.
        rng: Of the draws.

    Raises:
        DiagnosisError: A figure is out of range, there is no run, or clocks differ.
    """
    seen, fine = _seen(hypothesis, runs, noise, integrator, epsilon, delta, share)
    return verdict_of(seen, len(seen), hypothesis, fine, delta, share, rng)


def watch(
    hypothesis: Hypothesis,
    runs: Sequence[Run],
    noise: Array,
    moments: Iterable[int],
    *,
    integrator: Integrator = "implicitfast",
    epsilon: Array | None = None,
    delta: float = 0.05,
    share: float = 0.05,
    rng: np.random.Generator,
) -> list[ModelVerdict]:
    """Return the verdicts after the first so many transitions, each on these transitions.

    Arguments are those of `judge`; the states of all runs scale the process, and nothing else of
    the future enters.
    """
    seen, fine = _seen(hypothesis, runs, noise, integrator, epsilon, delta, share)
    return [verdict_of(seen, count, hypothesis, fine, delta, share, rng) for count in moments]


def _seen(
    hypothesis: Hypothesis,
    runs: Sequence[Run],
    noise: Array,
    integrator: Integrator,
    epsilon: Array | None,
    delta: float,
    share: float,
) -> tuple[Visit, Array]:
    fine = EPSILONS * np.asarray(noise, dtype=float) if epsilon is None else np.asarray(epsilon)
    for name, value in (("delta", delta), ("share", share)):
        if not 0.0 < value < 0.5:
            _refuse(hypothesis, f"{name} is {value:g}", "give a share between 0 and 0.5")
    if not (np.asarray(noise) > 0.0).all() or not (fine > 0.0).all():
        _refuse(
            hypothesis,
            f"noise is {np.asarray(noise).tolist()} and epsilon {fine.tolist()}",
            "give a standard deviation above 0 for each observation, and such an epsilon",
        )
    period = runs[0].period if runs else 0.0
    if not runs:
        _refuse(hypothesis, "there is no run", "record one of the policy on the target")
    transit = Transit(hypothesis=hypothesis, period=period, integrator=integrator)
    return visit(transit, runs, np.asarray(noise, dtype=float), fine), fine


def _refuse(hypothesis: Hypothesis, what: str, fix: str) -> None:
    raise DiagnosisError(what, where=f"the gate for {hypothesis.robot.name}", fix=fix)


def verdict_of(
    seen: Visit,
    count: int,
    hypothesis: Hypothesis,
    epsilon: Array,
    delta: float,
    share: float,
    rng: np.random.Generator,
) -> ModelVerdict:
    """Return the verdict on the first transitions of what was visited, as `judge` says."""
    unit = units(hypothesis)
    held = believed(seen.until(count), seen, count, unit)
    error = seen.error[:count]
    most = math.floor(share * count + 1e-9) + 1
    for_good, for_bad = bets(held, unit, error, most)
    drawn = held.draws(DRAWS, rng) @ error.reshape(-1, error.shape[-1]).T
    beyond = np.abs(drawn).reshape(len(drawn), *error.shape[:2]).max(axis=2)
    probability = float(np.mean(worst(beyond, most) < 1.0))
    return ModelVerdict(
        verdict=_answer(probability, for_good, for_bad, delta),
        probability=probability,
        transitions=(beyond < 1.0).mean(axis=0),
        error=drawn.mean(axis=0).reshape(error.shape[:2]) * epsilon,
        for_good=for_good,
        for_bad=for_bad,
        epsilon=epsilon,
        delta=delta,
    )


def believed(result: Information, seen: Visit, count: int, unit: Array) -> ModelPosterior:
    """Return what is believed, with all variances greater where nothing fits what was seen.

    Source: Birge 1932, Physical Review 40, eq. 3: errors grow until the sum of squares is as
    expected. A target that any rival can follow is not touched by it.
    """
    held = belief(result, seen.named, unit, seen.unnamed.smooth)
    misfit = result.missed(held.middle) / (count * seen.error.shape[1])
    if misfit <= 1.0:
        return held
    return belief(result.weaker(misfit), seen.named, unit, seen.unnamed.smooth)


def _answer(probability: float, for_good: float, for_bad: float, delta: float) -> Answer:
    needed = math.log(1.0 / delta)
    if for_good >= needed and probability >= 1.0 - delta:
        return "good"
    if for_bad >= needed and probability <= delta:
        return "not good"
    return "cannot say"
