from __future__ import annotations

import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

import morph
from morph.app.cli.main import main
from morph.body import shelf

COMMAND = [sys.executable, "-c", "from morph.app.cli.main import entry; entry()"]


def test_nobody_who_reads_on_is_no_error() -> None:
    process = subprocess.Popen(
        [*COMMAND, "inspect", "humanoid", "--json"], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    assert process.stdout is not None
    assert process.stderr is not None
    process.stdout.read(1)
    process.stdout.close()
    assert process.wait(timeout=60) == 0
    assert process.stderr.read() == b""
    process.stderr.close()


def test_a_full_disk_behind_the_output_is_said() -> None:
    if not Path("/dev/full").exists():
        pytest.skip("this system has no /dev/full")
    with Path("/dev/full").open("wb") as full:
        done = subprocess.run(
            [*COMMAND, "list", "robots"],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
            # Buffered, as it is where nobody asked otherwise: what is left fails again at the end.
            env={key: value for key, value in os.environ.items() if key != "PYTHONUNBUFFERED"},
        )
    assert done.returncode == 2
    assert done.stderr.startswith("error: standard output: No space left on device\n  fix: ")


@pytest.mark.parametrize(
    "command",
    ["inspect", "convert", "diagnose", "simulate", "learn", "align", "transfer", "list"],
)
def test_help_has_an_example(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        main([command, "--help"])
    assert left.value.code == 0
    assert f"Example: morph {command} " in capsys.readouterr().out


def test_the_version_is_said(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"morph {morph.__version__}\n"


def test_every_body_of_the_shelf_is_listed(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    assert main(["list", "robots"]) == 0
    rows = capsys.readouterr().out.splitlines()
    assert [row.split()[0] for row in rows[1:] if row[0] != " "] == sorted(shelf.names())
    assert max(map(len, rows)) <= 80


@pytest.mark.parametrize(
    ("arguments", "status"),
    [("inspect pendulum", 0), ("list robots --json", 0), ("inspect no_such", 2), ("--help", 0)],
)
def test_a_closed_output_is_no_error(arguments: str, status: int) -> None:
    line = shlex.join([*COMMAND, *shlex.split(arguments)])
    done = subprocess.run(
        f"{line} >&-", shell=True, capture_output=True, text=True, check=False, timeout=60
    )
    assert (done.returncode, done.stderr) == (status, "")


def test_a_closed_error_output_hides_no_status() -> None:
    line = shlex.join([*COMMAND, "convert", "no_such", "--to", "mjcf", "--out", "x"])
    done = subprocess.run(f"{line} >&- 2>&-", shell=True, check=False, timeout=60)
    assert done.returncode == 2


def test_help_that_nobody_reads_is_no_error() -> None:
    line = shlex.join([*COMMAND, "--help"])
    # The reader is gone before the first word.
    done = subprocess.run(
        f"(sleep 0.2; {line}; echo $? >&2) | true",
        shell=True,
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert done.stderr == "0\n"
