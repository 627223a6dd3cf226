from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser
from typing import Any

import numpy as np
import pytest

from morph.app.report.transfer.page import transfer_page
from morph.app.report.transfer.words import credit, headline, saved, summary
from morph.body.load import load
from morph.policy_transfer.hop_result import Crossing, Curve
from morph.policy_transfer.parts import Arrow, Parts
from morph.policy_transfer.relay_record import RelayRecord
from morph.policy_transfer.transfer_record import GuardRecord
from morph.task.tasks import task


def curve(name: str, *rows: list[float]) -> Curve:
    return Curve(name=name, samples=(10, 20, 40), scores=np.array(rows))


HOP = Crossing(
    source="cartpole",
    target="rider <b>",
    map="maps/01_body_map.npz",
    kind="affine",
    parts=Parts(
        states=(Arrow(begin="board", end="slide", weight=-0.8),), commands=(), lost=("ankle",)
    ),
    quality={"round_trip": 0.01, "one_step": float("nan")},
    guard=GuardRecord(verdict="safe", probability=0.98),
    samples=40,
    measured={
        **{"hold_still": 0.2, "oracle": 1.0, "final": 0.99, "zero_shot": 0.6},
        **{"no_source": 0.5, "shuffled": 0.2, "flipped": 0.1},
    },
    curves=(
        curve("transfer", [0.3, 0.97, 1.0], [0.5, 0.99, 1.0]),
        curve("no_source", [0.2, 0.3, 0.5], [0.2, 0.4, 0.6]),
    ),
)


def record(*hops: Crossing, **changed: Any) -> RelayRecord:
    known: dict[str, Any] = {
        "task": task("balance", load("cartpole")),
        "hops": hops,
        "policy": True,
        "seed": 0,
        "seconds": 1.5,
        "command": "morph transfer",
        "inputs": {"cartpole": "0" * 64},
        "notes": ("a note & more",),
    }
    return RelayRecord(**known | changed)


class Whole(HTMLParser):
    """Notes whether every element is closed in its turn."""

    VOID = frozenset({"meta", "path", "polygon", "rect", "circle", "br", "img"})

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.ids: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.ids += [value or "" for name, value in attrs if name == "id"]
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if tag not in self.VOID:
            assert self.open.pop() == tag


def test_the_page_is_whole_loads_nothing_and_escapes_names() -> None:
    page = transfer_page(record(HOP, replace(HOP, source="rider <b>", target="last")), 20)
    read = Whole()
    read.feed(page)
    assert read.open == []
    assert len(read.ids) == len(set(read.ids))
    assert "<script" not in page
    assert "http" not in re.sub(r"http-equiv", "", page)
    assert "rider <b>" not in page
    assert "rider &lt;b&gt;" in page
    assert "a note &amp; more" in page


def test_the_page_shows_arrows_quality_guard_curves_and_controls() -> None:
    page = transfer_page(record(HOP), 20)
    assert 'class="arrows"' in page
    assert "states there and back" in page
    assert "98 % sure that it does no harm" in page
    assert page.count("whisker") >= 2
    for name in ("without a source", "through a flipped map", "holding still", "the oracle"):
        assert name in page
    assert "ankle plays no role" in page


def test_what_was_saved_is_told_in_transitions() -> None:
    # 0.2 + 0.95 * 0.8 = 0.96: transfer is above from 20 on; the other ends at 0.55.
    assert saved(HOP) == (
        "Transfer reaches 95 % of what the oracle gains after 20 transitions; "
        "without a source had not after 40."
    )
    later = curve("no_source", [0.2, 0.3, 0.97])
    assert saved(replace(HOP, curves=(HOP.curves[0], later))).endswith(
        "without a source takes 40, 20 more."
    )
    assert saved(replace(HOP, curves=())) == ""


def test_what_a_control_equals_is_called_no_gain() -> None:
    assert credit(HOP) == ""
    equal = replace(HOP, measured={**HOP.measured, "no_source": 0.985}, curves=())
    # 0.985 against 0.99 is 0.006 of what the oracle gains, less than 0.01.
    assert credit(equal) == (
        "At rider <b> the source gains nothing with 40 transitions: without a source is as good."
    )
    worse = {"final": 0.6, "no_source": 0.9, "flipped": 0.6, "shuffled": 0.605, "flipped_anew": 0.3}
    told = credit(replace(HOP, measured={**HOP.measured, **worse}, curves=()))
    # 0.9 is 0.375 of what the oracle gains above 0.6, 0.605 is 0.006 above it, 0.3 far below.
    assert told.endswith(
        "40 transitions: without a source is better; "
        "through a shuffled map and through a flipped map are as good."
    )
    # One draw is not believed where there are several: on their mean transfer is better.
    assert credit(replace(equal, curves=HOP.curves)) == ""


def test_where_holding_still_does_as_well_there_is_no_credit() -> None:
    stiff = replace(HOP, measured={"hold_still": 0.999, "oracle": 0.999, "final": 0.999})
    assert "holding still does as well" in credit(stiff)
    assert "nothing was gained" in summary(record(stiff))[0]
    assert transfer_page(record(stiff), 20)


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({}, "rider <b> does balance, by way of one hop"),
        ({"guard": GuardRecord(verdict="unsafe", probability=0.1)}, "The guard warns of rider <b>"),
        (
            {"measured": {**HOP.measured, "final": 0.6}},
            "rider <b> does not do balance as well as it could",
        ),
    ],
)
def test_the_headline_says_what_came_of_it(changed: dict[str, Any], said: str) -> None:
    assert headline(record(replace(HOP, **changed))) == said
