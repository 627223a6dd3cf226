"""Where the marks of small drawings stand, and the numbers beside them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from morph.app.report.curves import curves, thinned
from morph.app.report.tracks import parameter_intervals, refit_intervals, strips
from morph.model.diagnosis import Diagnosis


def test_a_factor_stands_on_a_line_about_one_as_far_as_it_is_from_one(mismatch: Diagnosis) -> None:
    mass, inertia, _ = refit_intervals(mismatch)

    # The farthest end is 0.88, so the line runs from 1 - 1.15 * 0.12 to 1 + 1.15 * 0.12.
    def at(value: float) -> float:
        return 100.0 * (value - 1.0 + 0.138) / 0.276

    assert (mass.low, mass.low + mass.width) == pytest.approx((at(1.02), at(1.06)))
    assert (inertia.low, inertia.low + inertia.width) == pytest.approx((at(0.88), at(0.99)))
    assert (mass.best, mass.mark) == pytest.approx((at(1.04), 50.0))
    assert mass.text == "1.04  (1.02 to 1.06)"


def test_a_strength_stands_between_nothing_and_the_end_of_its_interval(mismatch: Diagnosis) -> None:
    (c,) = parameter_intervals(mismatch.findings[0])

    # From 0, where friction does nothing, to 0.085, and 6 % of that on both sides.
    def at(value: float) -> float:
        return 100.0 * (value + 0.06 * 0.085) / (1.12 * 0.085)

    assert (c.low, c.best, c.low + c.width) == pytest.approx((at(0.077), at(0.081), at(0.085)))
    assert c.mark == pytest.approx(at(0.0))
    assert c.text == "0.081 N m  (0.077 to 0.085)"


def test_bad_stretches_stand_where_they_begin_and_as_strong_as_their_share(
    mismatch: Diagnosis,
) -> None:
    drawn = {strip.episode: strip for strip in strips(mismatch)}
    # All three runs end at 10 s. The worst stretch has a share of 0.2.
    first, last = drawn["run_03"].blocks
    assert (first.left, first.width, first.strength) == pytest.approx((21.0, 8.0, 1.0))
    assert (last.left, last.width, last.strength) == pytest.approx((80.0, 4.0, 0.2))
    (only,) = drawn["run_06"].blocks
    assert (only.left, only.width, only.strength) == pytest.approx((60.0, 25.0, 0.55))


def test_a_run_half_as_long_is_drawn_half_as_long(mismatch: Diagnosis) -> None:
    short = []
    for trace in mismatch.traces:
        until = trace.time <= (5.0 if trace.episode == "run_05" else 10.0)
        keep = until | np.isnan(trace.time)
        short.append(
            replace(
                trace,
                time=trace.time[keep],
                measured=trace.measured[keep],
                models={name: values[keep] for name, values in trace.models.items()},
            )
        )
    drawn = {s.episode: s for s in strips(replace(mismatch, traces=tuple(short)))}
    assert drawn["run_05"].width == pytest.approx(50.0, abs=0.1)
    assert drawn["run_03"].width == pytest.approx(100.0)


def test_plots_hold_what_was_measured_and_what_each_model_says(mismatch: Diagnosis) -> None:
    drawn = curves(mismatch)
    trace, curve = mismatch.traces[0], drawn["curves"][0]
    places = thinned(trace.time, 1500)
    ours = np.array([np.nan if v is None else v for v in curve["measured"]])
    assert ours == pytest.approx(trace.measured[places], rel=1e-4, abs=1e-9, nan_ok=True)
    for values, model in zip(curve["models"], trace.models.values(), strict=True):
        assert np.array(values) == pytest.approx(model[places], rel=1e-4, abs=1e-9)
    # No model errs by more than what was measured spans, so errors have an axis of their own.
    assert curve["error_range"] is None


def test_an_axis_of_errors_reaches_as_far_as_the_readings_span(mismatch: Diagnosis) -> None:
    trace = mismatch.traces[0]
    span = float(np.ptp(trace.measured))
    wild = replace(trace, models={"nominal": trace.measured + 9.0 * span})
    curve = curves(replace(mismatch, traces=(wild,)))["curves"][0]
    # All errors are nine spans; the axis ends at one, on both sides of nothing.
    low, high = curve["error_range"]
    assert high == pytest.approx(span, abs=1e-3)  # Thinned readings miss the very peak.
    assert low >= -span


@pytest.mark.parametrize("samples", [1501, 2999, 3001, 30_000])
def test_points_of_a_plot_are_no_more_than_its_limit(samples: int) -> None:
    assert len(thinned(np.arange(float(samples)), 1500)) <= 1500
