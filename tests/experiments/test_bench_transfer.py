"""The study of transfer, small: its tables count rightly, and one case of it runs."""

from __future__ import annotations

import math

import pytest

from experiments.bench_transfer import FACTORS, PARTS, shown
from experiments.transfer.cases import Case
from experiments.transfer.headline import headline
from experiments.transfer.job import Job, work
from experiments.transfer.tables import (
    compared,
    figure8,
    grouped,
    harm,
    iqm,
    missed,
    own_loss,
    summary,
    trials_to,
)
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


def test_what_the_oracle_can_and_the_loop_cannot_is_named(
    capsys: pytest.CaptureFixture[str],
) -> None:
    lines = [
        line("a", "own plan", 0, 29.8),
        line("a", "loop", 0, 45.0, 40.1, success=0.2),
        line("a", "own plan", 1, 29.8),
        line("a", "loop", 1, 45.0, 30.0),
        # Neither works: that target is beyond both.
        line("b", "own plan", 0, 60.0, success=0.0),
        line("b", "loop", 0, 60.0, success=0.0),
        # The plan works in six of ten runs, the loop in none.
        line("c", "own plan", 0, 40.0, success=0.6),
        line("c", "loop", 0, 60.0, success=0.0),
        # No oracle was run on seed 2.
        line("a", "loop", 2, 60.0, success=0.0),
    ]
    found = missed(lines)
    assert [(each["case"], each["seed"]) for each in found] == [("a", 0), ("c", 0)]
    assert (found[0]["loop_loss"], found[0]["oracle_loss"]) == (40.1, 29.8)
    assert compared(lines) == 4
    shown(lines)
    said = capsys.readouterr().out
    assert "2 of 4 cases in which both were run" in said
    assert "a, seed 0: the loop 20% of runs, loss 40.1; the oracle 100%, 29.8" in said


def test_the_oracle_stands_beside_the_loop_in_its_row() -> None:
    lines = [line("a", "loop", 0, 45.0, 15.0), line("a", "own plan", 0, 14.0)]
    table = summary(lines)
    columns = {str(column.header): list(column.cells) for column in table.columns}
    assert columns["who"] == ["loop", "own plan"]
    assert columns["oracle sure"][0] == "1/1"
    assert columns["oracle's loss"][0] == "14.00"


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


def test_a_case_that_only_the_oracle_solves_is_counted() -> None:
    def line(arm: str, seed: int, success: float) -> JSON:
        shown = {"loss": 1.0, "error": 0.1, "success": success, "reached": success > 0.5}
        return {"case": "one", "arm": arm, "seed": seed, "lines": [shown, shown]}

    arms = {"loop": (1.0, 0.0), "own plan": (1.0, 1.0), "unadjusted": (0.0, 0.0)}
    lines = [line(arm, seed, each) for arm, of in arms.items() for seed, each in enumerate(of)]
    told = headline(lines)["figures"]
    assert (told["seeds"], told["loop_sure"], told["second_trial_reached"]) == (2, 1, 1)
    assert (told["missed"], told["compared"], told["unadjusted_sure"]) == (1, 2, 0)
    assert (told["judged"], told["better"], told["worse"]) == (2, 0, 0)
