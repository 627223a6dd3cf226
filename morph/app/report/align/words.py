"""What an alignment found, in plain words."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from morph.app.report.align.outcome import Aligned
from morph.app.report.words import counted, percent
from morph.policy_transfer.parts import Arrow, Parts
from morph.policy_transfer.transfer_record import GuardRecord

QUALITY: Mapping[str, str] = {
    "round_trip": "states there and back, off by so many spreads",
    "command_round_trip": "commands there and back, off by so many spreads",
    "one_step": "share of one step that the source's dynamics do not foresee",
    "many_steps": "the same over several steps",
    "steps": "how many those are",
}
"""What each number of a map's quality is called."""

MINUS = "\N{MINUS SIGN}"
"""Of a part that is turned round."""

ROUNDING = 1e-9
"""Below which a figure is only what numbers of so many digits leave over."""

VERDICTS: Mapping[str, str] = {
    "safe": "it is safe to try",
    "unsafe": "it is not safe to try",
    "unsure": "nobody can say yet whether it is safe to try",
}
"""What is said of the guard's verdicts."""


def headline(result: Aligned) -> str:
    """Return what was found."""
    return f"{result.target.body} is seen as {result.source.body}"


def summary(result: Aligned) -> tuple[str, ...]:
    """Return in a few sentences how the map was learned and what is thought of it."""
    here, there = result.samples
    lines = [
        f"The map {result.mapper} was learned from {counted(there, 'transition', 'transitions')} "
        f"of {result.target.body} and {here} of {result.source.body}.",
        guard_said(result.guard),
    ]
    if result.why:
        lines.append(f"{result.why[:1].upper()}{result.why[1:].rstrip('.')}.")
    return tuple(lines)


def guard_said(guard: GuardRecord) -> str:
    """Return the guard's verdict with its probability."""
    words = f"The guard calls the source's policy seen through it {guard.verdict}"
    return f"{words}: {VERDICTS[guard.verdict]}, {sure(guard)}."


def sure(guard: GuardRecord) -> str:
    """Return how sure the guard is that a policy does no harm."""
    if guard.probability is None:
        return "and there is no probability"
    share = percent(guard.probability).replace("\N{NO-BREAK SPACE}", " ")
    return f"{share} sure that it does no harm"


def quality_rows(quality: Mapping[str, float]) -> list[tuple[str, str]]:
    """Return each number of a map's quality with what it is called."""
    return [(QUALITY.get(name, name.replace("_", " ")), short(x)) for name, x in quality.items()]


def short(value: float) -> str:
    """Return a number with three figures."""
    if abs(value) < ROUNDING:
        return "0"
    return f"{value:.3g}" if math.isfinite(value) else "none"


def made_of(arrows: Sequence[Arrow]) -> Iterator[tuple[str, str]]:
    """Yield each number that is made, and what it is made of, the strongest first."""
    for end in dict.fromkeys(arrow.end for arrow in arrows):
        parts = [
            f"{MINUS if arrow.weight < 0.0 else '+'} {arrow.begin} "
            f"({100.0 * abs(arrow.weight):.0f} %)"
            for arrow in arrows
            if arrow.end == end
        ]
        yield end, ", ".join(parts)


def lost_said(parts: Parts, target: str) -> str:
    """Return which parts of the target play no role, in a sentence; empty if there is none."""
    if not parts.lost:
        return ""
    plays = "plays" if len(parts.lost) == 1 else "play"
    return f"Of {target} {', '.join(parts.lost)} {plays} no role in it."
