"""The study of transfer, small: its tables count rightly, and one case of it runs."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from experiments.bench_transfer import FACTORS, PARTS
from experiments.transfer.cases import Case
from experiments.transfer.many import Job, done, work
from experiments.transfer.tables import figure8, grouped, harm, iqm, own_loss, trials_to
from morph.arrays import JSON


def line(case: str, arm: str, seed: int, *losses: float, success: float = 1.0) -> JSON:
    lines = [{"loss": loss, "error": 0.1, "success": success} for loss in losses]
    return {"case": case, "arm": arm, "seed": seed, "lines": lines, "seconds": 1.0}


def test_an_interquartile_mean_leaves_out_a_quarter_at_each_end() -> None:
    # Of 1 to 8 the middle half is 3, 4, 5, 6.
    mean, low, high = iqm([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 80.0])
    assert mean == pytest.approx(4.5)
    assert low < mean < high


def test_harm_counts_only_what_is_beyond_three_standard_errors() -> None:
    # Each mean has an error of 0.1, their difference of 0.141: three are 0.42.
    lines = [line("a", "unadjusted", seed, 10.0) for seed in range(3)]
    lines += [
        line("a", "loop", 0, 10.0, 5.0),
        line("a", "loop", 1, 10.3),
        line("a", "loop", 2, 10.5),
    ]
    table = harm(lines)
    cells = [next(iter(column.cells)) for column in table.columns]
    assert cells == ["loop", "3", "1", "1", "1", "+0.50"]


def test_trials_are_counted_to_the_first_policy_that_is_good_enough() -> None:
    tried = line("a", "loop", 0, 50.0, 15.0, 14.0)
    assert trials_to(tried, 15.4) == 2
    assert trials_to(tried, 1.0) == math.inf


def test_the_optimum_is_the_best_that_anyone_reached_surely() -> None:
    lines = [line("a", "own plan", 0, 20.0), line("a", "loop", 0, 50.0, 19.0)]
    assert own_loss(grouped(lines)["a"]) == 19.0
    unsure = [line("a", "loop", 0, 10.0, success=0.5)]
    assert own_loss(grouped(lines + unsure)["a"]) == 19.0


def test_figure_8_has_a_panel_for_each_parameter_and_factor() -> None:
    lines = [
        line(f"cartpole: {name} x{f:g}", "loop", 0, 50.0, 14.0) for name in "ab" for f in FACTORS
    ]
    page = figure8([*lines, line("cartpole: unchanged", "unadjusted", 0, 14.0)])
    assert all(f"{name} x{factor:g}" in page for name in "ab" for factor in FACTORS)


@pytest.mark.parametrize("part", list(PARTS))
def test_the_jobs_of_a_part_differ(part: str) -> None:
    jobs = PARTS[part]([0, 1])
    assert len({job.key for job in jobs}) == len(jobs) > 0


def test_the_unadjusted_policy_does_on_an_unchanged_body_what_it_did() -> None:
    job = Job(case=Case(body="cartpole"), arm="unadjusted", seed=100, trials=1)
    (found,) = work(job)["lines"]
    assert found["success"] == 1.0
    # The best plans of a cart-pole cost about 14, doing nothing 61.
    assert found["loss"] == pytest.approx(14.0, abs=0.5)


def test_what_is_kept_is_not_done_again(tmp_path) -> None:
    job = Job(case=Case(body="cartpole"), arm="unadjusted", seed=100, trials=1)
    kept = tmp_path / "kept.jsonl"
    whole = json.dumps({"key": job.key, "lines": [{"loss": 1.0}]})
    kept.write_text(f'{whole}\n{{"key": "cut sho')
    (found,) = done([job], kept=kept, processes=1)
    assert found["lines"] == [{"loss": 1.0}]
    assert np.isfinite(found["lines"][0]["loss"])
