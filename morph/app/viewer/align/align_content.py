"""Tables and sentences about a hop, in the reports' words."""

from __future__ import annotations

import math

from morph.app.report.align.words import VERDICTS, lost_said, quality_rows, sure
from morph.app.report.transfer.words import CONTROLS, NAMED, ORDER, credit, saved
from morph.app.report.words import percent
from morph.app.viewer.align.lines import COMMANDS, SAME, STATES, TURNED, arrows
from morph.app.viewer.align.transfer_record import Story, Told
from morph.app.viewer.content import CellTable, Colour, Marked
from morph.policy_transfer.parts import Arrow
from morph.policy_transfer.transfer_record import GuardRecord

WORDS = {"safe": "safe", "unsafe": "unsafe", "unsure": "cannot tell"}
"""The guard's verdicts, for those who have not read its page."""

MOST_ROWS = 40
"""Rows of a table of parts; the report has them all."""

BADGES: dict[str, Colour] = {
    "safe": (0, 130, 90),
    "unsafe": (200, 40, 30),
    "unsure": (200, 140, 0),
}
"""Colours of the verdicts; the word stands beside."""


def verdict(content: Told) -> str:
    """Return the guard's verdict on a hop in a sentence, with its reason if one is told."""
    guard = content.guard
    called = "cannot tell of" if guard.verdict == "unsure" else f"calls it {guard.verdict} on"
    words = f"The guard {called} {content.target}: {VERDICTS[guard.verdict]}, {sure(guard)}."
    return (
        f"{words} {content.why[:1].upper()}{content.why[1:].rstrip('.')}." if content.why else words
    )


def chain_table(story: Story) -> CellTable:
    """Return the hops of a chain in a row each: its scores, and the guard's verdict."""
    rows: list[tuple[str | Marked, ...]] = []
    for number, hop in enumerate(story.hops, 1):
        scores = (score(hop, name) for name in ("zero_shot", "final", "no_source"))
        rows.append((f"{number} {hop.target}", *scores, _badge(hop.guard)))
    head = ("hop to", "map alone", "made anew", "no source", "guard")
    return CellTable(title=f"The chain from {story.chain[0]}", head=head, rows=tuple(rows))


def hop_tables(content: Told) -> tuple[CellTable, ...]:
    """Return the tables of a hop: its parts, what the guard says, its scores, its map."""
    results = [
        _guard(content),
        _parts(content, STATES, f"states of {content.target} as those of {content.source}"),
        _parts(content, COMMANDS, f"commands of {content.target} as those of {content.source}"),
        _scores(content),
        _map(content),
    ]
    return tuple(each for each in results if each.rows)


def hop_notes(content: Told) -> tuple[str, ...]:
    """Return what is to be known of a hop."""
    results = [lost_said(content.parts, content.target)]
    if content.crossing is not None:
        results += [credit(content.crossing), saved(content.crossing)]
    return tuple(each for each in (*results, *content.notes) if each)


def score(content: Told, name: str) -> str:
    """Return a score as a share of what the oracle gains, or what is known instead."""
    value = content.scores.get(name)
    return "–" if value is None else f"{value:.2f}"


def worth(content: Told) -> str:
    """Return in a word what the source was worth at a hop, by the report's own judgement."""
    hop = content.crossing
    if hop is None or not any(name in hop.measured for name in CONTROLS):
        return "not measured"
    return "no gain" if credit(hop) else "a gain"


def _parts(content: Told, sort: str, title: str) -> CellTable:
    result = arrows(content, sort)
    rows: list[tuple[str | Marked, ...]] = [
        (
            arrow.begin,
            arrow.end,
            _way(arrow),
            f"{100.0 * abs(arrow.weight):.0f}\N{NO-BREAK SPACE}%",
        )
        for arrow in result[:MOST_ROWS]
    ]
    if len(result) > MOST_ROWS:
        rows.append((f"and {len(result) - MOST_ROWS} more", "", "", ""))
    head = ("source", "target", "way", "share")
    return CellTable(title=title, head=head, rows=tuple(rows))


def _guard(content: Told) -> CellTable:
    guard = content.guard
    rows = (
        ("before a trial", _badge(guard)),
        ("sure that it does no harm", _share(guard.probability)),
    )
    return CellTable(title=f"The guard on {content.target}", head=("", ""), rows=rows)


def _badge(guard: GuardRecord) -> Marked:
    return Marked(text=WORDS[guard.verdict], colour=BADGES[guard.verdict])


def _way(arrow: Arrow) -> Marked:
    if arrow.weight > 0.0:
        return Marked(text="the same way", colour=SAME)
    return Marked(text="turned round", colour=TURNED)


def _scores(content: Told) -> CellTable:
    if not content.scores:
        return CellTable(title="", head=(), rows=())
    hop = content.crossing
    rows: list[tuple[str, ...]] = []
    for name in ORDER:
        there = hop is not None and name in hop.measured
        if name not in content.scores and not there:
            continue
        measured = "–" if hop is None or not there else _number(hop.measured[name])
        if name not in content.scores and hop is not None and there:
            share = float(hop.relative(hop.measured[name]))
            rows.append((NAMED[name], f"{share:.2f}" if math.isfinite(share) else "–", measured))
        else:
            rows.append((NAMED[name], score(content, name), measured))
    rows.append(("what the source was worth", worth(content), ""))
    head = ("policy", "share of oracle", "task's score")
    return CellTable(title=f"Scores on {content.target}", head=head, rows=tuple(rows))


def _map(content: Told) -> CellTable:
    rows = [("sort of map", content.mapper), ("transitions of the target", str(content.samples))]
    rows += quality_rows(content.quality)
    return CellTable(
        title="The map, on what it was not learned from", head=("", ""), rows=tuple(rows)
    )


def _share(value: float | None) -> str:
    if value is None:
        return "no probability"
    return percent(value)


def _number(value: float) -> str:
    return f"{value:.3f}" if math.isfinite(value) else "–"
