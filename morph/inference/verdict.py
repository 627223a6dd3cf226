"""The answer: held-out runs are opened once, and what was found is put together."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.inference.findings import findings, suspects
from morph.inference.intervals import factors
from morph.inference.rank import Ranking
from morph.inference.refit import Refit, seen
from morph.inference.remains import MOST_UNKNOWN, Remains, remaining
from morph.model.corrected import corrected, data, notes, provenance
from morph.model.diagnosis import Diagnosis, Unexplained
from morph.model.episodes import Episode
from morph.model.finding import Change, Estimate, Finding
from morph.model.hypothesis import Hypothesis
from morph.model.locate import locate
from morph.model.pieces import stretches
from morph.model.residual import LearnedResidual, hinges_and_slides, learned
from morph.model.score import by_segment, improvement_low90, rmse, rollouts, traces
from morph.model.segments import Segments
from morph.model.split import Split

RESIDUAL_SECONDS = 80.0
"""Seconds of motion that a residual is learned from, and states are looked at."""
NONE = 0.65
"""Most probability that nothing is missing: masses and gains within their uncertainty may hide what
is. Set by hand on development cases of `experiments.concealed`."""
LEAST = 0.01
"""Least probability of a single effect that is listed where none is found."""
WITH_RESIDUAL = "corrected_plus_residual"
"""Name of the corrected model with a learned residual."""


@dataclass(frozen=True, kw_only=True)
class DiagnosisRuns:
    """Runs as they are used, and settings of a diagnosis."""

    train: Sequence[Episode]
    """Fitted."""
    aside: Sequence[Episode]
    """Held out."""
    scored: Segments
    """Their rollouts."""
    split: Split
    """How they were set apart."""
    horizon: float | None
    """Seconds of those rollouts; None for whole episodes."""
    still: Sequence[str]
    """Joints that no training run moves."""
    changes: tuple[Change, ...] = ()
    """When the robot changed."""
    seed: int
    """Random seed."""
    started: float
    """When the diagnosis began, s of the monotonic clock."""


def conclude(nominal: Hypothesis, ranking: Ranking, parts: DiagnosisRuns) -> Diagnosis:
    """Return the diagnosis: verdict, findings, held-out errors, corrected model."""
    robot, best, refit = nominal.robot, ranking.best.refit, ranking.none.refit
    remains = remaining(ranking.best, ranking.validation)
    residual = _residual(ranking, parts) if remains.probability > 0.5 else None
    results = findings(ranking, remains)
    models = {
        "nominal": (nominal, nominal.start),
        "refitted": (refit.hypothesis, refit.point),
        "corrected": (best.hypothesis, best.point),
    }
    if residual is not None:
        more = replace(best.hypothesis, effects=(*best.hypothesis.effects, residual))
        models[WITH_RESIDUAL] = (more, best.point)
    predicted, errors, worse = _scored(models, parts.scored)
    # The training runs speak for the findings and the held-out runs against them.
    refuted = worse and bool(results)
    results = tuple(map(_halved, results)) if refuted else results
    unit = np.maximum(errors["nominal"], parts.scored.noise)
    before, after = (by_segment(parts.scored, predicted[m], unit) for m in ("nominal", "corrected"))
    beside, mjcf = corrected(*models["nominal" if worse else "corrected"])
    if worse:
        beside = ()
    own = {} if worse else factors(ranking.best.about)
    episodes = (*parts.train, *parts.aside)
    recordings = (*parts.split.train, *parts.split.held_out)
    return Diagnosis(
        robot=robot.name,
        verdict=_verdict(results, remains, refuted=refuted),
        findings=tuple(_begun(each, parts.changes) for each in results),
        changes=parts.changes,
        located=locate(
            refit.hypothesis,
            refit.point,
            stretches(parts.aside, RESIDUAL_SECONDS),
            parts.scored,
            predicted["refitted"],
        ),
        probabilities=_probabilities(ranking, results, remains, refuted=refuted),
        unexplained=Unexplained(
            probability=remains.probability,
            share=remains.share,
            channels=remains.channels,
            in_noise=remains.in_noise,
            contact=remains.touching,
        ),
        horizon=parts.horizon,
        train=_names(parts.train),
        held_out=_names(parts.aside),
        split=parts.split.how,
        held_out_rmse=_table(errors, parts.scored),
        improvement_low90=improvement_low90(before, after, parts.seed),
        refit=own,
        traces=traces(
            parts.scored,
            {model: predicted[model] for model in ("nominal", "refitted", "corrected")},
        ),
        data=data(recordings, fitted=len(ranking.validation.segments), scored=len(parts.scored)),
        overstated=() if worse else _overstated(best),
        notes=(*doubts(results, own, robot), *notes(recordings, episodes, parts.still)),
        provenance=provenance(robot, recordings),
        seconds=time.monotonic() - parts.started,
        seed=parts.seed,
        candidates_tried=len(ranking.search.prior.alone),
        stopped_short=ranking.stopped,
        corrected=mjcf,
        corrected_effects=beside,
        residual=residual.content() if residual is not None and WITH_RESIDUAL in errors else {},
    )


def _scored(
    models: Mapping[str, tuple[Hypothesis, Array]], scored: Segments
) -> tuple[dict[str, Array], dict[str, Array], bool]:
    """Return predictions and errors of models over held-out runs, by the models' names.

    The corrected model is never worse than the description on runs that neither has seen: where it
    would be, which is the third thing returned, the description stands for it.
    """
    starts = {}
    if scored.guess.any():
        starts = {name: _smoothed_start(*model, scored) for name, model in models.items()}
    predicted = rollouts(models, scored, starts)
    errors = {name: rmse(scored, values) for name, values in predicted.items()}
    unit = np.maximum(errors["nominal"], scored.noise)
    nominal, own = (np.mean((errors[name] / unit) ** 2) for name in ("nominal", "corrected"))
    if worse := bool(own > nominal):
        errors["rejected"] = errors["corrected"]
        predicted["corrected"], errors["corrected"] = predicted["nominal"], errors["nominal"]
        # It was learned beside the corrected model, and goes with it. No other held-out error
        # decides about it: an error that chose a model is no measure of that model.
        errors.pop(WITH_RESIDUAL, None)
    return predicted, errors, worse


def _smoothed_start(hypothesis: Hypothesis, point: Array, scored: Segments) -> Array:
    """Return starts of which joints that were not read are where a model smooths them to be."""
    laws = tuple(each for each in hypothesis.effects if not isinstance(each, LearnedResidual))
    runs = seen(replace(hypothesis, effects=laws), point, scored.episodes)
    start, places = scored.start.copy(), scored.start.shape[1] - len(scored.guess)
    unread = np.flatnonzero(scored.guess > 0.0)
    for row, (episode, first) in enumerate(zip(scored.episode, scored.first, strict=True)):
        about = runs[episode].about
        start[row, unread] = about.position[first, unread]
        start[row, places + unread] = about.velocity[first, unread]
    return start


def _overstated(best: Refit) -> tuple[str, ...]:
    """Return the figures of joints that are refitted to less than `--vary` lets them be."""
    own = zip(best.hypothesis.knobs, best.point, strict=False)
    return tuple(
        f"The description's {knob.what} of joint {knob.part} is too great: the recordings show "
        f"{math.exp(value):.2g} of it."
        for knob, value in own
        if knob.freed and value < -1.05 * math.log1p(knob.fraction)
    )


def doubts(
    results: Sequence[Finding], own: Mapping[str, Estimate], robot: Robot
) -> tuple[str, ...]:
    """Return what else findings may stand for, in words.

    Args:
        results: The findings.
        own: The description's own parameters, by name.
        robot: The robot.
    """
    lines = []
    for law, parts, late, other in (
        ("actuator_delay", len(robot.actuators), "commands", "readings"),
        ("timestamp_offset", len(robot.joints), "readings", "commands"),
    ):
        times = [each.parameters["T"] for each in results if each.effect.name == law]
        if len(times) < max(2, parts):
            continue
        if max(each.low90 for each in times) <= min(each.high90 for each in times):
            when = 1e3 * float(np.mean([each.value for each in times]))
            way = "late" if when > 0.0 else "early"
            lines.append(
                f"All {late} are {way} by the same {abs(when):.3g} ms: with all {other} {way} by "
                "as much the motion looks the same. It may be one clock against another."
            )
    ends = [name for name, each in own.items() if each.bounded and not each.prior_only]
    if results and ends:
        lines.append(
            f"Refitted as far as --vary allows: {', '.join(ends)}. A load or another part may be "
            "there, and what was named may stand for what these cannot reach. To allow more: "
            f"--vary {' '.join(f'{name}=0.3' for name in ends)}"
        )
    return tuple(lines)


def _names(episodes: Sequence[Episode]) -> tuple[str, ...]:
    """Return the names of the recordings, each once."""
    return tuple(dict.fromkeys(episode.recording.name for episode in episodes))


def _begun(finding: Finding, changes: Sequence[Change]) -> Finding:
    """Return a finding with the time at which its law began, where it did not act before."""
    for change in changes:
        same = change.since and change.after.label == finding.effect.label
        if same and change.begins:
            return replace(finding, onset=change.time)
    return finding


def _halved(finding: Finding) -> Finding:
    rivals = [replace(rival, probability=0.5 * rival.probability) for rival in finding.rivals]
    return replace(finding, probability=0.5 * finding.probability, rivals=tuple(rivals))


def _verdict(results: Sequence[Finding], remains: Remains, *, refuted: bool) -> str:
    if remains.probability > 0.5 or refuted:
        return "unknown"
    return "mismatch" if results else "consistent"


def _probabilities(
    ranking: Ranking, results: Sequence[Finding], remains: Remains, *, refuted: bool
) -> dict[str, float]:
    """Return the posterior of each effect, of `none` and of `unknown`."""
    unknown = max(remains.probability, MOST_UNKNOWN if refuted else 0.0)
    chances: dict[str, float] = {"none": 0.0, "unknown": unknown}
    for finding in results:
        chances[finding.effect.label] = finding.probability
    for finding in results:
        for rival in finding.rivals:
            label = f"{rival.effect}@{rival.where}"
            chances[label] = max(chances.get(label, 0.0), rival.probability)
    if not results:
        chances["none"] = min(NONE, 1.0 - remains.any_physics)
        missed = 1.0 - chances["none"] - unknown
        some = {label: missed * share for label, share in suspects(ranking).items()}
        chances |= {label: chance for label, chance in some.items() if chance >= LEAST}
    return chances


def _table(errors: Mapping[str, Array], scored: Segments) -> dict[str, dict[str, float]]:
    names, rows = scored.measurement.channels, {**errors, "noise_floor": scored.noise}
    return {model: {names[at]: float(row[at]) for at in scored.read} for model, row in rows.items()}


def _residual(ranking: Ranking, parts: DiagnosisRuns) -> LearnedResidual | None:
    """Return a residual learned beside the best model, if it surely lowers the error of rollouts.

    Training runs alone decide: each is predicted by a model and a residual fitted to the others,
    and where there are too few of them none is kept.
    """
    refit, validation = ranking.best.refit, ranking.validation
    if validation.blocks > 1 or not hinges_and_slides(refit.hypothesis.robot):
        return None
    episodes, losses = validation.segments.episodes, np.array(ranking.best.losses)
    for fold in np.unique(validation.fold):
        rest = sorted({int(e) for e in validation.segments.episode[validation.fold != fold]})
        point = ranking.best.about.without_fold(int(fold)).idle(range(len(refit.effects)))
        force = learned(
            refit.hypothesis,
            point,
            stretches([episodes[at] for at in rest], RESIDUAL_SECONDS),
            parts.seed,
        )
        more = replace(refit.hypothesis, effects=(*refit.hypothesis.effects, force))
        points = [point] * validation.folds
        inside = validation.fold == fold
        losses[inside] = validation.losses(more, [points], refit.runs)[0, inside]
    if not validation.sure(ranking.best.losses, losses):
        return None
    whole = stretches(parts.train, RESIDUAL_SECONDS)
    return learned(refit.hypothesis, refit.point, whole, parts.seed)
