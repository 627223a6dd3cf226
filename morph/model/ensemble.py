"""Several models of one body, each as probable as the runs that were seen make it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from morph.arrays import Array, Integers
from morph.errors import EvidenceError
from morph.model.candidate import Candidate
from morph.model.latent.run import Run
from morph.model.mixture import Mixture
from morph.model.ou_likelihood import Likelihood
from morph.model.select import Unsaid, WeighedModels, courses, posterior, weighed
from morph.model.transitions import transitions
from morph.sim.rollout import Variant, rollout


@dataclass(frozen=True, kw_only=True, eq=False)
class Ensemble:
    """Models of one body, and what runs so far say of them.

    Raises:
        EvidenceError: There is no model, two have one name or other sizes or steps, a prior is
            negative or all are 0, or the noise is not a positive number for each entry.
    """

    candidates: tuple[Candidate, ...]
    """The models."""
    noise: Array
    """Standard deviation of each observed number: of positions, as moves in the coordinates of
    `qvel`, then of velocities; shape (2 nv,)."""
    unsaid: Unsaid = field(default_factory=Unsaid)
    """What models may leave out."""
    each: bool = True
    """Whether each model tells how noise is handed on, or the first for all, which is faster."""
    told: tuple[Likelihood, ...] = ()
    """What runs so far say, by block, (models, settings) each; empty before any run."""

    def __post_init__(self) -> None:
        """Check that the models are of one body and the numbers in range."""
        where = "an ensemble of models"
        names = [each.name for each in self.candidates]
        if not names or len(set(names)) < len(names):
            raise EvidenceError(
                f"its models are {', '.join(names) or 'none'}",
                where=where,
                fix="give one model or more, each with a name of its own",
            )
        models = [v.model for each in self.candidates for v in (each.variant, *each.doubts)]
        if len({len(each.doubts) for each in self.candidates}) > 1:
            raise EvidenceError(
                "its models have not as many figures in doubt as each other",
                where=where,
                fix="where a figure of one model is sure, give the model itself as its doubt",
            )
        if len({(m.nq, m.nv, m.nu, m.opt.timestep) for m in models}) > 1:
            raise EvidenceError(
                "its models differ in their numbers of joints or actuators, or in their step",
                where=where,
                fix="make all from one body, with one step",
            )
        priors = [each.prior for each in self.candidates]
        if min(priors) < 0.0 or not 0.0 < sum(priors) < np.inf:
            raise EvidenceError(
                f"its priors are {priors}", where=where, fix="give priors of 0 or more, not all 0"
            )
        fine = self.noise.shape == (2 * self.model.nv,) and np.isfinite(self.noise).all()
        if not (fine and self.noise.min() > 0.0):
            raise EvidenceError(
                f"its noise, {self.noise}, is no positive number for each of "
                f"{2 * self.model.nv} entries",
                where=where,
                fix="give what the sensors' sheets say, or a channel's scatter at rest",
            )

    @property
    def model(self) -> Any:
        """A compiled model of the body: the first."""
        return self.candidates[0].variant.model

    @property
    def variants(self) -> list[Variant]:
        """The compiled models."""
        return [each.variant for each in self.candidates]

    @property
    def log_prior(self) -> Array:
        """The logarithm of each model's prior, shape (models,)."""
        prior = np.array([each.prior for each in self.candidates])
        with np.errstate(divide="ignore"):
            return np.asarray(np.log(prior / prior.sum()))

    def course(self, run: Run) -> tuple[Likelihood, ...]:
        """Return how probable a run is up to each sample, (models, settings, periods).

        One for each block of the body; `select.weighed` sums them up.
        """
        seen = transitions(
            self.candidates[0].robot,
            self.variants,
            run,
            doubts=[each.doubts for each in self.candidates],
            each=self.each,
        )
        return courses(self.model, seen, self.noise, self.unsaid)

    def after(self, runs: Sequence[Run]) -> Ensemble:
        """Return the ensemble after some more runs, whatever their order.

        Raises:
            DiagnosisError: A run is not of this body, or its period is no multiple of the step.
        """
        given = self.told
        for run in runs:
            last = tuple(each.until(len(run.command)) for each in self.course(run))
            given = tuple(a + b for a, b in zip(given, last, strict=True)) if given else last
        return replace(self, told=given)

    @cached_property
    def weighed(self) -> WeighedModels | None:
        """What runs so far say in sum; None before any."""
        return weighed(self.told) if self.told else None

    @cached_property
    def probability(self) -> Array:
        """How probable each model is, shape (models,): eq. 13.

        Raises:
            EvidenceError: Every model holds the runs to be impossible.
        """
        if self.weighed is None:
            return posterior(np.zeros(len(self.candidates)), self.log_prior)
        return posterior(self.weighed.log_evidence, self.log_prior)

    @property
    def best(self) -> Candidate:
        """The most probable model."""
        return self.candidates[int(np.argmax(self.probability))]

    @property
    def entropy(self) -> float:
        """What is not known of the model, nats: 0 if one is certain, at most log(models)."""
        known = self.probability[self.probability > 0.0]
        return float(-np.sum(known * np.log(known)))

    @property
    def none(self) -> float:
        """How probable it is that none of the models fits: each leaves out more than the limit."""
        if self.weighed is None:
            return 0.0
        return float(self.probability @ self.weighed.too_much(self.model, self.unsaid))

    def standing_out(self, least: float = 0.95) -> Candidate | None:
        """Return the model to go on with alone; None if none stands out or none fits.

        Args:
            least: Probability that it must have, of being the right one and of fitting.
        """
        sure = float(self.probability.max()) >= least and self.none <= 1.0 - least
        return self.best if sure else None

    def draw(self, rows: int, rng: np.random.Generator) -> Integers:
        """Return models drawn by their probabilities, to plan with: shape (rows,).

        A plan that is good in simulations by these models is good for the mixture.
        """
        return np.asarray(rng.choice(len(self.candidates), size=rows, p=self.probability))

    def expected(self, value: Callable[[Candidate], float], *, least: float = 1e-3) -> float:
        """Return what something comes to on average over the models, such as a policy's loss.

        Args:
            value: What it comes to under one model.
            least: Models less probable than this are not asked.
        """
        requested = np.flatnonzero(self.probability >= min(least, self.probability.max()))
        share = self.probability[requested] / self.probability[requested].sum()
        return float(
            sum(p * value(self.candidates[k]) for p, k in zip(share, requested, strict=True))
        )

    def predict(self, position: Array, velocity: Array, command: Array) -> Mixture:
        """Return what the models predict, in one batch.

        Args:
            position: `qpos` at the start, shape (nq,).
            velocity: `qvel`, shape (nv,).
            command: What actuators receive in each step, shape (steps, nu).
        """
        models = len(self.candidates)
        q, v = rollout(
            self.variants,
            np.arange(models),
            np.repeat(position[None], models, axis=0),
            np.repeat(velocity[None], models, axis=0),
            np.repeat(command[None], models, axis=0),
        )
        return Mixture(model=self.model, probability=self.probability, position=q, velocity=v)
