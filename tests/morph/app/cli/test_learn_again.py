from __future__ import annotations

import inspect
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from morph.run_folder import LOCK, OWNED

BALANCE = ("balance", "--robot", "cartpole", "--search", "growing", "--out", "out")


def test_an_interrupted_search_goes_on_to_what_it_would_have_found(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], bench: Any, growing: Any
) -> None:
    bench.learn(*BALANCE[:-1], "whole", "--quiet")
    monkeypatch.setattr(growing, "interrupted", 3)
    bench.learn(*BALANCE, "--quiet", status=130)
    assert "after 2 trials; the same command goes on from there" in capsys.readouterr().err
    assert sorted(bench.content()) == [f"out/{OWNED}", "out/state.npz"]
    monkeypatch.setattr(growing, "interrupted", 0)
    bench.learn(*BALANCE)
    lines = capsys.readouterr().err.splitlines()
    assert [each.split(",")[0] for each in lines] == ["trial 3", "trial 4", "trial 5"]
    again, whole = bench.record(), bench.record("whole")
    assert [each["loss"] for each in again["trials"]] == [each["loss"] for each in whole["trials"]]
    assert again["judged"] == whole["judged"]
    seconds = [each["seconds"] for each in again["trials"]]
    assert seconds == sorted(seconds)
    weights = "policy/weights.safetensors"
    assert bench.content()[f"out/{weights}"] == bench.content("whole")[f"whole/{weights}"]


def test_an_interrupt_before_the_first_trial_leaves_nothing(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], bench: Any, growing: Any
) -> None:
    monkeypatch.setattr(growing, "interrupted", 1)
    bench.learn(*BALANCE, status=130)
    assert capsys.readouterr().err == "interrupted; nothing was written\n"
    assert not Path("out").exists()


def test_a_killed_search_goes_on(
    capsys: pytest.CaptureFixture[str], bench: Any, growing: Any
) -> None:
    here = inspect.getfile(growing)
    script = f"""
import importlib.util, sys
spec = importlib.util.spec_from_file_location("tried_searches", {str(here)!r})
module = importlib.util.module_from_spec(spec)
sys.modules["tried_searches"] = module
spec.loader.exec_module(module)
module.Growing.slow = 1.0
module.TASKS["balance"] = module.shorter
module.searches.SEARCHES = {{"growing": "tried_searches:Growing"}}
sys.exit(module.main({["learn", *BALANCE, "--trials", "100"]!r}))
"""
    process = subprocess.Popen([sys.executable, "-c", script], stderr=subprocess.DEVNULL)
    until = time.monotonic() + 60.0
    while not Path("out/state.npz").exists() and time.monotonic() < until:
        time.sleep(0.02)
    process.send_signal(signal.SIGKILL)
    assert process.wait() == -signal.SIGKILL
    # The lock's file stays after a kill, and holds nobody.
    assert set(bench.content()) - {f"out/{LOCK}", f"out/{OWNED}"} == {"out/state.npz"}
    bench.learn(*BALANCE)
    told = capsys.readouterr().err
    assert "trial 1," not in told
    assert "trial 5," in told
    assert [each["number"] for each in bench.record()["trials"]] == [1, 2, 3, 4, 5]


def test_what_is_done_is_not_done_again(
    capsys: pytest.CaptureFixture[str], bench: Any, growing: Any
) -> None:
    bench.learn(*BALANCE, "--quiet", "--trials", "1", status=3)
    before = bench.content()
    capsys.readouterr()
    bench.learn(*BALANCE, "--trials", "1", status=3)
    told = capsys.readouterr()
    assert "out holds this search already, and it did not succeed" in told.out
    assert told.err == ""
    assert len(growing.seen) == 1
    assert bench.content() == before
    bench.learn(*BALANCE, "--trials", "1", "--json", status=3)
    assert capsys.readouterr().out == Path("out/record.json").read_text()


def test_more_trials_go_on_from_those_that_were_made(
    capsys: pytest.CaptureFixture[str], bench: Any
) -> None:
    bench.learn(*BALANCE, "--quiet", "--trials", "2", status=3)
    bench.learn(*BALANCE, "--trials", "4")
    lines = capsys.readouterr().err.splitlines()
    assert [each.split(",")[0] for each in lines] == ["trial 3", "trial 4"]
    assert [each["number"] for each in bench.record()["trials"]] == [1, 2, 3, 4]


def test_a_killed_search_leaves_no_record_of_the_one_before(
    monkeypatch: pytest.MonkeyPatch, bench: Any, growing: Any
) -> None:
    bench.learn(*BALANCE, "--quiet", "--trials", "1", status=3)
    monkeypatch.setattr(growing, "interrupted", 3)
    bench.learn(*BALANCE, "--quiet", "--trials", "4", status=130)
    # The lock's file stays after a kill, and holds nobody.
    assert set(bench.content()) - {f"out/{LOCK}", f"out/{OWNED}"} == {"out/state.npz"}
