"""Tables and sentences about a hop, in the words of the reports."""

from __future__ import annotations

import math

from morph.app.report.align.words import VERDICTS, lost_said, quality_rows, sure
from morph.app.report.transfer.words import CONTROLS, NAMED, ORDER, credit, saved
from morph.app.report.words import percent
from morph.app.viewer.align.lines import COMMANDS, SAME, STATES, TURNED, arrows
from morph.app.viewer.align.story import Story, Told
from morph.app.viewer.content import CellTable, Colour, Marked
from morph.transfer.parts import Arrow
from morph.transfer.record import GuardRecord

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


def verdict(told: Told) -> str:
    """Return the guard's verdict on a hop in a sentence, with its reason if one is told."""
    guard = told.guard
    called = "cannot tell of" if guard.verdict == "unsure" else f"calls it {guard.verdict} on"
    words = f"The guard {called} {told.target}: {VERDICTS[guard.verdict]}, {sure(guard)}."
    return f"{words} {told.why[:1].upper()}{told.why[1:].rstrip('.')}." if told.why else words


def chain_table(story: Story) -> CellTable:
    """Return the hops of a chain in a row each: its scores, and the guard's verdict."""
    rows: list[tuple[str | Marked, ...]] = []
    for number, hop in enumerate(story.hops, 1):
        scores = (score(hop, name) for name in ("zero_shot", "final", "no_source"))
        rows.append((f"{number} {hop.target}", *scores, _badge(hop.guard)))
    head = ("hop to", "map alone", "made anew", "no source", "guard")
    return CellTable(title=f"The chain from {story.chain[0]}", head=head, rows=tuple(rows))


def hop_tables(told: Told) -> tuple[CellTable, ...]:
    """Return the tables of a hop: its parts, what the guard says, its scores, its map."""
    found = [
        _guard(told),
        _parts(told, STATES, f"{told.target} is seen as {told.source}"),
        _parts(told, COMMANDS, f"{told.target} is told for {told.source}"),
        _scores(told),
        _map(told),
    ]
    return tuple(each for each in found if each.rows)


def hop_notes(told: Told) -> tuple[str, ...]:
    """Return what is to be known of a hop."""
    found = [lost_said(told.parts, told.target)]
    if told.crossing is not None:
        found += [credit(told.crossing), saved(told.crossing)]
    return tuple(each for each in (*found, *told.notes) if each)


def score(told: Told, name: str) -> str:
    """Return a score as a share of what the oracle gains, or what is known instead."""
    value = told.scores.get(name)
    return "–" if value is None else f"{value:.2f}"


def worth(told: Told) -> str:
    """Return in a word what the source was worth at a hop, by the report's own judgement."""
    hop = told.crossing
    if hop is None or not any(name in hop.measured for name in CONTROLS):
        return "not measured"
    return "no gain" if credit(hop) else "a gain"


def _parts(told: Told, sort: str, title: str) -> CellTable:
    found = arrows(told, sort)
    rows: list[tuple[str | Marked, ...]] = [
        (
            arrow.begin,
            arrow.end,
            _way(arrow),
            f"{100.0 * abs(arrow.weight):.0f}\N{NO-BREAK SPACE}%",
        )
        for arrow in found[:MOST_ROWS]
    ]
    if len(found) > MOST_ROWS:
        rows.append((f"and {len(found) - MOST_ROWS} more", "", "", ""))
    head = ("source", "target", "way", "share")
    return CellTable(title=title, head=head, rows=tuple(rows))


def _guard(told: Told) -> CellTable:
    guard = told.guard
    rows = (
        ("before a trial", _badge(guard)),
        ("sure that it does no harm", _share(guard.probability)),
    )
    return CellTable(title=f"The guard on {told.target}", head=("", ""), rows=rows)


def _badge(guard: GuardRecord) -> Marked:
    return Marked(text=WORDS[guard.verdict], colour=BADGES[guard.verdict])


def _way(arrow: Arrow) -> Marked:
    if arrow.weight > 0.0:
        return Marked(text="the same way", colour=SAME)
    return Marked(text="turned round", colour=TURNED)


def _scores(told: Told) -> CellTable:
    if not told.scores:
        return CellTable(title="", head=(), rows=())
    hop = told.crossing
    rows: list[tuple[str, ...]] = []
    for name in ORDER:
        there = hop is not None and name in hop.measured
        if name not in told.scores and not there:
            continue
        measured = "–" if hop is None or not there else _number(hop.measured[name])
        if name not in told.scores and hop is not None and there:
            share = float(hop.relative(hop.measured[name]))
            rows.append((NAMED[name], f"{share:.2f}" if math.isfinite(share) else "–", measured))
        else:
            rows.append((NAMED[name], score(told, name), measured))
    rows.append(("what the source was worth", worth(told), ""))
    head = ("policy", "share of oracle", "task's score")
    return CellTable(title=f"Scores on {told.target}", head=head, rows=tuple(rows))


def _map(told: Told) -> CellTable:
    rows = [("sort of map", told.mapper), ("transitions of the target", str(told.samples))]
    rows += quality_rows(told.quality)
    return CellTable(
        title="The map, on what it was not learned from", head=("", ""), rows=tuple(rows)
    )


def _share(value: float | None) -> str:
    if value is None:
        return "no probability"
    return percent(value)


def _number(value: float) -> str:
    return f"{value:.3f}" if math.isfinite(value) else "–"
