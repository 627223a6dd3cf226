"""The study of rivals, small."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from experiments import rivals
from experiments.rivals import Row, harm, interval, middle, summary


def row(rival: str, seed: int, *losses: float) -> Row:
    return Row(
        world="l*2",
        rival=rival,
        seed=seed,
        losses=losses,
        successes=tuple(float(loss < 20.0) for loss in losses),
        seconds=1.0,
    )


def test_the_middle_leaves_out_a_quarter_at_each_end() -> None:
    assert middle(np.array([-1000.0, 1.0, 3.0, 1000.0])) == 2.0


def test_an_interval_of_draws_without_spread_has_no_width() -> None:
    assert interval(np.full(5, 7.0), np.random.default_rng(0)) == (7.0, 7.0)


def test_an_interval_is_as_wide_as_that_of_a_mean_of_a_gaussian() -> None:
    drawn = np.random.default_rng(0).standard_normal(400)
    low, high = interval(drawn, np.random.default_rng(1))
    # A mean trimmed by a quarter has the variance 1.20 / n for a Gaussian (Huber 1981):
    # 2 * 1.96 * sqrt(1.20 / 400) = 0.215.
    assert high - low == pytest.approx(0.215, rel=0.15)


def test_harm_is_paired_by_seed() -> None:
    found = [row("bad", 1, 10.0, 50.0), row("bad", 2, 20.0, 60.0)]
    found += [row("good", 2, 20.0, 30.0), row("good", 1, 10.0, 20.0), row("good", 3, 0.0, 0.0)]
    (told,) = harm(found, "bad", "good")
    assert told["more"] == [0.0, 30.0]
    assert [tuple(each) for each in told["interval"]] == [(0.0, 0.0), (30.0, 30.0)]


def test_a_summary_tells_each_rival_trial_by_trial() -> None:
    (told,) = summary([row("one", seed, 10.0, 30.0) for seed in range(4)])
    assert told["loss"] == [10.0, 30.0]
    assert told["success"] == [1.0, 0.0]


def test_what_was_measured_is_not_measured_again(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    told = ["--seed", "100", "--seeds", "1", "--worlds", "l*2", "--json"]
    told += ["--rivals", rivals.STILL, "--out", str(tmp_path)]
    assert rivals.main(told) == 0
    first = capsys.readouterr()
    (still,) = json.loads(first.out)["summary"]
    # Hanging still costs nearly 1 in each of 61 samples, and never succeeds.
    assert still["loss"][0] == pytest.approx(61.0, abs=0.5)
    assert still["success"] == [0.0] * rivals.TRIALS
    assert rivals.main([*told, "--resume"]) == 0
    assert capsys.readouterr().out == first.out
