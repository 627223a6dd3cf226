"""What a loop found, in plain words."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

from morph.app.report.words import counted, percent, plain
from morph.body.robot import Robot
from morph.model.kwik.certify import ModelVerdict
from morph.model.latent.parameter_attribution import Difference
from morph.physics import effect_class
from morph.physics.effect import SLIDING, Parameter
from morph.policy_transfer.loop import LoopRound
from morph.policy_transfer.predicted_return import PredictedReturn

FIGURES: Mapping[str, str] = {
    "length": "{part} is {factor} times as long",
    "weight": "{part} is {factor} times as heavy",
    "gravity": "gravity is {factor} times as strong",
    "gain": "{part} pushes {factor} times as hard",
    "damping": "{part} has {factor} times the damping",
    "armature": "{part} has {factor} times the armature",
    "frictionloss": "{part} has {factor} times the dry friction",
    "stiffness": "{part} is {factor} times as stiff",
}
"""What is said of each figure of a description."""

GATES: Mapping[str, str] = {
    "good": "good enough",
    "not good": "not good enough",
    "cannot say": "perhaps good enough",
}
"""What the gate's answers are called: is the model good enough where the target went?"""

ORIGINS: Mapping[str, str] = {
    "source": "the source's policy",
    "searched again": "searched again in the repaired model",
    "adjusted": "the source's policy, adjusted",
    "recorded": "recorded",
}
"""Where a policy comes from."""


def differences(results: Iterable[Difference], robot: Robot) -> tuple[str, ...]:
    """Return what differs: a sentence for each figure and each effect, without a full stop."""
    lines: list[str] = []
    effects: dict[str, list[Difference]] = {}
    for each in results:
        label, colon, _ = each.name.rpartition(":")
        if "@" in label and colon:
            effects.setdefault(label, []).append(each)
        else:
            lines.append(figure(each))
    return (*lines, *(_effect(label, parts, robot) for label, parts in effects.items()))


def figure(result: Difference) -> str:
    """Return by what factor a figure of the description is off."""
    what, _, part = result.name.partition(":")
    factor, low, high = told(result)
    sentence = FIGURES.get(what, "the {what} of {part} is {factor} times what is described")
    between = f" ({low} to {high})" if low else ""
    return sentence.format(what=what, part=part, factor=factor) + between


def _effect(label: str, parts: Sequence[Difference], robot: Robot) -> str:
    name, _, where = label.partition("@")
    known = {each.name: each for each in effect_class(name).parameters()}
    sizes = []
    for part in parts:
        symbol = part.name.rpartition(":")[2]
        value, low, high = told(part)
        unit = unit_of(known[symbol], where, robot) if symbol in known else ""
        size = f"{value}{unit}" + (f" ({low} to {high})" if low else "")
        # One of several parameters says nothing without its name.
        sizes.append(size if len(parts) == len(known) == 1 else f"{symbol} = {size}")
    return f"{where}: {plain(name)} {', '.join(sizes)} was left out"


def unit_of(known: Parameter, where: str, robot: Robot) -> str:
    """Return a parameter's unit at its place, after a space: on a slide it is another."""
    slides = any(joint.name == where and joint.kind == "slide" for joint in robot.joints)
    unit = SLIDING.get(known.unit, known.unit) if slides else known.unit
    return "" if unit == "-" else f" {unit}"


def told(result: Difference) -> tuple[str, str, str]:
    """Return a value and the ends of its interval with digits that tell the ends apart.

    The ends are empty where there is no interval.
    """
    half = 0.5 * (result.high90 - result.low90)
    if not (math.isfinite(half) and half > 0.0):
        return f"{result.value:.3g}", "", ""
    decimals = min(max(0, math.ceil(-math.log10(half))), 8)
    return (
        f"{result.value:.{decimals}f}",
        f"{result.low90:.{decimals}f}",
        f"{result.high90:.{decimals}f}",
    )


def truth(name: str, value: float, robot: Robot) -> str:
    """Return in what a target really differs, without an interval."""
    exact = Difference(name=name, value=value, low90=math.nan, high90=math.nan)
    return differences([exact], robot)[0].replace(" was left out", " acts")


def listed(lines: Sequence[str]) -> str:
    """Return sentences joined into one."""
    return "; ".join(lines) if lines else "nothing that the trials can tell"


def promised(foreseen: PredictedReturn | None) -> str:
    """Return what a policy promises."""
    if foreseen is None:
        return "nothing: the repaired model is not believed"
    share = percent(foreseen.success).replace("\N{NO-BREAK SPACE}", " ")
    return f"loss {foreseen.loss:.3g}, success {share}"


def gate(verdict: ModelVerdict) -> str:
    """Return whether a model was good enough for a trial."""
    return GATES[verdict.verdict]


def outcome_of(done: LoopRound) -> str:
    """Return what came of a trial in a word."""
    return "succeeded" if done.tried.experience.success else "failed"


def round_said(number: int, done: LoopRound, robot: Robot) -> tuple[str, ...]:
    """Return a trial and what was learned from it, in a few lines."""
    tried, advice = done.tried, done.advice
    first = (
        f"trial {number}: {ORIGINS.get(tried.origin, tried.origin)}: loss "
        f"{tried.experience.loss:.4g}, {outcome_of(done)} ({tried.experience.seconds:.3g} s)"
    )
    if advice is None:
        return (first,)
    lacked = differences(advice.repair.explained.differences, robot)
    lines = [
        first,
        f"  the model by which it was made was {gate(advice.verdict)}",
        f"  what differs from the description: {listed(lacked)}",
    ]
    if any(advice.policy is each for each in (tried.policy,)):
        lines.append(f"  to keep: this policy promises {promised(advice.foreseen)}")
    else:
        origin = ORIGINS.get(advice.origin, advice.origin)
        lines.append(f"  next: {origin}, promises {promised(advice.foreseen)}")
    lines.append(f"  computed in {done.seconds:.1f} s")
    return tuple(lines)


def ordinal(count: int) -> str:
    """Return `first`, `second`, ... in words, as far as a loop goes."""
    words = ("first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth")
    return words[count - 1] if count <= len(words) else f"{count}th"


def trials_said(count: int, seconds: float) -> str:
    """Return how much was tried."""
    together = " together" if count > 1 else ""
    return f"{counted(count, 'trial', 'trials')} of {seconds:.3g} s{together}"
