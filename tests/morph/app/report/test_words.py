"""Figures of a diagnosis as sentences show them."""

from __future__ import annotations

from dataclasses import replace

import pytest

from morph.app.report.words import (
    channels,
    counted,
    headline,
    improvement,
    limited,
    number,
    percent,
    remains,
)
from morph.model.diagnosis import Diagnosis, Unexplained
from morph.model.finding import Change, Estimate
from morph.physics.body.external_push import ExternalPush

SPACE = "\N{NO-BREAK SPACE}"


@pytest.mark.parametrize(
    ("share", "shown"),
    [
        (0.0, "0"), (0.001, "under 1"), (0.25, "25"), (0.994, "99"),
        (0.999, "over 99"), (1.0, "100"), (-0.5, "-50"),
    ],
)  # fmt: skip
def test_a_share_is_shown_in_hundredths_and_never_as_all_or_nothing_unless_it_is(
    share: float, shown: str
) -> None:
    assert percent(share) == f"{shown}{SPACE}%"


def test_what_is_no_number_is_not_shown_as_one() -> None:
    assert percent(float("nan")) == "not known"
    assert number(float("inf")) == "diverged"
    assert number(0.012345) == "0.0123"
    assert counted(1, "run", "runs") == "one run"
    assert counted(12, "run", "runs") == "12 runs"


def test_a_mismatch_is_told_by_the_error_of_the_corrected_model_beside_the_others(
    mismatch: Diagnosis,
) -> None:
    first, second = improvement(mismatch)
    # 0.052 rad at the elbow, of 0.476 as given and 0.301 refitted, over noise of 0.0012.
    assert first.startswith("On three runs that it never saw, the corrected simulation is off by ")
    assert (
        "0.052 rad at elbow.position (as given 0.476, refitted 0.301, sensor noise 0.0012)" in first
    )
    assert "0.031 rad at shoulder.position" in first
    assert second == f"At least 96{SPACE}% of the squared error is gone, with 90 % confidence."


def test_where_nothing_was_corrected_the_error_is_that_of_the_description(
    consistent: Diagnosis,
) -> None:
    (only,) = improvement(consistent)
    assert "the simulation as given is off by 0.476 at elbow.position" in only


def test_channels_that_are_not_named_are_counted(mismatch: Diagnosis) -> None:
    names = [f"joint_{n}.position" for n in range(5)]
    many = replace(
        mismatch,
        held_out_rmse={
            model: dict.fromkeys(names, value)
            for model, value in (("nominal", 0.4), ("corrected", 0.1))
        },
        located=replace(mismatch.located, channels=dict.fromkeys(names, 0.2)),
    )
    assert channels(many) == tuple(names)
    # Three of five are named.
    assert improvement(many)[0].endswith(", and 2 more channels below.")


def test_what_remains_is_told_in_forces_rollouts_and_held_out_errors(mismatch: Diagnosis) -> None:
    left = Unexplained(
        probability=0.55,
        share=0.04,
        channels={"shoulder.position": 0.04, "elbow.position": 0.002},
        in_noise=9.25,
    )
    told = " ".join(remains(replace(mismatch, unexplained=left)))
    assert f"remains with a probability of 55{SPACE}%" in told
    assert "inertial force: 4 % at shoulder, 0.2 % at elbow." in told
    assert "by 3.04 times the sensors' noise" in told
    # 0.031 over 0.0011 is 28.2, and 0.052 over 0.0012 is 43.3.
    assert "are 28.2 to 43.3 times that noise" in told
    in_contact = " ".join(remains(replace(mismatch, unexplained=replace(left, contact=True))))
    assert "of these forces rollouts alone tell" in in_contact


def test_a_correction_that_stands_is_told_also_beside_unknown(mismatch: Diagnosis) -> None:
    unknown = replace(mismatch, verdict="unknown")
    assert headline(unknown) == "They differ by more than what was named"
    assert "the corrected simulation is off by" in improvement(unknown)[0]
    rmse = {**mismatch.held_out_rmse, "rejected": mismatch.held_out_rmse["corrected"]}
    rejected = replace(unknown, held_out_rmse=rmse)
    assert headline(rejected) == "They differ, and no correction holds on held-out runs"
    assert "the simulation as given is off by" in improvement(rejected)[0]


def test_a_parameter_that_the_runs_do_not_determine_is_marked(mismatch: Diagnosis) -> None:
    known = Estimate(value=0.081, low90=0.077, high90=0.085, unit="N m")
    assert limited(known) == ""
    assert limited(replace(known, bounded=True)) == " (at its bound)"
    unsure = replace(known, prior_only=True)
    assert limited(unsure) == " (not determined by these runs)"
    (first, *_) = mismatch.findings
    said = replace(first, parameters={"c": unsure}).statement
    assert said == f"{first.statement} These runs do not determine c."


def test_a_change_is_told_before_what_was_found_since_then(mismatch: Diagnosis) -> None:
    law = mismatch.findings[0].effect
    change = Change(
        before=law.neutral(), after=law, episode="run_2", time=4.25, gain=60.0, since=True
    )
    first, second, third, *_ = replace(mismatch, changes=(change,)).summary()
    assert first == f"From 4.2 s of run_2 on, and not before: {law.statement()}"
    assert second == "The robot changed then: what follows is of the runs since then."
    assert third == mismatch.findings[0].said
    # The same law may change its strength, cease, or be too weak to be found since then.
    stronger = replace(change, before=law, time=0.0)
    assert stronger.statement.startswith("From run_2 on: ")
    ceased = replace(change, before=law, after=law.neutral(), since=False)
    assert ceased.said(())[0] == f"Until 4.2 s of run_2, and not since: {law.statement()}"
    assert ceased.said(())[1].endswith("until then.")
    assert change.said(())[1].endswith("stands for this law in what follows.")
    lone = replace(mismatch, verdict="consistent", findings=(), changes=(ceased,))
    assert headline(lone) == "The robot changed during these recordings"


def test_what_acts_in_one_run_alone_is_written_with_its_interval(mismatch: Diagnosis) -> None:
    push = ExternalPush(body="hand", run="run_2", start=1.5, end=1.75, x=1.0)
    times = {
        name: Estimate(value=getattr(push, name), low90=1.0, high90=2.0, unit="s")
        for name in ("start", "end")
    }
    finding = replace(mismatch.findings[0], effect=push, parameters=times)
    content = replace(mismatch, findings=(finding,)).as_json()["findings"][0]
    assert (content["onset_s"], content["interval_s"]) == (1.5, [1.5, 1.75])
