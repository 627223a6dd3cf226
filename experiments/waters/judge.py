"""One case judged by every method, and many of them summed up."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from experiments.waters.cases import NOISE, PERIOD, Case
from experiments.waters.naive import by_transitions, by_whole_runs
from experiments.waters.worlds import COEFFICIENTS, DOUBTS, WORLDS, Disturbance
from morph.arrays import JSON, Array
from morph.model.candidate import Candidate
from morph.model.ensemble import Ensemble
from morph.model.ou_likelihood import Likelihood
from morph.model.select import Unsaid, courses, posterior, weighed
from morph.model.transitions import transitions

AT = (0.5, 1.0, 2.0, 5.0)
"""Seconds of data after which models are weighed."""

BINS = 10
"""Of confidence, for calibration errors."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Verdict:
    """What every method says of one case."""

    case: Case
    """The case."""
    told: dict[str, Array]
    """Probability of each model after `AT` seconds, by method, shape (times, models)."""
    none: Array
    """Probability that none fits, shape (times,)."""

    def row(self) -> JSON:
        """Return it as JSON."""
        return {
            "kind": self.case.kind,
            "seed": self.case.seed,
            "truth": [WORLDS[at].name for at in self.case.truth],
            "none": np.round(self.none, 4).tolist(),
            "probability": {name: np.round(p, 4).tolist() for name, p in self.told.items()},
        }


def ensemble(unknown: Disturbance | None = None) -> Ensemble:
    """Return the six worlds as an ensemble, all as probable, their drags and thrust in doubt.

    Args:
        unknown: What acts in all of them, known for sure; then nothing is in doubt.
    """
    doubts = () if unknown else DOUBTS
    return Ensemble(
        candidates=tuple(
            Candidate.of(
                each.name,
                each.simulator(unknown),
                doubts=[each.simulator(doubt) for doubt in doubts],
            )
            for each in WORLDS
        ),
        noise=np.full(24, NOISE),
        unsaid=Unsaid(shares=(0.0,), lengths=(1.0,)) if unknown else Unsaid(),
        each=False,
    )


class Judge:
    """The six worlds, compiled once."""

    @cached_property
    def models(self) -> Ensemble:
        """The ensemble."""
        return ensemble()

    def verdict(self, case: Case) -> Verdict:
        """Return what every method says of a case."""
        models, run = self.models, case.run
        robot = models.candidates[0].robot
        doubts = [each.doubts for each in models.candidates]
        seen = transitions(robot, models.variants, run, doubts=doubts, each=False)
        at = [round(seconds / PERIOD) for seconds in AT if seconds / PERIOD <= seen.miss.shape[1]]
        parts = [
            part.until(at) for part in courses(models.model, seen, models.noise, models.unsaid)
        ]
        told = weighed(parts)
        last = np.array(at) - 1
        known, fitted = by_whole_runs(models.variants, run, models.noise)
        # The first setting of each block leaves out nothing.
        exact = sum((part.base[:, 0] for part in parts), np.zeros(1))
        logs = {
            "eq. 13": told.log_evidence,
            "current not in doubt": _evidence(parts, COEFFICIENTS),
            "no figure in doubt": _evidence(parts, 0),
            "nothing left out": exact,
            "transitions independent": by_transitions(seen, models.noise)[:, last],
            "whole run independent": known[:, last],
            "the same, variance fitted": fitted[:, last],
        }
        if case.kind == "clean":
            logs["oracle"] = exact
        elif case.kind == "disturbed":
            sure = ensemble(case.unknown)
            known_all = transitions(robot, sure.variants, run, carry=seen.carry)
            sums = courses(sure.model, known_all, sure.noise, sure.unsaid)
            logs["oracle"] = weighed([part.until(at) for part in sums]).log_evidence
        probability = {name: posterior(log.T, models.log_prior) for name, log in logs.items()}
        bad = told.too_much(models.model, models.unsaid)
        return Verdict(
            case=case, told=probability, none=np.sum(probability["eq. 13"] * bad.T, axis=1)
        )


def _evidence(parts: Sequence[Likelihood], doubts: int) -> Array:
    """Return the evidence if only the first figures are in doubt."""
    fewer = [
        Likelihood(
            base=part.base,
            slope=part.slope[..., :doubts],
            curve=part.curve[..., :doubts, :doubts],
        )
        for part in parts
    ]
    return weighed(fewer).log_evidence


def summed(verdicts: Sequence[Verdict], rng: np.random.Generator) -> list[JSON]:
    """Return the figures of one kind of truth, a row for each method and time."""
    found: list[JSON] = []
    times = range(len(verdicts[0].none))
    for method in verdicts[0].told:
        for at in times:
            told = np.stack([each.told[method][at] for each in verdicts])
            row: JSON = {"method": method, "seconds": AT[at]}
            if method == "eq. 13":
                row["none"] = float(np.mean([each.none[at] for each in verdicts]))
                row["flagged"] = float(np.mean([each.none[at] > 0.5 for each in verdicts]))
            row["confidence"] = float(told.max(axis=1).mean())
            if len(verdicts[0].case.truth) == 2:
                row["on_neighbours"] = float(
                    np.mean(
                        [p[list(v.case.truth)].sum() for p, v in zip(told, verdicts, strict=True)]
                    )
                )
            if len(verdicts[0].case.truth) == 1:
                truth = np.array([each.case.truth[0] for each in verdicts])
                row |= scored(told, truth, rng)
            found.append(row)
    return found


def scored(told: Array, truth: Array, rng: np.random.Generator) -> JSON:
    """Return how often the most probable model is right, and how well that is foreseen."""
    best, sure = told.argmax(axis=1), told.max(axis=1)
    right = best == truth
    own = told[np.arange(len(truth)), truth]
    # What chance alone makes of as many cases if every probability is true.
    floor = [calibration(sure, rng.random(len(sure)) < sure) for _ in range(200)]
    return {
        "right": float(right.mean()),
        "shuffled": float((best == rng.permutation(truth)).mean()),
        "calibration": calibration(sure, right),
        "by_chance": float(np.mean(floor)),
        "log_loss": float(-np.log(np.maximum(own, 1e-300)).mean()),
    }


def calibration(sure: Array, right: Array) -> float:
    """Return the expected calibration error of answers given with some confidence.

    Source: Naeini, Cooper and Hauskrecht 2015, AAAI, ten bins of equal width.
    """
    bins = np.minimum((sure * BINS).astype(int), BINS - 1)
    gaps = [
        abs(float(right[bins == each].sum()) - float(sure[bins == each].sum()))
        for each in range(BINS)
    ]
    return sum(gaps) / len(sure)
