from __future__ import annotations

import os
import threading
import time
from pathlib import Path

import pytest

from morph.print.run_with_timeout import Ran, attended

PATH = {"PATH": os.environ["PATH"]}


def shell(script: str, folder: Path, timeout_s: float = 60.0) -> Ran:
    return attended(["sh", "-c", script], folder=folder, environment=PATH, timeout_s=timeout_s)


def ended(number: int) -> bool:
    """Whether a process is gone, or is dead and waits to be buried by its parent."""
    try:
        return Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except FileNotFoundError:
        return True


def wait_until_ended(number: int) -> None:
    end = time.monotonic() + 60.0
    while not ended(number):
        assert time.monotonic() < end, f"process {number} is still there"
        time.sleep(0.01)


def test_what_is_said_and_the_status_come_back(tmp_path: Path) -> None:
    ran = shell("echo out; echo err >&2; exit 3", tmp_path)
    assert (ran.status, ran.said) == (3, "out\nerr\n")


def test_a_signal_is_told_as_a_negative_status(tmp_path: Path) -> None:
    assert shell("kill -SEGV $$", tmp_path).status == -11


def test_what_hangs_is_killed_with_its_children(tmp_path: Path) -> None:
    ran = shell("sleep 600 & echo $!; sleep 600", tmp_path, timeout_s=0.3)
    assert ran.status is None
    wait_until_ended(int(ran.said))


def test_a_child_left_behind_neither_holds_us_up_nor_stays(tmp_path: Path) -> None:
    ran = shell("sleep 600 & echo $!; exit 0", tmp_path)
    assert ran.status == 0
    wait_until_ended(int(ran.said))


def test_another_thread_can_stop_it(tmp_path: Path) -> None:
    stop = threading.Event()
    threading.Timer(0.2, stop.set).start()
    ran = attended(["sleep", "60"], folder=tmp_path, environment=PATH, timeout_s=60.0, stop=stop)
    assert ran.status is None


def test_no_more_than_a_megabyte_is_heard_of_a_chatterer(tmp_path: Path) -> None:
    assert len(shell("yes | head -c 3000000", tmp_path).said) == 1_000_000


def test_a_program_that_is_not_there_is_an_os_error(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="no-such-slicer"):
        attended(["/no-such-slicer"], folder=tmp_path, environment=PATH, timeout_s=1.0)
