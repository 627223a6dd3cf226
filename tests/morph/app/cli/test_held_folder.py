"""Every command that writes a folder refuses one that another process works in."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from morph.app.cli.main import main
from morph.run_folder import LOCK

HOLD = """
import sys
from pathlib import Path
from morph.run_folder import lock_run_folder
with lock_run_folder(Path(sys.argv[1]), beside=sys.argv[2] == "beside"):
    print("held", flush=True)
    sys.stdin.read()
"""

COMMANDS = {
    "learn": "learn swing-up --robot pendulum --out out",
    "loop": "loop balance --robot cartpole --change length:pole=1.2 --out out",
    "align": "align cartpole rider_rigid_driven --out out",
    "transfer": "transfer --from learned --chain cartpole rider_rigid_driven --out out",
    "diagnose": "diagnose pendulum run.csv --out out",
    "print": "print so101 --printer mk4 --material pla --slicer none --out out",
    "weigh": "weigh out P-01=12.4",
}
"""A command line each, none of which would take long."""

REPLACED = ("diagnose", "print", "weigh")
"""Those that replace their folder whole: its lock stands beside it."""


@pytest.fixture
def holder(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[subprocess.Popen[str]]:
    """A process that holds the folder `out`, as the command would."""
    monkeypatch.chdir(tmp_path)
    time = np.linspace(0.0, 1.0, 100)
    lines = [f"{t},{np.sin(t)},0" for t in time]
    Path("run.csv").write_text("\n".join(["time,hinge.position,hinge.command", *lines]))
    with subprocess.Popen(
        [
            *(sys.executable, "-c", HOLD, str(tmp_path / "out")),
            "beside" if command in REPLACED else "inside",
        ],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "held\n"
        yield process
        process.kill()


@pytest.mark.parametrize("command", COMMANDS)
def test_a_folder_that_is_held_is_refused_and_left_alone(
    command: str, holder: subprocess.Popen[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(COMMANDS[command].split()) == 2
    said = capsys.readouterr()
    assert f"error: out: another morph works in this folder now: process {holder.pid}" in said.err
    assert f"fix: wait until it has ended, or end it by `kill {holder.pid}`" in said.err
    if command in REPLACED:
        assert not Path("out").exists()
    else:
        assert [each.name for each in Path("out").iterdir()] == [LOCK]
