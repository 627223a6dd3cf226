"""The sentences and numbers that a reader meets before any figure."""

from __future__ import annotations

import math
from collections.abc import Mapping

from morph.model.diagnosis import Diagnosis
from morph.model.finding import Estimate

MODELS = {
    "nominal": "as given",
    "refitted": "refitted",
    "corrected": "corrected",
    "corrected_plus_residual": "with learned rest",
    "rejected": "corrected, rejected",
    "noise_floor": "sensor noise",
}
"""What a model is called on the page, in the order in which they are shown."""

PEOPLE = {"coulomb", "stribeck", "maxwell", "coriolis"}
"""Words of the vocabulary that are names of people."""

UNREAD = "was not read"
"""What notes say of a joint's position that is estimated."""

LIKELY = 0.5
"""Probability from which a finding counts in the headline."""

NAMED = 3
"""Channels named in a sentence; the table has them all."""


def number(value: float) -> str:
    """Return a number with three figures; a simulation that blew up has none."""
    return f"{value:.3g}" if math.isfinite(value) else "diverged"


def percent(share: float) -> str:
    """Return a share as a whole percentage that never claims to be 0 or 1 unless it is."""
    if 0.0 < share < 0.005:
        return "under 1\N{NO-BREAK SPACE}%"
    if 0.995 <= share < 1.0:
        return "over 99\N{NO-BREAK SPACE}%"
    return f"{100.0 * share:.0f}\N{NO-BREAK SPACE}%" if math.isfinite(share) else "not known"


def counted(count: int, one: str, many: str) -> str:
    """Return a count with its noun, small counts in words."""
    words = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine")
    return f"{words[count] if count < len(words) else count} {one if count == 1 else many}"


def plain(name: str) -> str:
    """Return a name of the vocabulary as words: `stribeck_friction` is Stribeck friction."""
    words = name.replace("_", " ").split(" ")
    return " ".join(word.capitalize() if word in PEOPLE else word for word in words)


def answer(name: str) -> str:
    """Return one of the answers that have a probability, in words."""
    if name in {"none", "unknown"}:
        return {"none": "nothing left out", "unknown": "something not explained"}[name]
    # Only the effect is of the vocabulary; the part keeps the name that its file gives it.
    effect, at, where = name.partition("@")
    return f"{plain(effect)} at {where}" if at else name


def headline(diagnosis: Diagnosis) -> str:
    """Return the verdict as a headline."""
    if diagnosis.changes and not diagnosis.findings:
        return "The robot changed during these recordings"
    if diagnosis.verdict == "consistent" and diagnosis.overstated:
        return "The simulation and the robot agree once a joint's figures are corrected"
    if diagnosis.verdict == "consistent":
        return "No difference shows in these recordings"
    if diagnosis.verdict == "mismatch" and diagnosis.findings:
        likely = sum(finding.probability >= LIKELY for finding in diagnosis.findings)
        if not likely:
            return "Something was perhaps left out of the simulation"
        pieces, were = counted(likely, "thing", "things"), "was" if likely == 1 else "were"
        more = ", and perhaps more" if likely < len(diagnosis.findings) else ""
        return f"{pieces.capitalize()} {were} left out of the simulation{more}"
    if "rejected" in diagnosis.held_out_rmse:
        return "They differ, and no correction holds on held-out runs"
    if diagnosis.findings:
        return "They differ by more than what was named"
    return "They differ, and what is missing was not found"


def units(diagnosis: Diagnosis) -> dict[str, str]:
    """Return each channel's unit, so far as a plotted rollout tells it."""
    return {trace.channel: trace.unit for trace in diagnosis.traces}


def channels(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Return every channel that has an error, those with the largest share first."""
    known: dict[str, None] = dict.fromkeys(diagnosis.located.channels)
    for by_channel in diagnosis.held_out_rmse.values():
        known.update(dict.fromkeys(by_channel))
    return tuple(known)


def rollouts(horizon: float | None) -> str:
    """Return how the errors were taken, in words."""
    if horizon is None:
        return "simulated over whole episodes without looking at the recording"
    return f"simulated {horizon:g} s at a time without looking at the recording"


def improvement(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Return in words how wrong each model is on the runs that it never saw."""
    if not diagnosis.held_out or "nominal" not in diagnosis.held_out_rmse:
        return ()
    runs = counted(len(diagnosis.held_out), "run", "runs")
    rejected = "rejected" in diagnosis.held_out_rmse
    changed = bool(diagnosis.findings) and not rejected and "corrected" in diagnosis.held_out_rmse
    model = "corrected" if changed else "nominal"
    name = "the corrected simulation" if changed else "the simulation as given"
    errors = [error for c in channels(diagnosis) if (error := _error(diagnosis, model, c))]
    rest = f", and {len(errors) - NAMED} more channels below" if len(errors) > NAMED else ""
    lines = [f"On {runs} that it never saw, {name} is off by {'; '.join(errors[:NAMED])}{rest}."]
    if changed and math.isfinite(diagnosis.improvement_low90):
        gone = percent(diagnosis.improvement_low90)
        least = gone.capitalize() if gone.startswith("over") else f"At least {gone}"
        lines.append(f"{least} of the squared error is gone, with 90 % confidence.")
    return tuple(lines) if errors else ()


def limited(estimate: Estimate) -> str:
    """Return what a reader of an estimate has to know beside its interval, in brackets."""
    if estimate.prior_only:
        return " (not determined by these runs)"
    return " (at its bound)" if estimate.bounded else ""


def remains(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Return what the answer does not explain, in words."""
    left, rmse = diagnosis.unexplained, diagnosis.held_out_rmse
    unsure = percent(left.probability)
    lines = [f"Physics that was not named remains with a probability of {unsure}."]
    worst = sorted(left.channels.items(), key=lambda each: -each[1])[:NAMED]
    forces = ", ".join(
        f"{_share(share)} % at {name.removesuffix('.position')}" for name, share in worst
    )
    if forces:
        lines.append(f"Force that is missing still, as a share of the inertial force: {forces}.")
    if left.contact:
        lines.append(
            "The robot touches a floor or the stops of its joints: of these forces rollouts alone "
            "tell."
        )
    lines.append(
        f"Rollouts of a typical fitted segment err by {number(math.sqrt(left.in_noise))} times the "
        "sensors' noise, RMS; a right model's by about 1, or by many times as much where small "
        "errors of their starts grow, as of an arm that stands upright."
    )
    if any(UNREAD in note for note in diagnosis.notes):
        lines.append(
            "The motion of joints that were not read is estimated: where the estimate is wrong it "
            "looks like missing physics."
        )
    noise, error = (rmse.get(model, {}) for model in ("noise_floor", "corrected"))
    ratios = [error[name] / noise[name] for name in error if noise.get(name, 0.0) > 0.0]
    if ratios:
        low, high = number(min(ratios)), number(max(ratios))
        span = low if low == high else f"{low} to {high}"
        lines.append(f"Held-out errors are {span} times that noise, RMS.")
    return tuple(lines)


def _share(share: float) -> str:
    """Return a share of the inertial force in per cent; a filter tells of none below its floor."""
    from morph.inference.sampled import FLOOR

    if share > 1.0:
        return "over 100"
    # The RMS inertial force that it is a share of differs a little from one motion to another.
    return f"under {number(100.0 * FLOOR)}" if share < 1.1 * FLOOR else number(100.0 * share)


def _error(diagnosis: Diagnosis, model: str, channel: str) -> str:
    """Return one channel's error and what to compare it with; empty without one."""
    by_model: Mapping[str, Mapping[str, float]] = diagnosis.held_out_rmse
    if channel not in by_model.get(model, {}):
        return ""
    unit = units(diagnosis).get(channel, "")
    others = [
        f"{MODELS[other]} {number(by_model[other][channel])}"
        for other in MODELS
        if other in {"nominal", "refitted", "noise_floor"} - {model}
        and channel in by_model.get(other, {})
    ]
    value = f"{number(by_model[model][channel])} {unit}".rstrip()
    return f"{value} at {channel}" + (f" ({', '.join(others)})" if others else "")
