"""The sentences that a reader of a loop's report meets first."""

from __future__ import annotations

from morph.app.report.learn.words import number
from morph.app.report.loop import words
from morph.app.report.loop.outcome import LoopOutcome
from morph.app.report.words import counted, percent, plain
from morph.arrays import JSON
from morph.model.latent.parameter_attribution import Difference
from morph.physics import effect_class
from morph.policy_transfer.score import SEARCHED

FAINT = 0.1
"""Share of a concealed value below which what was found of it is as good as nothing."""


def headline(outcome: LoopOutcome) -> str:
    """Return the verdict."""
    task, robot = outcome.task.name, outcome.task.robot.name
    if outcome.transferred is None:
        many = len(words.differences(outcome.differences, outcome.task.robot))
        if many == 0:
            return f"The recordings agree with the description of {robot}"
        return f"{robot} differs from its description in {counted(many, 'thing', 'things')}"
    if outcome.succeeded:
        return f"{robot} does {task} on the target in the {words.ordinal(outcome.kept)} trial"
    if outcome.stopped:
        return f"The loop stopped before {robot} did {task} on the target"
    return f"{robot} does not do {task} on the target yet"


def summary(outcome: LoopOutcome) -> tuple[str, ...]:
    """Return what was tried, what it promises and how good it is, in a few sentences."""
    if outcome.transferred is None:
        gate = () if outcome.gate is None else (outcome.gate.text,)
        return (*gate, "Nothing was tried and nothing was learned: recordings cannot be driven.")
    done = outcome.transferred
    lines = [_tried(outcome)]
    if done.foreseen is not None:
        share = percent(done.foreseen.success)
        lines.append(
            f"In the repaired model the policy to keep costs {number(done.foreseen.loss)} and "
            f"reaches every goal in {share} of noisy runs."
        )
    judged = outcome.judged
    if judged is not None:
        lines.append(
            f"On the target itself it costs {number(judged.final.mean)} and reaches every goal in "
            f"{percent(judged.final.share)} of {len(judged.final.loss)} noisy runs; the source's "
            f"policy costs {number(judged.source.mean)} there, holding still "
            f"{number(judged.still.mean)}{_oracle(outcome)}."
        )
    return tuple(lines)


def _tried(outcome: LoopOutcome) -> str:
    first, kept = outcome.runs[0], outcome.runs[outcome.kept - 1]
    trials = words.trials_said(len(outcome.runs), outcome.experience)
    seconds = 0.0 if outcome.transferred is None else outcome.transferred.seconds
    if kept is not first:
        text = f"In {trials} the loss went from {number(first.loss)} to {number(kept.loss)}"
    elif len(outcome.runs) == 1:
        text = f"In {trials} the source's policy cost {number(first.loss)}"
    else:
        text = f"Of {trials} that of the source's policy was the best, at {number(first.loss)}"
    return f"{text}; computing took {number(seconds)} s."


def _oracle(outcome: LoopOutcome) -> str:
    judged = outcome.judged
    if judged is None or judged.oracle is None:
        return ""
    if judged.best != SEARCHED:
        return ", and none that was searched on its true parameters does better than " + judged.best
    text = f"{number(judged.oracle.mean)} ({percent(judged.oracle.share)})"
    return f", and one that is searched on its true parameters {text}"


def rivals_said(outcome: LoopOutcome) -> tuple[str, ...]:
    """Return how probable the explanation is, and the next, in a sentence or none."""
    if outcome.repair is None or not outcome.repair.explained.rivals:
        return ()
    (first, share), *others = outcome.repair.explained.rivals
    text = f"most probable: {first} ({percent(share)})"
    return (f"{text}; then {others[0][0]} ({percent(others[0][1])})" if others else text,)


def sealed_rows(outcome: LoopOutcome) -> list[JSON]:
    """Return what was concealed beside what was found of it, in words; none if nothing was."""
    opened = outcome.opened()
    if opened is None:
        return []
    rows = []
    for each in opened["concealed"]:
        name, value = each["name"], each["value"]
        row = {"truth": words.truth(name, value, outcome.task.robot), "found": "", "interval": ""}
        result = _found(name, value, outcome)
        if result is None:
            rows.append({**row, "verdict": _missed(name, outcome)})
            continue
        difference, verdict = result
        middle, low, high = words.told(difference)
        interval = f"{low} to {high}" if low else ""
        rows.append({**row, "found": middle, "interval": interval, "verdict": verdict})
    return rows


def _found(name: str, value: float, outcome: LoopOutcome) -> tuple[Difference, str] | None:
    """Return what was found of something concealed, and the verdict; None if it is not named."""
    for each in outcome.differences:
        if each.name == name:
            return each, _verdict(value, each)
    alike = _alike(name, value, outcome)
    return None if alike is None else (alike, f"found as {plain(alike.name.partition('@')[0])}")


def beyond(outcome: LoopOutcome) -> tuple[str, ...]:
    """Return what was named beyond what was concealed, or what says the same."""
    opened = outcome.opened()
    if opened is None:
        return ()
    concealed = [(each["name"], each["value"]) for each in opened["concealed"]]
    alike = [_alike(name, value, outcome) for name, value in concealed]
    same = {each.name.rpartition(":")[0] for each in alike if each is not None}
    return tuple(name for name in opened["more"] if name.rpartition(":")[0] not in same)


def _verdict(value: float, result: Difference) -> str:
    """Return whether a difference that is named was found."""
    if "@" in result.name and _neutral(result.name) == 0.0:
        sign = -1.0 if value < 0.0 else 1.0
        if result.value * sign < FAINT * abs(value):
            # An interval that holds the truth may hold nothing at all as well.
            return "not found"
    return "found" if result.low90 <= value <= result.high90 else "found, outside the interval"


def _neutral(name: str) -> float | None:
    """Return the value at which a parameter, named as a finding names it, does nothing."""
    label, _, symbol = name.rpartition(":")
    known = effect_class(label.partition("@")[0]).parameters()
    return next(each.neutral for each in known if each.name == symbol)


def _alike(name: str, value: float, outcome: LoopOutcome) -> Difference | None:
    """Return what was found of an effect that becomes the concealed one, with the right value."""
    effect, at, rest = name.partition("@")
    for each in outcome.differences if at else ():
        other, _, place = each.name.partition("@")
        within = each.low90 <= value <= each.high90
        if place == rest and within and "@" in each.name and effect_class(other).simpler == effect:
            return each if _verdict(value, each) == "found" else None
    return None


def _missed(name: str, outcome: LoopOutcome) -> str:
    """Return what is said of a difference that was not named."""
    rivals = () if outcome.repair is None else outcome.repair.explained.rivals[1:]
    named = name.rpartition(":")[0] if "@" in name else name
    for what, share in rivals:
        if named in what.split(" + "):
            return f"not named; the rival {what} has it ({percent(share)})"
    near = [each.name for each in outcome.differences if _place(each.name) == _place(name)]
    return f"not named; {', '.join(near)} instead" if near else "not named"


def _place(name: str) -> str:
    """Return the part of which `length:pole` or `coulomb_friction@slide:c` speaks."""
    effect, at, rest = name.partition("@")
    return rest.rpartition(":")[0] if at else effect.partition(":")[2]
