from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from morph.app.viewer.charts import (
    BOTTOM,
    DASHES,
    HEIGHT,
    LEFT,
    RIGHT,
    TOP,
    WIDTH,
    chart_html,
    now_html,
    thinned,
)
from morph.app.viewer.content import Chart, ChartLine

WIDE, TALL = WIDTH - LEFT - RIGHT, HEIGHT - TOP - BOTTOM


def chart(*values: np.ndarray, seconds: float = 4.0) -> Chart:
    lines = tuple(
        ChartLine(name=f"line {at}", time=np.linspace(0.0, seconds, len(each)), value=each)
        for at, each in enumerate(values)
    )
    return Chart(title="Angle", unit="rad", lines=lines)


def paths(html: str) -> list[list[tuple[str, float, float]]]:
    found = re.findall(r'<path d="(M[^"]*)" stroke="#0072b2"', html)
    return [
        [(kind, float(x), float(y)) for kind, x, y in re.findall(r"([ML])(\S+?) ([-\d.]+)", each)]
        for each in found
        if "H25" not in each
    ]


def test_a_straight_line_runs_from_corner_to_corner_within_its_margin() -> None:
    (points,) = paths(chart_html(chart(np.array([0.0, 1.0])), 4.0))
    # 5 % of the span is left below and above: 1.1 spans the plot, and 0.05 of it is margin.
    margin = 0.05 / 1.1 * TALL
    assert points == [
        ("M", 0.0, pytest.approx(TALL - margin, abs=0.06)),
        ("L", WIDE, pytest.approx(margin, abs=0.06)),
    ]


def test_a_gap_breaks_the_line() -> None:
    (points,) = paths(chart_html(chart(np.array([0.0, 1.0, np.nan, 1.0, 0.0])), 4.0))
    assert [kind for kind, _, _ in points] == ["M", "L", "M", "L"]


def test_a_clock_that_is_longer_leaves_room_at_the_right() -> None:
    (points,) = paths(chart_html(chart(np.array([0.0, 1.0]), seconds=2.0), 8.0))
    assert points[-1][1] == pytest.approx(WIDE / 4, abs=0.06)


@given(st.integers(601, 5000), st.integers(0, 2**32 - 1))
def test_thinning_keeps_every_peak_and_the_ends(count: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    value = rng.normal(size=count)
    value[rng.integers(count)] = 1e3
    time = np.arange(count, dtype=float)
    few, kept = thinned(time, value)
    # Two points of each of 300 stretches, and both ends.
    assert len(few) <= 602
    assert (kept.min(), kept.max()) == (value.min(), value.max())
    assert (few[0], few[-1]) == (time[0], time[-1])
    assert np.all(np.diff(few) > 0)
    assert np.array_equal(value[few.astype(int)], kept)


def test_thinning_keeps_a_gap_of_one_reading() -> None:
    value = np.ones(6000)
    value[3000] = np.nan
    assert np.isnan(thinned(np.arange(6000.0), value)[1]).sum() == 1


def test_lines_are_told_apart_without_their_colours() -> None:
    html = chart_html(chart(*[np.array([0.0, 1.0])] * len(DASHES)), 4.0)
    lines = re.findall(r'<path d="M0\.0[^>]*>', html)
    assert len({re.search(r'stroke-dasharray="[^"]*"', each) and each for each in lines}) == 8
    assert sum("dasharray" not in each for each in lines) == 1


def test_names_from_files_become_no_html() -> None:
    evil = '<img src=x onerror="alert(1)">&'
    drawn = Chart(
        title=evil,
        unit=evil,
        lines=(ChartLine(name=evil, time=np.zeros(1), value=np.zeros(1), colour=f'"{evil}'),),
    )
    html = chart_html(drawn, 1.0)
    # What parses as XML with our elements alone holds none of theirs.
    tags = {each.tag for each in ElementTree.fromstring(html).iter()}
    assert tags <= {"figure", "figcaption", "svg", "path", "text", "ul", "li"}


def test_what_leaves_the_plot_is_named() -> None:
    html = chart_html(chart(np.array([0.0, 1.0]), np.array([0.0, 1e12])), 4.0)
    assert re.findall(r"</svg>(line \d[^<]*)<", html) == ["line 0", "line 1 (leaves the plot)"]
    # However far it is, no number in the picture is large enough for a browser to drop it.
    assert max(abs(y) for _, _, y in paths(html)[1]) <= 2.0 * TALL + 0.1


@pytest.mark.parametrize(
    ("time", "seconds", "share"),
    [(1.0, 4.0, "0.2500"), (9.0, 4.0, "1.0000"), (-1.0, 4.0, "0.0000"), (1.0, 0.0, "0.0000")],
)
def test_the_cursor_is_where_the_clock_is(time: float, seconds: float, share: str) -> None:
    assert f"--morph-now:{share}" in now_html(time, seconds)
