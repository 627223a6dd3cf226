from __future__ import annotations

import gc
import json
import os
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

from morph.arrays import Array
from morph.errors import TransferError, TrialStopped
from morph.policy.linear import Linear
from morph.policy.observing import observations_of
from morph.policy.policy import actions_of
from morph.policy_transfer.live.live import Live
from morph.policy_transfer.live.process import Process
from morph.policy_transfer.live.watch import Watch
from morph.task.task import Task

PUSH = np.full((10, 1), 1.0)
STEADY = Watch(
    answer_within=60.0, stop_within=60.0, open_within=60.0, begin_within=60.0, unreadable=30
)
"""Waits for a target that is well, however busy the machine is."""

HASTY = replace(STEADY, answer_within=2.0, stop_within=0.2)
"""Waits for one that will not answer."""


def live(swing: Task, process: Process, watch: Watch = STEADY) -> Live:
    return Live(swing, process, watch=watch)


def test_a_process_is_told_every_command_and_to_stop_and_may_go_on(
    swing: Task, speaking: object, log: Path
) -> None:
    target = live(swing, speaking())  # type: ignore[operator]
    for _ in range(2):
        shown = target.trial(PUSH, np.random.default_rng(0))
        assert len(shown.position) == 11
    target.close()
    once = ['{"command": {"slide": 1.0}}'] * 10 + ["stop"]
    assert log.read_text().splitlines() == [*once, *once, "end of input"]


NOISY = """
def on_state(k, said):
    for line in (b"[driver] 31.2 C\\n", b"x" * 200000 + b"\\n", b"[" * 9000 + b"\\n"):
        say(line)
    say(b"\\xff\\x00\\n")
    say(said)
"""


def test_lines_that_are_no_messages_are_survived_up_to_a_number(
    swing: Task, speaking: object
) -> None:
    # Four lines before each of eleven states.
    patient = replace(STEADY, unreadable=44)
    target = live(swing, speaking(NOISY), patient)  # type: ignore[operator]
    assert len(target.trial(PUSH, np.random.default_rng(0)).position) == 11
    assert target.conduct is not None
    assert target.conduct.unreadable == 44
    target.close()
    target = live(swing, speaking(NOISY))  # type: ignore[operator]
    # The third of the four lines before the eighth state is the 31st.
    with pytest.raises(TrialStopped, match=r"31 lines are no states, the last: b'\[.* 7 of 11"):
        target.trial(PUSH, np.random.default_rng(0))
    target.close()


CLOCKED = """
import threading
def stream(begun):
    for k in range(11):
        time.sleep(max(0.0, begun + 0.05 * k - time.monotonic()))
        say({"t": 0.05 * k, "state": state(k)})
        log(f"state {k}")
def on_state(k, said):
    if k == 0:
        threading.Thread(target=stream, args=(time.monotonic(),)).start()
"""


class Slow(Linear):
    """Thinks once, at 0.1 s, until the target has said more; commands ten times the time."""

    log: ClassVar[Path]

    def act(self, observation: Array, time_: Array) -> Array:
        # The state at 0.3 s is two after the ones that are missed for certain.
        while abs(time_[0] - 0.1) < 1e-9 and "state 6" not in self.log.read_text():
            time.sleep(0.001)
        return 10.0 * np.asarray(time_)[:, None]


def test_a_policy_that_is_too_slow_holds_its_last_command_and_is_counted(
    swing: Task, speaking: object, log: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Slow, "log", log, raising=False)
    policy = Slow(
        action=actions_of(swing.robot),
        observation=observations_of(swing.robot),
        period=swing.period,
        weight=np.zeros((1, 4)),
        bias=np.zeros(1),
    )
    target = live(swing, speaking(CLOCKED, {"clock": "target"}))  # type: ignore[operator]
    shown = target.trial(policy, np.random.default_rng(0))
    target.close()
    assert target.conduct is not None
    # States at 0.15 to 0.3 s come while it thinks about the one at 0.1 s, so at least 0.1 and
    # 0.15 s hold the command of 0.05 s.
    assert target.conduct.overruns >= 2
    assert shown.command[2:4, 0].tolist() == [shown.command[1, 0]] * 2
    assert len(shown.position) == 11
    # What is recorded as new was sent, and what was held was not.
    said = [line for line in log.read_text().splitlines() if line.startswith("{")]
    sent = [json.loads(line)["command"]["slide"] for line in said]
    assert len(sent) == 10 - target.conduct.overruns
    assert set(sent) == set(shown.command[:, 0].tolist())


FAULTS = {
    "it dies": (
        "def on_state(k, said):\n if k == 4: sys.exit('motor on fire')\n say(said)",
        r"it closed its output and ended with status 1, saying 'motor on fire'; 4 of 11 states",
    ),
    "it stops answering": (
        "def on_state(k, said):\n if k < 4: say(said)",
        r"it stopped answering: no state came within 2 s; 4 of 11 .* said that it stopped",
    ),
    "it reads nothing": (
        "def on_state(k, said):\n if k == 4: time.sleep(600)\n say(said)",
        r"it stopped answering.*did not say that it stopped, and was let go",
    ),
    "it reports an error": (
        "def on_state(k, said):\n say({'error': 'overheated'} if k == 4 else said)",
        r"it says: 'overheated'",
    ),
    "it stops its clock": (
        "def on_state(k, said):\n said['t'] = min(said['t'], 0.2)\n say(said)",
        r"its time went from 0.2 to 0.2 s",
    ),
    "it floods": (
        "def on_state(k, said):\n while True: say(b'x\\n')",
        r"31 lines are no states, the last: b'x' is no JSON object",
    ),
    "a sensor says null": (
        "def on_state(k, said):\n said['state']['hinge.velocity'] = None\n say(said)",
        r"hinge.velocity is no finite number: a dead sensor",
    ),
    "a sensor says a number too great": (
        "def on_state(k, said):\n said['state']['hinge.velocity'] = 10 ** 400\n say(said)",
        r"hinge.velocity is no finite number: a dead sensor",
    ),
}

SILENT = {"it stops answering", "it reads nothing", "it floods"}
"""Faults after which a target will not say that it stopped, however long one waits."""


@pytest.mark.parametrize("fault", FAULTS)
def test_a_trial_ends_with_a_message_if(
    swing: Task, speaking: object, fault: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("morph.policy_transfer.live.process.LEAVE", 0.2)
    change, says = FAULTS[fault]
    watch = HASTY if fault in SILENT else STEADY
    target = live(swing, speaking(change), watch)  # type: ignore[operator]
    with pytest.raises(TrialStopped, match=says):
        target.trial(PUSH, np.random.default_rng(0))
    target.close()


def test_a_process_that_will_not_end_is_ended(
    speaking: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("morph.policy_transfer.live.process.LEAVE", 0.1)
    stubborn = "import signal\nsignal.signal(signal.SIGTERM, signal.SIG_IGN)\n"
    stubborn += "import atexit\natexit.register(time.sleep, 600)"
    process = speaking(stubborn)  # type: ignore[operator]
    process.open(60.0)
    number = process._process.pid
    process.close()
    with pytest.raises(ProcessLookupError):
        os.kill(number, 0)


@pytest.mark.parametrize(
    ("program", "says"),
    [
        ("", r"it closed its output and ended with status 0 before it said who it is"),
        ("raise SystemExit('no port')", r"status 1, saying 'no port' before it said"),
        ("import time; print('hi', flush=True); time.sleep(600)", r"in 0.5 s it did not say who"),
        ('print(\'{"schema": "other/1"}\')', r"its schema is 'other/1'"),
        ("while True: print('x')", r"it did not say who it is; 101 lines are no JSON objects"),
    ],
)
def test_a_process_that_does_not_say_who_it_is_is_refused(
    program: str, says: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("morph.policy_transfer.live.process.LEAVE", 0.2)
    with pytest.raises(TransferError, match=says):
        Process([sys.executable, "-S", "-c", program]).open(0.5 if "sleep" in program else 60.0)


def test_a_program_that_is_not_there_is_refused() -> None:
    with pytest.raises(TransferError, match=r"target drive: it cannot be started: No such file"):
        Process(["./drive"]).open(1.0)


def test_no_file_descriptor_is_left_open(speaking: object) -> None:
    def opened() -> int:
        return len(os.listdir("/proc/self/fd"))

    if not Path("/proc/self/fd").is_dir():
        pytest.skip("this system does not list a process's files")
    # Cycles of earlier tests may hold files, and are collected at any time: only more is a leak.
    gc.collect()
    before = opened()
    for _ in range(2):
        process = speaking()  # type: ignore[operator]
        process.open(60.0)
        process.close()
    until = time.monotonic() + 60.0
    # The threads that read close their ends when they meet the end of the file.
    while opened() > before and time.monotonic() < until:
        time.sleep(0.01)
    assert opened() <= before


LEAVING = """
def on_state(k, said):
    say(said)
    if k == %d and os.fork():
        # The child holds the pipes open, and says nothing.
        os._exit(3)
    if k == %d:
        time.sleep(30.0)
        os._exit(0)
"""


@pytest.mark.parametrize("at", [0, 4])
def test_a_process_that_forks_and_ends_is_gone_though_its_pipes_are_open(
    swing: Task, speaking: object, at: int
) -> None:
    patient = replace(STEADY, stop_within=0.1)
    target = live(swing, speaking(LEAVING % (at, at)), patient)  # type: ignore[operator]
    with pytest.raises(TrialStopped, match=r"a process that is gone and ended with status 3"):
        target.trial(PUSH, np.random.default_rng(0))
    target.close()


def test_a_process_that_forks_and_ends_before_it_speaks_is_gone(
    swing: Task, speaking: object
) -> None:
    silent = "if os.fork():\n    os._exit(3)\ntime.sleep(30.0)\nos._exit(0)"
    process = speaking(silent)  # type: ignore[operator]
    with pytest.raises(TransferError, match=r"gone and ended with status 3.* before it said who"):
        process.open(60.0)
