"""One process at a time works in a run folder."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from morph.errors import OutputError
from morph.run_folder import LOCK, lock_of, lock_run_folder

HOLD = """
import sys
from pathlib import Path
from morph.run_folder import lock_run_folder
with lock_run_folder(Path(sys.argv[1]), beside=sys.argv[2] == "beside"):
    print("held", flush=True)
    sys.stdin.read()
"""

PLACES = pytest.mark.parametrize("beside", [False, True])


@contextmanager
def holder(folder: Path, beside: bool) -> Iterator[subprocess.Popen[str]]:
    """Lend a process that holds a folder until its input ends."""
    with subprocess.Popen(
        [sys.executable, "-c", HOLD, str(folder), "beside" if beside else "inside"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "held\n"
        try:
            yield process
        finally:
            process.kill()


@PLACES
def test_a_folder_that_another_process_holds_is_refused_by_its_number_and_time(
    tmp_path: Path, beside: bool
) -> None:
    out = tmp_path / "out"
    with holder(out, beside) as other:
        with pytest.raises(OutputError) as caught, lock_run_folder(out, beside=beside):
            pass
        assert re.search(rf"process {other.pid} on \S+ since \d{{4}}-\d\d-\d\d ", caught.value.what)
        assert caught.value.where == str(out)
        # The fix works: what it names ends the process, and then the folder is free.
        (command,) = re.findall(r"`(.*?)`", caught.value.fix)
        subprocess.run(command.split(), check=True)
        assert other.wait() == -signal.SIGTERM
        with lock_run_folder(out, beside=beside):
            pass


@PLACES
def test_a_killed_process_holds_nothing(tmp_path: Path, beside: bool) -> None:
    out = tmp_path / "out"
    with holder(out, beside) as other:
        other.send_signal(signal.SIGKILL)
        other.wait()
    assert lock_of(out, beside=beside).is_file()
    with lock_run_folder(out, beside=beside):
        pass
    assert not lock_of(out, beside=beside).exists()


@PLACES
def test_who_waits_for_the_end_gets_the_folder(tmp_path: Path, beside: bool) -> None:
    out = tmp_path / "out"
    with holder(out, beside) as other:
        other.communicate()
        assert other.returncode == 0
        with holder(out, beside):
            pass


@PLACES
def test_what_was_made_for_the_lock_goes_if_nothing_came_of_it(
    tmp_path: Path, beside: bool
) -> None:
    out = tmp_path / "a" / "b" / "out"
    with lock_run_folder(out, beside=beside):
        assert lock_of(out, beside=beside).is_file()
        assert out.exists() is not beside
    assert list(tmp_path.iterdir()) == []
    out.mkdir(parents=True)
    with lock_run_folder(out, beside=beside):
        pass
    # An empty folder that was there before stays.
    assert out.is_dir()


def test_a_folder_with_results_keeps_them_and_not_the_lock(tmp_path: Path) -> None:
    with lock_run_folder(tmp_path / "out"):
        (tmp_path / "out" / "result").write_text("42")
    assert os.listdir(tmp_path / "out") == ["result"]


def test_long_names_that_begin_alike_have_locks_of_their_own(tmp_path: Path) -> None:
    one, other = (tmp_path / ("x" * 250 + end) for end in "ab")
    with lock_run_folder(one, beside=True), lock_run_folder(other, beside=True):
        assert len(list(tmp_path.iterdir())) == 2


@pytest.mark.parametrize("kind", ["pipe", "link", "folder"])
def test_what_stands_in_place_of_the_lock_is_neither_waited_for_nor_followed(
    tmp_path: Path, kind: str
) -> None:
    precious = tmp_path / "precious"
    precious.write_text("precious")
    out = tmp_path / "out"
    out.mkdir()
    {
        "pipe": lambda: os.mkfifo(out / LOCK),
        "link": lambda: (out / LOCK).symlink_to(precious),
        "folder": (out / LOCK).mkdir,
    }[kind]()
    with pytest.raises(OutputError, match="it cannot be locked"), lock_run_folder(out):
        pass
    assert precious.read_text() == "precious"
