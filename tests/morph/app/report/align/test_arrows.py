from __future__ import annotations

from xml.etree import ElementTree

import pytest

from morph.app.report.align.arrows import drawn, told
from morph.policy_transfer.parts import Arrow, Parts

PARTS = Parts(
    states=(
        Arrow(begin="board", end="slide", weight=0.9),
        Arrow(begin="ankle", end="hinge", weight=-0.75),
        Arrow(begin='<hip> & "a joint\'s very long name"', end="hinge", weight=0.25),
    ),
    commands=(Arrow(begin="slide", end="board", weight=1.0),),
    lost=(),
)


def elements(title: str) -> ElementTree.Element:
    svg = dict(drawn(PARTS, "cartpole", "rider"))[title]
    return ElementTree.fromstring(str(svg))


def test_there_is_an_arrow_for_each_and_its_sign_is_seen_without_colour() -> None:
    states = elements("states of rider as those of cartpole")
    looks = [group.get("class") for group in states.findall("g")]
    assert sorted(filter(None, looks)) == ["minus", "plus", "plus"]
    widths = {
        group.findtext("title"): float(path.get("stroke-width", "0"))
        for group in states.findall("g")
        for path in group.findall("path")
    }
    # 1 and 4 times the share.
    assert widths["board to slide: 90 %"] == pytest.approx(4.6)
    assert widths["ankle to hinge: turned round, 75 %"] == pytest.approx(4.0)


def test_states_point_to_the_source_and_commands_to_the_target() -> None:
    for what, leftward in (("states", 1), ("commands", 0)):
        svg = elements(f"{what} of rider as those of cartpole")
        for group in svg.findall("g"):
            tip = group.find("polygon")
            assert tip is not None
            (x, _), (foot, _), _ = (
                map(float, point.split(",")) for point in tip.get("points", "").split()
            )
            assert (x < foot) == bool(leftward)


def test_names_of_strangers_are_escaped_and_long_ones_cut() -> None:
    states = elements("states of rider as those of cartpole")
    long = [text for text in states.findall("text") if text.find("title") is not None]
    assert [text.findtext("title") for text in long] == [PARTS.states[2].begin]
    assert (long[0].find("title").tail or "").endswith("\N{HORIZONTAL ELLIPSIS}")  # type: ignore[union-attr]


def test_everything_stays_inside_the_drawing() -> None:
    svg = elements("states of rider as those of cartpole")
    _, _, width, height = map(float, svg.get("viewBox", "").split())
    for text in svg.findall("text"):
        assert 0.0 <= float(text.get("x", "-1")) <= width
        assert 0.0 <= float(text.get("y", "-1")) <= height


def test_a_map_without_arrows_draws_nothing() -> None:
    assert drawn(Parts(states=(), commands=(), lost=()), "a", "b") == ()


def test_an_arrow_in_words_names_ends_sign_and_share() -> None:
    assert told(PARTS.states[1]) == "ankle to hinge: turned round, 75 %"
