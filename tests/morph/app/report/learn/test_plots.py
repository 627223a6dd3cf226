from __future__ import annotations

import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from morph.app.report.learn.plots import HEIGHT, WIDTH, GoalBand, Plot, PlottedLine, figure, ticks


def drawn(plot: Plot) -> ET.Element:
    return ET.fromstring(str(plot.svg))


def points(element: ET.Element) -> list[tuple[float, float]]:
    pairs = re.findall(r"[ML]([\d.-]+) ([\d.-]+)", element.get("d", ""))
    return [(float(a), float(b)) for a, b in pairs]


def plot(x: list[float], y: list[float], **more: object) -> Plot:
    line = PlottedLine(x=np.array(x, dtype=float), y=np.array(y, dtype=float))
    return Plot(title="loss", x_title="trial", lines=(line,), **more)  # type: ignore[arg-type]


def curve(element: ET.Element) -> list[tuple[float, float]]:
    (path,) = element.findall("path[@class='main']")
    return points(path)


def test_what_is_twice_as_far_stands_twice_as_far() -> None:
    (x0, y0), (x1, y1), (x2, y2) = curve(drawn(plot([0, 1, 2], [1.0, 2.0, 3.0])))
    assert x2 - x0 == pytest.approx(2 * (x1 - x0), abs=0.2)
    # Up is less in a picture.
    assert y2 - y0 == pytest.approx(2 * (y1 - y0), abs=0.2)
    assert y2 < y0


def test_decades_are_drawn_by_their_logarithm() -> None:
    (_, y0), (_, y1), (_, y2) = curve(drawn(plot([0, 1, 2], [1.0, 100.0, 10_000.0])))
    assert y2 - y1 == pytest.approx(y1 - y0, abs=0.2)


def test_a_gap_is_no_line() -> None:
    (path,) = drawn(plot([0, 1, 2, 3], [1.0, np.nan, 2.0, np.inf])).findall("path[@class='main']")
    assert path.get("d", "").count("M") == 2
    assert len(points(path)) == 2


def test_a_bound_that_is_far_off_does_not_flatten_the_curve() -> None:
    near = plot([0, 1], [0.0, 1.0], bounds=(1.2, 1e6))
    assert len(drawn(near).findall("path[@class='bound']")) == 1


def test_names_of_rules_do_not_lie_on_one_another() -> None:
    named = plot([0, 1], [0.0, 100.0], rules=((50.0, "judged"), (51.0, "doing nothing")))
    places = [float(each.get("y", "0")) for each in drawn(named).findall("text[@class='name']")]
    assert len(places) == 2
    assert abs(places[0] - places[1]) >= 10.0


def test_names_are_escaped() -> None:
    element = drawn(Plot(title='<b a="1">', x_title="</svg>", lines=()))
    assert element.get("aria-label") == '<b a="1">, over </svg>'


@given(
    x=st.lists(st.floats(-1e12, 1e12), min_size=1, max_size=20),
    y=st.lists(st.floats(-1e12, 1e12) | st.just(float("nan")), min_size=20, max_size=20),
)
def test_whatever_is_drawn_stays_within_the_picture(x: list[float], y: list[float]) -> None:
    band = GoalBand(x=(min(x), max(x)), y=(-1.0, 1.0))
    for a, b in curve(drawn(plot(x, y[: len(x)], bands=(band,), rules=((5.0, "five"),)))):
        assert -0.1 <= a <= WIDTH + 0.1
        assert -0.1 <= b <= HEIGHT + 0.1


@given(low=st.floats(-1e9, 1e9), size=st.floats(1e-3, 1e9))
def test_ticks_are_few_and_within(low: float, size: float) -> None:
    found = ticks(low, low + size)
    room = 1e-6 * max(size, abs(low))
    assert 2 <= len(found) <= 7
    assert all(low - room <= tick <= low + size + room for tick in found)


def test_figures_are_short() -> None:
    assert [figure(value) for value in (-1.5, 0.1, 1e6, 12345678.0)] == [
        *("\N{MINUS SIGN}1.5", "0.1", "1e6", "1.235e7"),
    ]
