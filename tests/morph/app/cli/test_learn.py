from __future__ import annotations

import json
import re
import shlex
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from morph.app.cli.main import main
from morph.body.load import load
from morph.policy.store import load_policy
from morph.record.load import load_recordings
from morph.search.evaluate import attempt
from morph.search.search import Learned
from morph.task.tasks import task

BALANCE = ("balance", "--robot", "cartpole", "--search", "growing", "--out", "out")


def test_a_search_that_succeeds_leaves_a_policy_a_record_and_a_report(
    capsys: pytest.CaptureFixture[str], bench: Any
) -> None:
    bench.learn(*BALANCE, "--quiet")
    told = capsys.readouterr()
    assert told.err == ""
    assert told.out.startswith("cartpole has learned balance\n")
    assert "see it by: morph simulate cartpole --policy out/policy" in told.out
    said = bench.record()
    assert (said["succeeded"], said["why"], said["judged"]["success"]) == (True, "", 1.0)
    assert [trial["number"] for trial in said["trials"]] == [1, 2, 3, 4, 5]
    # Who does nothing pays some 5,000, and what balances costs a few.
    assert said["controls"]["nothing"]["loss"]["mean"] > 1e3 > said["judged"]["loss"]["mean"]
    assert said["controls"]["random"]["success"] == 0.0
    assert sum(said["judged"]["terms"].values()) == pytest.approx(said["judged"]["loss"]["mean"])
    assert {path.name for path in Path("out").iterdir()} == {
        ".morph.files",
        *("policy", "record.json", "report.html", "state.npz"),
    }


def test_the_policy_on_disk_is_the_one_that_was_judged(bench: Any) -> None:
    bench.learn(*BALANCE, "--quiet", "--seed", "3")
    robot = load("cartpole")
    policy = load_policy("out/policy", robot)
    seen = np.array([[0.1, 3.0, 0.2, -0.1]])
    assert policy.act(seen, np.zeros(1))[0] == pytest.approx(
        -bench.gain @ (seen[0] - bench.upright)
    )
    said = json.loads(Path("out/policy/policy.json").read_text())
    assert said["task"]["name"] == "balance"
    assert said["task"]["sha256"] == bench.record()["task"]["sha256"]
    learned = said["learned"]
    assert (learned["search"], learned["trials"], learned["seed"]) == ("growing", 5, 3)
    assert (learned["cost"], learned["success"]) == (
        pytest.approx(bench.record()["judged"]["loss"]["mean"]),
        1.0,
    )


def test_the_command_that_shows_the_policy_moves_as_the_judged_runs(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, bench: Any
) -> None:
    monkeypatch.setenv("COLUMNS", "1000")
    bench.learn(*BALANCE, "--quiet")
    line = capsys.readouterr().out.partition("see it by: morph ")[2].strip()
    words = shlex.split(line.removesuffix(" --view"))
    assert main([*words, "--out", "run.npz"]) == 0
    (run,) = load_recordings(Path("run.npz"), robot=load("cartpole"))
    balance = task("balance", load("cartpole"))
    policy = load_policy("out/policy", balance.robot)
    due = attempt(balance, policy, balance.simulator(), rows=1, rng=None)
    every = round(balance.period / balance.step)
    # The start is told to six figures, so an angle of pi is off by 3e-6; feedback does not grow it.
    for joint in ("slide", "hinge"):
        found = run[f"{joint}.position"][::every]
        assert found == pytest.approx(due.joint(joint)[0], abs=1e-4)


def test_each_trial_is_a_line_unless_quiet(capsys: pytest.CaptureFixture[str], bench: Any) -> None:
    bench.learn(*BALANCE)
    lines = capsys.readouterr().err.splitlines()
    assert [
        re.match(r"trial (\d), loss [\d.e+]+, success \d+ %, [\d.]+ s$", each) for each in lines
    ]
    assert len(lines) == 5


def test_json_is_the_record(capsys: pytest.CaptureFixture[str], bench: Any) -> None:
    bench.learn(*BALANCE, "--quiet", "--json")
    assert capsys.readouterr().out == Path("out/record.json").read_text()


def test_a_search_that_does_not_succeed_says_so_everywhere(
    capsys: pytest.CaptureFixture[str], bench: Any
) -> None:
    bench.learn(*BALANCE, "--quiet", "--trials", "1", status=3)
    words = capsys.readouterr().out
    assert "has not learned balance" in words
    assert "it did not succeed: its feedback is too weak" in words
    said = bench.record()
    assert (said["succeeded"], said["why"]) == (False, "its feedback is too weak")
    learned = json.loads(Path("out/policy/policy.json").read_text())["learned"]
    assert (learned["success"], learned["succeeded"]) == (0.0, False)
    assert "marked as one that did not succeed" in Path("out/report.html").read_text()


def test_a_search_from_trials_is_given_no_simulator(bench: Any, growing: Any) -> None:
    bench.learn(
        "balance", "--robot", "cartpole", "--search", "from-trials", "--out", "out", "--quiet"
    )
    (problem,) = growing.seen
    assert problem.simulator is None
    assert problem.target is not None
    assert bench.record()["spent"]["experience_s"] == 25.0
    assert "s of experience" in Path("out/report.html").read_text()


def test_what_is_asked_to_act_acts_on_the_target_and_is_recorded(bench: Any, growing: Any) -> None:
    bench.learn(
        *BALANCE, "--quiet", "--trials", "1", "--effect", "viscous_friction@hinge:b=5", status=3
    )
    (problem,) = growing.seen
    assert problem.model.model.dof_damping[1] == 5.0
    assert bench.record()["effects"] == ["viscous_friction@hinge"]


def test_where_nothing_draws_the_report_says_so(bench: Any) -> None:
    bench.learn(*BALANCE, "--quiet")
    assert bench.record()["notes"] == ["there are no pictures: there is no OpenGL"]
    assert "there are no pictures: there is no OpenGL" in Path("out/report.html").read_text()


def test_a_search_whose_policy_fails_when_judged_did_not_succeed(
    monkeypatch: pytest.MonkeyPatch, bench: Any, growing: Any
) -> None:
    run = growing.run

    def boasting(self: Any, problem: Any, **how: Any) -> Learned:
        return replace(run(self, problem, **how), succeeded=True, why="")

    monkeypatch.setattr(growing, "run", boasting)
    bench.learn(*BALANCE, "--quiet", "--trials", "1", status=3)
    assert bench.record()["why"] == "0 of 2 runs reach every goal"


def test_tasks_are_listed(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    assert main(["list", "tasks", "--json"]) == 0
    rows = {row["name"]: row for row in json.loads(capsys.readouterr().out)["tasks"]}
    assert rows["swing-up"]["search"] == "ddp"
    assert "cartpole" in rows["balance"]["robots"]
    assert rows["balance"]["what"].startswith("Keep a chain upright")
    assert main(["list", "tasks"]) == 0
    assert max(map(len, capsys.readouterr().out.splitlines())) <= 80
