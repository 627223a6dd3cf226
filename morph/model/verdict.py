"""The answer: held-out runs are opened once, and what was found is put into words."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from importlib.metadata import version
from typing import Any

import numpy as np

from morph.arrays import JSON, Array
from morph.body.fulltext import fulltext
from morph.body.robot import Robot
from morph.model.conclude import Standing, experiment
from morph.model.diagnosis import Diagnosis, Estimate, Finding, Rival
from morph.model.episodes import Episode, stretches
from morph.model.fit import Fit
from morph.model.hypothesis import Hypothesis
from morph.model.locate import locate
from morph.model.residual import LearnedResidual, learned
from morph.model.score import by_segment, improvement_low90, rmse, rollouts, traces
from morph.model.search import Contender, Search
from morph.model.segments import Segments
from morph.model.select import Gain, gain
from morph.model.shooting import loss, predict
from morph.model.split import Split
from morph.physics.effect import Effect

FAR_FROM_NOISE = 4.0
"""Mean squared error, in units of the noise, above which something must be missing."""
NEAR_NOISE = 1.5
"""The same, below which nothing can be said to be missing."""
RESIDUAL_SECONDS = 80.0
"""Seconds of motion that a residual is learned from, and states are looked at."""
GENERIC = 0.2
"""Share of the loss that a learned residual must take away for `unknown` to be said."""


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """Everything that a verdict rests on."""

    robot: Robot
    nominal: Hypothesis
    refitted: Contender
    best: Contender
    stands: list[Standing]
    search: Search
    train: list[Episode]
    aside: list[Episode]
    scored: Segments
    split: Split
    horizon: float | None
    seed: int
    started: float


def conclude(e: Evidence) -> Diagnosis:
    """Return the diagnosis: verdict, findings, errors on runs never seen, corrected model."""
    residual, gained = _residual(e)
    models = {
        "nominal": (e.nominal, e.nominal.start),
        "refitted": (e.refitted.fit.hypothesis, e.refitted.fit.point),
        "corrected": (e.best.fit.hypothesis, e.best.fit.point),
    }
    if residual is not None and gained.sure and gained.mean >= 0.05:
        more = replace(
            e.best.fit.hypothesis, effects=(*e.best.fit.hypothesis.effects, residual)
        )
        models["corrected_plus_residual"] = (more, e.best.fit.point)
    predicted = rollouts(models, e.scored)
    errors = {name: rmse(e.scored, values) for name, values in predicted.items()}
    unit = np.maximum(errors["nominal"], e.scored.noise)
    # Never worse than the nominal model on runs that neither has seen.
    worse = bool(np.mean((errors["corrected"] / unit) ** 2) > np.mean((errors["nominal"] / unit) ** 2))
    verdict = _verdict(e, gained, worse)
    if "corrected_plus_residual" in errors and np.mean(
        (errors["corrected_plus_residual"] / unit) ** 2
    ) > np.mean((errors["corrected"] / unit) ** 2):
        residual = None
        errors.pop("corrected_plus_residual")
    names = [f"{joint.name}.position" for joint in e.robot.joints]
    table = {name: dict(zip(names, map(float, row), strict=True)) for name, row in errors.items()}
    table["noise_floor"] = dict(zip(names, map(float, e.scored.noise), strict=True))
    before, after = (by_segment(e.scored, predicted[m], unit) for m in ("nominal", "corrected"))
    drawn = {m: predicted[m] for m in ("nominal", "refitted", "corrected")}
    found = e.best.fit
    stepped, mjcf = _corrected(e, worse)
    return Diagnosis(
        robot=e.robot.name,
        verdict=verdict,
        findings=_findings(e),
        located=locate(
            e.refitted.fit.hypothesis,
            e.refitted.fit.point,
            stretches(e.aside, RESIDUAL_SECONDS),
            e.scored,
            predicted["refitted"],
        ),
        probabilities=_chances(e, verdict),
        horizon=e.horizon,
        train=tuple(episode.name for episode in e.train),
        held_out=tuple(episode.name for episode in e.aside),
        split=e.split.how,
        held_out_rmse=table,
        improvement_low90=improvement_low90(before, after, e.seed),
        refit=_factors(found),
        traces=traces(e.scored, drawn, [(j.name, j.unit) for j in e.robot.joints]),
        data=_data(e),
        notes=_notes(e),
        provenance=_provenance(e),
        seconds=time.monotonic() - e.started,
        seed=e.seed,
        candidates_tried=e.search.tries,
        stopped_short=e.search.late,
        corrected=mjcf,
        corrected_effects=stepped,
        residual={}
        if residual is None or "corrected_plus_residual" not in errors
        else {"joints": np.array(residual.joints), **residual.arrays},
    )


def _residual(e: Evidence) -> tuple[LearnedResidual | None, Gain]:
    """Return a residual learned beside the final model, and its cross-validated gain."""
    nothing = Gain(mean=0.0, low90=-np.inf)
    if e.search.late:
        return None, nothing
    found, segments, fold = e.best.fit, e.search.segments, e.search.fold
    if segments is not None and len(found.start) != len(segments):
        found = replace(found, start=segments.start, weight=np.ones(len(segments)))
    losses = np.empty(len(segments))
    before = np.empty(len(segments))
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
    whole = learned(
        found.hypothesis, found.point, stretches(e.train, RESIDUAL_SECONDS), e.seed
    )
    return whole, gain(before, losses, 1)


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
    found, segments = e.refitted.fit, e.search.segments
    start = found.start if len(found.start) == len(segments) else segments.start
    read = predict(found.hypothesis, segments, [found.point], [start])[0]
    return float(np.max((rmse(segments, read) / segments.noise) ** 2))


def _findings(e: Evidence) -> tuple[Finding, ...]:
    found = e.best.fit
    effects = found.hypothesis.effects_at(found.point)
    low, high = found.intervals()
    at = len(found.hypothesis.knobs)
    listed = []
    for index, effect in enumerate(effects):
        stand = e.stands[index] if index < len(e.stands) else None
        estimates = {}
        for known in effect.parameters():
            estimates[known.name] = Estimate(
                value=float(found.point[at]),
                low90=float(low[at]),
                high90=float(high[at]),
                unit=known.unit,
            )
            at += 1
        listed.append(_finding(e, effect, estimates, stand))
    return tuple(sorted(listed, key=lambda finding: -finding.gain))


def _finding(
    e: Evidence, effect: Effect, estimates: Mapping[str, Estimate], stand: Standing | None
) -> Finding:
    rivals: list[Rival] = []
    episodes: tuple[str, ...] = tuple(episode.name for episode in e.train)
    share, chance = 0.0, 0.5
    if stand is not None:
        chance = stand.chances[effect.label]
        by_label = {c.fit.hypothesis.effects[-1].label: c for c in stand.rivals}
        for label, contender in by_label.items():
            other = contender.fit.hypothesis.effects[-1]
            rivals.append(
                Rival(
                    effect=other.name,
                    kind=other.kind,
                    where=other.where,
                    probability=stand.chances[label],
                )
            )
        # The losses without the finding beside those of the best rival-free model.
        with_it = e.best.losses
        share = 1.0 - float(with_it.sum()) / float(stand.without.losses.sum() + 1e-30)
        fewer = [
            (e.train[i].name, float((stand.without.losses - with_it)[e.search.segments.episode == i].sum()))
            for i in range(len(e.train))
        ]
        episodes = tuple(name for name, less in fewer if less > 0.0)
    rivals.sort(key=lambda rival: -rival.probability)
    nearest = rivals[0].effect if rivals else (effect.twins[0] if effect.twins else "")
    return Finding(
        effect=effect,
        probability=chance,
        episodes=episodes,
        parameters=estimates,
        rivals=tuple(rivals),
        separate_by=experiment(effect, nearest),
        gain=share,
    )




def _chances(e: Evidence, verdict: str) -> dict[str, float]:
    chances = {"none": 0.0, "unknown": 0.0}
    if not e.best.fit.hypothesis.effects:
        chances["none"] = 1.0 if verdict == "consistent" else 0.0
        last = e.search.rounds[-1] if e.search.rounds else None
        if last is not None and last.finalists:
            best = last.finalists[0]
            wins = float(np.mean(_drawn(e, last.before.losses, best.losses)))
            label = best.fit.hypothesis.effects[-1].label
            # An effect that is not sure is as likely as it wins beyond a coin's toss.
            chances[label] = max(0.0, 2.0 * wins - 1.0) * 0.5
            rest = 1.0 - chances[label]
            chances["none" if verdict == "consistent" else "unknown"] = rest
        elif verdict == "unknown":
            chances["unknown"] = 1.0
        return chances
    for stand in e.stands:
        chances[stand.effect.label] = stand.chances[stand.effect.label]
        chances["none"] = max(chances["none"], 0.0)
    if e.stands:
        chances["none"] = min(stand.chances["none"] for stand in e.stands)
    chances["unknown"] = 1.0 if verdict == "unknown" else 0.0
    return chances


def _drawn(e: Evidence, before: Array, after: Array) -> Array:
    rng = np.random.default_rng(e.seed)
    draws = rng.integers(len(before), size=(2000, len(before)))
    return np.asarray(after[draws].sum(axis=1) < 0.98 * before[draws].sum(axis=1))


def _factors(found: Fit) -> dict[str, Estimate]:
    low, high = found.intervals()
    return {
        knob.name: Estimate(
            value=float(np.exp(found.point[i])),
            low90=float(np.exp(low[i])),
            high90=float(np.exp(high[i])),
            unit="-",
        )
        for i, knob in enumerate(found.hypothesis.knobs)
    }


def _corrected(e: Evidence, worse: bool) -> tuple[tuple[Effect, ...], str]:
    """Return the effects that MuJoCo cannot hold, and the description with all others."""
    found = e.best.fit
    if worse:
        spec = e.nominal.spec_at(e.nominal.start)
        spec.compile()
        return (), fulltext(spec)
    spec = found.hypothesis.spec_at(found.point)
    beside = []
    for effect in found.hypothesis.effects_at(found.point):
        if _held_by_mujoco(effect):
            effect.edit(spec)
        else:
            beside.append(effect)
    spec.compile()
    return tuple(beside), fulltext(spec)


def _held_by_mujoco(effect: Effect) -> bool:
    changes_signals = (
        type(effect).command is not Effect.command or type(effect).sense is not Effect.sense
    )
    return not effect.stepped and not changes_signals


def _data(e: Evidence) -> JSON:
    recordings = [episode.recording for episode in (*e.train, *e.aside)]
    notes = [note for recording in recordings for note in recording.notes]
    return {
        "samples": sum(recording.samples for recording in recordings),
        "dropped": sum(note.dropped for note in notes),
        "repaired": sum(note.repaired for note in notes),
        "duplicates": [],
        "rollouts_fitted": len(e.search.segments),
        "rollouts_scored": len(e.scored),
    }


def _notes(e: Evidence) -> tuple[str, ...]:
    said = [
        f"{note.where}: {note.what}"
        for episode in (*e.train, *e.aside)
        for note in episode.recording.notes
    ]
    for index, episode in enumerate(e.train):
        inside = e.search.segments.episode == index
        weight = e.best.fit.weight
        if len(weight) == len(inside) and inside.any():
            typical = float(np.median(weight))
            if float(np.median(weight[inside])) < 0.5 * typical:
                said.append(
                    f"{episode.name}: its error stays several times that of the others under "
                    "every model, so it was given less weight; look at its commands and clock."
                )
    return tuple(said)


def _provenance(e: Evidence) -> dict[str, Any]:
    return {
        "morph": version("morph"),
        "mujoco": version("mujoco"),
        "robot_sha256": e.robot.sha256,
        "recordings_sha256": {
            episode.name: episode.recording.sha256 for episode in (*e.train, *e.aside)
        },
    }
