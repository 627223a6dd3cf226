from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from morph.app.viewer.axis import rounded_steps, values_shown
from morph.app.viewer.content import ChartLine


def line(*values: float, leads: bool = False) -> ChartLine:
    return ChartLine(
        name="a", time=np.arange(len(values), dtype=float), value=np.array(values), leads=leads
    )


def test_all_lines_fit_where_none_leads() -> None:
    assert values_shown([line(0.0, 1.0), line(-5.0, 100.0)]) == (-5.0, 100.0, frozenset())


def test_a_line_that_blew_up_leaves_the_others_readable() -> None:
    low, high, out = values_shown([line(0.0, 1.0), line(0.0, 1e9), line(-1.0, 0.5)])
    # The others span 2, and as much again is shown at both ends.
    assert (low, high) == (-3.0, 3.0)
    assert out == {1}


def test_a_measurement_that_leads_keeps_a_model_from_the_axis() -> None:
    low, high, out = values_shown([line(-1.0, 1.0, leads=True), line(0.0, 50.0), line(-1.5, 0.0)])
    # It spans 2: up to 3 the axis follows the models, and down to where they end.
    assert (low, high) == (-1.5, 3.0)
    assert out == {1}


def test_one_value_alone_still_has_an_axis_around_it() -> None:
    low, high, out = values_shown([line(4.0, 4.0)])
    assert low < 4.0 < high
    assert not out


@pytest.mark.parametrize("values", [(), (math.nan, math.inf)])
def test_lines_without_numbers_have_an_axis_all_the_same(values: tuple[float, ...]) -> None:
    assert values_shown([line(*values)]) == (0.0, 1.0, frozenset())


@given(
    low=st.floats(-1e9, 1e9),
    span=st.floats(1e-6, 1e9),
    most=st.integers(2, 10),
)
def test_steps_are_round_and_few_and_within(low: float, span: float, most: int) -> None:
    high = low + span
    if high - low < 1e-9 * max(abs(low), abs(high)):
        return
    steps = rounded_steps(low, high, most)
    # A step is at least the span by `most`, so there is at most one number more than that.
    assert len(steps) <= most + 1
    values = [value for value, _ in steps]
    slack = 1e-5 * (high - low)
    assert all(low - slack <= value <= high + slack for value in values)
    if len(values) > 1:
        step = values[1] - values[0]
        first = step / 10.0 ** math.floor(math.log10(step) + 1e-6)
        # What is left of large numbers is rounded: 2^-52 of 1e9 by a step of 1e-7 at least.
        assert min(
            abs(first - digit) for digit in (1.0, 2.0, 5.0, 10.0)
        ) < 1e-2 or span < 1e-6 * abs(low)


def test_numbers_have_as_many_decimals_as_their_step() -> None:
    assert [text for _, text in rounded_steps(0.0, 1.0, 4)] == ["0", "0.5", "1.0"]
    assert [text for _, text in rounded_steps(-20.0, 20.0, 4)] == ["−20", "−10", "0", "10", "20"]
    assert rounded_steps(0.0, 4e6, 4)[-1][1] == "4e+06"
