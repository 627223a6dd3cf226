"""Whether tables and sentences say what the record says, in the report's own words."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from morph.app.report.transfer.words import credit
from morph.app.viewer.align.align_content import (
    chain_table,
    hop_notes,
    hop_tables,
    score,
    verdict,
    worth,
)
from morph.app.viewer.align.read import story
from morph.app.viewer.align.transfer_record import Told
from morph.app.viewer.content import Marked
from morph.app.viewer.fragments import notes_html, table_html
from morph.policy_transfer.parts import Arrow, Parts
from morph.policy_transfer.transfer_record import GuardRecord

Copy = Callable[..., Path]


@pytest.fixture(scope="module")
def hop(wrote: dict[str, Path]) -> Told:
    return story(wrote["transfer"]).hops[1]


@pytest.mark.parametrize(
    ("guard", "said"),
    [
        (GuardRecord(verdict="safe", probability=0.997), "calls it safe on"),
        (GuardRecord(verdict="unsafe", probability=0.2), "calls it unsafe on"),
        (GuardRecord(verdict="unsure", probability=None), "cannot tell of"),
    ],
)
def test_the_verdict_is_told_in_words_with_its_probability(
    hop: Told, guard: GuardRecord, said: str
) -> None:
    told = replace(hop, guard=guard, why="it was never seen")
    words = verdict(told)
    assert words.startswith(f"The guard {said} rider_three_links_driven: ")
    assert words.endswith(" It was never seen.")
    share = {0.997: "over 99 % sure", 0.2: "20 % sure", None: "there is no probability"}
    assert share[guard.probability] in words


def test_no_gain_is_what_the_report_calls_so_and_nothing_else(hop: Told) -> None:
    assert hop.crossing is not None
    # As good from the same transitions without a source: the report gives no credit.
    assert credit(hop.crossing)
    assert worth(hop) == "no gain"
    assert credit(hop.crossing) in hop_notes(hop)
    # A source that alone makes the policy good, by the same judgement.
    alone = dict.fromkeys(
        ("no_source", "shuffled", "flipped", "shuffled_anew", "flipped_anew"), 0.2
    )
    better = {**hop.crossing.measured, **alone}
    gained = replace(hop, crossing=replace(hop.crossing, measured=better))
    assert worth(gained) == "a gain"
    bare = replace(hop.crossing, measured={"hold_still": 0.1, "oracle": 0.9, "final": 0.9})
    assert worth(replace(hop, crossing=bare)) == "not measured"
    assert worth(replace(hop, crossing=None)) == "not measured"


def test_what_was_not_measured_is_a_dash(hop: Told) -> None:
    assert score(hop, "scratch") == "–"
    assert score(hop, "hold_still") == "0.00"


def test_the_chain_has_a_row_for_each_hop_with_the_verdict_in_words(wrote: dict[str, Path]) -> None:
    found = story(wrote["transfer"])
    table = chain_table(found)
    assert [row[0] for row in table.rows] == ["1 rider_rigid_driven", "2 rider_three_links_driven"]
    for row, hop in zip(table.rows, found.hops, strict=True):
        assert len(row) == len(table.head)
        badge = row[-1]
        assert isinstance(badge, Marked)
        assert badge.text == hop.guard.verdict


def test_a_part_that_is_turned_round_is_told_by_words_and_not_by_colour_alone(
    wrote: dict[str, Path],
) -> None:
    (hop,) = story(wrote["align"]).hops
    tables = {table.title: table for table in hop_tables(hop)}
    rows = tables["states of rider_rigid_driven as those of cartpole"].rows
    ways = [(row[0], row[1], row[2].text if isinstance(row[2], Marked) else "") for row in rows]
    # Of the record: the board is the slide, and the ankle the hinge turned round.
    assert ways == [("slide", "board", "the same way"), ("hinge", "ankle", "turned round")]
    colours = {row[2].colour for row in rows if isinstance(row[2], Marked)}
    assert len(colours) == 2


def test_numbers_that_are_none_are_called_so(hop: Told) -> None:
    told = replace(hop, quality={"one_step": float("nan")})
    (table,) = (each for each in hop_tables(told) if each.title.startswith("The map"))
    assert table.rows[-1][1] == "none"


def test_more_parts_than_anyone_reads_are_counted(hop: Told) -> None:
    many = tuple(Arrow(begin=f"a{at}", end=f"b{at}", weight=1.0) for at in range(100))
    told = replace(hop, parts=Parts(states=many, commands=(), lost=()))
    tables = [each for each in hop_tables(told) if each.title.startswith("states of ")]
    assert tables[0].rows[-1][0] == "and 60 more"
    assert len(tables[0].rows) == 41


def test_a_name_that_is_html_stays_text(hop: Told) -> None:
    evil = "<img src=x onerror=alert(1)>"
    part = Arrow(begin=evil, end=evil, weight=-1.0)
    told = replace(
        hop,
        source=evil,
        target=evil,
        mapper=evil,
        why=evil,
        quality={evil: 1.0},
        parts=Parts(states=(part,), commands=(part,), lost=(evil,)),
        notes=(evil,),
    )
    pages = [table_html(table, (), 0.0) for table in hop_tables(told)]
    pages.append(notes_html([verdict(told), *hop_notes(told)]))
    assert not any("<img" in page for page in pages)
    assert sum(page.count("&lt;img") for page in pages) >= 8
