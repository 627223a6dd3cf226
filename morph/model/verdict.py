"""The answer: held-out runs are opened once, and what was found is put into words."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from morph.arrays import Array
from morph.model.corrected import corrected, data, notes, provenance
from morph.model.crossvalidate import MATERIAL, Gain, gain
from morph.model.diagnosis import Diagnosis
from morph.model.episodes import stretches
from morph.model.evidence import Evidence
from morph.model.findings import chances, factors, findings
from morph.model.locate import locate
from morph.model.residual import LearnedResidual, learned
from morph.model.score import Models, by_segment, improvement_low90, rmse, rollouts, traces
from morph.model.shooting import loss, predict

FAR_FROM_NOISE = 4.0
"""Mean squared error, in units of the noise, above which something must be missing."""
NEAR_NOISE = 1.5
"""The same, below which nothing can be said to be missing."""
RESIDUAL_SECONDS = 80.0
"""Seconds of motion that a residual is learned from, and states are looked at."""
GENERIC = 0.2
"""Share of the loss that a learned residual must take away for `unknown` to be said."""


def conclude(e: Evidence) -> Diagnosis:
    """Return the diagnosis: verdict, findings, errors on runs never seen, corrected model."""
    residual, gained = _residual(e)
    predicted = rollouts(_models(e, residual if gained.sure else None), e.scored)
    errors = {name: rmse(e.scored, values) for name, values in predicted.items()}
    unit = np.maximum(errors["nominal"], e.scored.noise)

    def size(model: str) -> float:
        return float(np.mean((errors[model] / unit) ** 2))

    kept = "corrected_plus_residual"
    # Never worse than the nominal model on runs that neither has seen.
    worse = size("corrected") > size("nominal")
    if worse:
        predicted["corrected"], errors["corrected"] = predicted["nominal"], errors["nominal"]
        # It was learned beside the corrected model, and goes with it. No other held-out error
        # decides about it: an error that chose a model is no measure of that model.
        errors.pop(kept, None)
    verdict = _verdict(e, gained, worse)
    beside, mjcf = corrected(e, worse)
    before, after = (by_segment(e.scored, predicted[m], unit) for m in ("nominal", "corrected"))
    return Diagnosis(
        robot=e.robot.name,
        verdict=verdict,
        findings=findings(e),
        located=locate(
            e.refitted.fit.hypothesis,
            e.refitted.fit.point,
            stretches(e.aside, RESIDUAL_SECONDS),
            e.scored,
            predicted["refitted"],
        ),
        probabilities=chances(e, verdict),
        horizon=e.horizon,
        train=tuple(episode.name for episode in e.train),
        held_out=tuple(episode.name for episode in e.aside),
        split=e.split.how,
        held_out_rmse=_table(e, errors),
        improvement_low90=improvement_low90(before, after, e.seed),
        refit={} if worse else factors(e.best.fit),
        traces=traces(
            e.scored,
            {model: predicted[model] for model in ("nominal", "refitted", "corrected")},
            [(joint.name, joint.unit) for joint in e.robot.joints],
        ),
        data=data(e),
        notes=notes(e),
        provenance=provenance(e),
        seconds=time.monotonic() - e.started,
        seed=e.seed,
        candidates_tried=e.search.tries,
        stopped_short=e.search.stopped,
        corrected=mjcf,
        corrected_effects=beside,
        residual=residual.content() if residual is not None and kept in errors else {},
    )


def _models(e: Evidence, residual: LearnedResidual | None) -> Models:
    found = e.best.fit
    models = {
        "nominal": (e.nominal, e.nominal.start),
        "refitted": (e.refitted.fit.hypothesis, e.refitted.fit.point),
        "corrected": (found.hypothesis, found.point),
    }
    if residual is not None:
        more = replace(found.hypothesis, effects=(*found.hypothesis.effects, residual))
        models["corrected_plus_residual"] = (more, found.point)
    return models


def _table(e: Evidence, errors: dict[str, Array]) -> dict[str, dict[str, float]]:
    names = [f"{joint.name}.position" for joint in e.robot.joints]
    rows = {**errors, "noise_floor": e.scored.noise}
    return {model: dict(zip(names, map(float, row), strict=True)) for model, row in rows.items()}


def _residual(e: Evidence) -> tuple[LearnedResidual | None, Gain]:
    """Return a residual learned beside the final model, and its cross-validated gain.

    Training runs alone decide: the residual is used where this gain is sure.
    """
    nothing = Gain(mean=0.0, low90=-np.inf)
    if e.search.out_of_time():
        return None, nothing
    found, segments, fold = e.searched[1].fit, e.search.segments, e.search.fold
    losses = np.empty(len(segments))
    plain = predict(found.hypothesis, segments, [found.point], [found.start])[0]
    before = found.weight * loss(segments, plain, found.start, found.scale)
    for out in np.unique(fold):
        inside = sorted({int(i) for i in segments.episode[fold != out]}) or [0]
        episodes = stretches([e.train[i] for i in inside], RESIDUAL_SECONDS)
        force = learned(found.hypothesis, found.point, episodes, e.seed)
        more = replace(found.hypothesis, effects=(*found.hypothesis.effects, force))
        read = predict(more, segments, [found.point], [found.start])[0]
        with_force = found.weight * loss(segments, read, found.start, found.scale)
        losses[fold == out] = with_force[fold == out]
    whole = learned(found.hypothesis, found.point, stretches(e.train, RESIDUAL_SECONDS), e.seed)
    gained = gain(before, losses, 1)
    return whole, gained if gained.mean >= MATERIAL else nothing


def _verdict(e: Evidence, gained: Gain, worse: bool) -> str:
    if e.best.fit.hypothesis.effects:
        return "unknown" if worse else "mismatch"
    in_noise = _error_in_noise(e)
    if in_noise > FAR_FROM_NOISE:
        return "unknown"
    generic = gained.sure and gained.mean >= GENERIC
    return "unknown" if generic and in_noise > NEAR_NOISE else "consistent"


def _error_in_noise(e: Evidence) -> float:
    """Return the refitted model's mean squared training error in units of the noise."""
    found, segments = e.searched[0].fit, e.search.segments
    read = predict(found.hypothesis, segments, [found.point], [found.start])[0]
    return float(np.max((rmse(segments, read) / segments.noise) ** 2))
