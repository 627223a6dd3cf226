"""A study that is stopped from outside: by Ctrl-C, and by SIGKILL."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import ModuleType

import pytest

from morph.app.cli.main import main
from morph.study.engine import EngineOptions, WorkerDied

PATIENCE = 120.0
"""Seconds after which a test gives up: it would hang."""


def until(true: Callable[[], bool], what: str) -> None:
    end = time.monotonic() + PATIENCE
    while not true():
        assert time.monotonic() < end, f"waited {PATIENCE} s until {what}"
        time.sleep(0.01)


def running(pid: int) -> bool:
    """Return whether a process runs: one that has ended and was not waited for does not."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


# A shell that starts things in its background has them ignore interrupts.
HEARS = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
MORPH = (sys.executable, "-c", HEARS + "from morph.app.cli.main import entry; entry()", "study")

STUDY = """
function = "toy_cells:mixed"
[grid]
x = "0:6"
gate = ["{gate}"]
ready = ["{ready}"]
"""


@pytest.fixture
def study(toy: ModuleType, tmp_path: Path, marks: Path) -> Path:
    """A file of two cells that end at once and four that wait for the gate."""
    with Path("toy_cells.py").open("a") as file:
        file.write(
            "\ndef mixed(x, gate, ready):\n"
            "    return waiting(x, gate, ready) if x > 1 else square(x)\n"
        )
    sys.modules.pop("toy_cells")
    path = Path("mixed.toml")
    path.write_text(STUDY.format(gate=tmp_path / "gate", ready=marks))
    return path.absolute()


@contextmanager
def under_way(study: Path, marks: Path) -> Iterator[subprocess.Popen[str]]:
    """Lend the process of a study that has two results and two cells that wait."""
    process = subprocess.Popen(
        [*MORPH, str(study), "--out", "out"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    try:
        until(lambda: len(list(marks.iterdir())) == 2, "two cells wait")
        until(lambda: len(list(Path("out/cells").glob("*.json"))) == 2, "two results are kept")
        yield process
    finally:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.communicate()


def pids(marks: Path) -> list[int]:
    return [int(path.suffix[1:]) for path in marks.iterdir()]


def rows(study: Path) -> list[int]:
    """Return what the study gives when it goes on."""
    assert main(["study", str(study), "--out", "out", "--resume", "--engine", "inline"]) == 0
    return [each["row"]["x"] for each in json.loads(Path("out/rows.json").read_text())["rows"]]


def test_ctrl_c_ends_the_workers_keeps_what_had_ended_and_says_how_to_go_on(
    study: Path, tmp_path: Path, marks: Path
) -> None:
    with under_way(study, marks) as process:
        # As a terminal does: to all processes of the group.
        os.killpg(process.pid, signal.SIGINT)
        _, said = process.communicate(timeout=PATIENCE)
        assert process.returncode == 130
        assert "interrupted; 2 results are saved in out: go on with --resume" in said
        assert "Traceback" not in said
        until(lambda: not any(map(running, pids(marks))), "the workers are gone")
    (tmp_path / "gate").touch()
    assert rows(study) == list(range(6))


def test_after_a_sigkill_the_workers_end_and_the_study_goes_on_where_it_was(
    study: Path, tmp_path: Path, marks: Path
) -> None:
    with under_way(study, marks) as process:
        os.kill(process.pid, signal.SIGKILL)
        until(lambda: not any(map(running, pids(marks))), "the workers are gone")
    kept = {path: path.stat().st_mtime_ns for path in Path("out/cells").iterdir()}
    assert len(kept) == 2
    (tmp_path / "gate").touch()
    assert rows(study) == list(range(6))
    assert {path: path.stat().st_mtime_ns for path in kept} == kept
    # Two that were under way are begun again; nothing else is.
    assert len(pids(marks)) == 2 + 4


SUBMIT = """
from pathlib import Path
from morph.study.engine import EngineOptions
from toy_cells import waiting
engine = EngineOptions(engine="submitit-local", workers=1).start(Path("out"))
engine.submit(waiting, 1, {gate!r}, {ready!r}).result()
"""


def test_jobs_on_this_machine_end_with_a_study_that_is_killed(
    toy: ModuleType, tmp_path: Path, marks: Path
) -> None:
    program = SUBMIT.format(gate=str(tmp_path / "gate"), ready=str(marks))
    process = subprocess.Popen([sys.executable, "-c", program])
    try:
        until(lambda: len(pids(marks)) == 1, "the job runs")
        process.kill()
        until(lambda: not running(pids(marks)[0]), "the job is gone")
    finally:
        (tmp_path / "gate").touch()
        process.kill()
        process.wait()


def test_a_job_on_this_machine_ends_by_sigterm(
    toy: ModuleType, tmp_path: Path, marks: Path
) -> None:
    engine = EngineOptions(engine="submitit-local", workers=1).start(tmp_path / "out")
    try:
        future = engine.submit(toy.waiting, 1, str(tmp_path / "gate"), str(marks))
        until(lambda: len(pids(marks)) == 1, "the job runs")
        os.kill(pids(marks)[0], signal.SIGTERM)
        with pytest.raises(WorkerDied):
            future.result(timeout=PATIENCE)
    finally:
        (tmp_path / "gate").touch()
        engine.shutdown()
    assert not running(pids(marks)[0])
    assert list((tmp_path / "out").iterdir()) == []


def test_ctrl_c_ends_a_study_in_this_process(
    study: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with Path("toy_cells.py").open("a") as file:
        file.write(
            "\ndef mixed(x, gate, ready):\n"
            "    if x == 2:\n        raise KeyboardInterrupt\n    return square(x)\n"
        )
    assert main(["study", str(study), "--out", "out", "--engine", "inline"]) == 130
    assert "interrupted; 2 results are saved in out" in capsys.readouterr().err
