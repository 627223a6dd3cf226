"""Whose loop a folder holds, and when what is in it is trusted."""

from __future__ import annotations

import fcntl
import shutil
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from morph.app.cli.arguments import Loop
from morph.app.cli.heartbeat import beating
from morph.app.cli.loop_key import key_of
from morph.app.cli.target_options import live_aim
from morph.body.load import load
from morph.run_folder import LOCK
from morph.task.tasks import task

LONG = ("--change", "length:pole=1.2")
ONE = (*LONG, "--quiet", "--trials", "1")
GARBAGE = '{"hops":[{"succeeded":true,"trials":[]}]}'


def live_key(command: str, *limits: str) -> dict[str, str]:
    asked = Loop(task="balance", robot="cartpole", out="out", live=command, limit=limits)
    balance = task("balance", load("cartpole"))
    given: Any = SimpleNamespace(weights=dict)
    return key_of(asked, balance, given, live_aim(asked, balance, Path("recorded")))


@pytest.mark.parametrize(
    ("command", "limits"),
    [
        ("python other.py", ("speed:slide=2", "rate:slide=50")),
        ("python rig.py --arm 2", ("speed:slide=2", "rate:slide=50")),
        ("python rig.py", ("speed:slide=3", "rate:slide=50")),
        ("python rig.py", ()),
    ],
)
def test_another_program_or_argument_or_limit_is_another_live_loop(
    command: str, limits: tuple[str, ...]
) -> None:
    key = live_key("python rig.py", "speed:slide=2", "rate:slide=50")
    assert live_key(command, *limits) != key
    assert live_key("python  rig.py", "rate:slide=50", "speed:slide=2") == key


def test_a_folder_in_which_a_loop_works_is_refused_to_a_second(bench: Any) -> None:
    bench.loop(*ONE, status=3)
    bench._capsys.readouterr()
    with (Path("out") / LOCK).open("ab") as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        found = bench.refused(*bench.words("--policy", "weak", *ONE))
        assert "another morph works in this folder" in found["what"]
    # The file alone, as after a kill, holds nobody.
    bench.loop(*ONE, status=3)
    assert not (Path("out") / LOCK).exists()


def test_beginning_anew_does_not_remove_what_the_loop_is_given(bench: Any) -> None:
    bench.loop(*ONE, status=3)
    bench._capsys.readouterr()
    words = bench.words(*ONE, "--fresh")
    for given in ("out/policy", "weak/../out/trials/00/policy"):
        found = bench.refused(*words, "--policy", given)
        assert "would remove what --policy names" in found["what"]
    found = bench.refused(*words, "--policy", "weak", "--robot", "out/corrected.xml")
    assert "would remove what --robot names" in found["what"]


def without_policy() -> None:
    shutil.rmtree("out/policy")


def without_weights() -> None:
    Path("out/policy/weights.safetensors").write_bytes(b"none")


def without_report() -> None:
    Path("out/report.html").unlink()


def with_garbage() -> None:
    Path("out/transfer.json").write_text(GARBAGE)


@pytest.mark.parametrize("spoil", [without_policy, without_weights, without_report, with_garbage])
def test_a_finished_loop_that_is_not_whole_is_computed_again_from_its_trials(
    spoil: Callable[[], None], bench: Any
) -> None:
    bench.loop(*ONE, status=3)
    before, calls = bench.content(), bench.knowing.calls
    spoil()
    bench.loop(*ONE, status=3)
    assert bench.knowing.calls == calls + 1
    trial = "out/trials/00/experience.npz"
    assert bench.content()[trial] == before[trial]
    assert set(bench.content()) == set(before)


def test_with_a_single_trial_nothing_is_said_of_what_a_search_found(bench: Any) -> None:
    bench.loop(*ONE, status=3)
    why = bench.record()["hops"][0]["why"]
    assert "with one trial no policy is searched" in why
    assert "motors" not in why


def test_a_pipe_is_told_what_is_done_and_not_of_every_stage(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    alone = threading.active_count()
    now, looked, written = [0.0], [0], threading.Event()
    write = sys.stderr.write

    def clock() -> float:
        looked[0] += 1
        return now[0]

    def noticed(text: str) -> int:
        written.set()
        return write(text)

    def looks(times: int) -> None:
        until = looked[0] + times
        while looked[0] < until:
            time.sleep(0.001)

    monkeypatch.setattr("morph.app.cli.heartbeat.time", SimpleNamespace(monotonic=clock))
    monkeypatch.setattr(sys.stderr, "write", noticed)
    with beating(False, every=0.2) as told:
        told.now("short")
        told.now("long")
        now[0] = 0.2
        assert written.wait(60.0)
        # The same stage is told once more after a minute, not after 0.2 s.
        now[0] = 59.0
        looks(5)
    assert capsys.readouterr().err == "[0 s] long\n"
    with beating(True, every=0.01) as told:
        told.now("long")
        assert threading.active_count() == alone
    assert capsys.readouterr().err == ""
