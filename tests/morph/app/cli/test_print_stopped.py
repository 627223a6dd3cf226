"""`morph print` that is stopped, or whose slicer hangs, dies or writes half a file."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import trimesh

from morph.app.cli.main import main

HELP = 'for each in "$@"; do [ "$each" = --help ] && echo PrusaSlicer-2.5.0+x && exit 0; done'
OUT = 'while [ "$1" != --output ]; do shift; done; out="$2"'
MJCF = """<mujoco><asset><mesh name="m" file="m.stl"/></asset><worldbody><body name="arm">
<joint name="j"/><geom type="mesh" mesh="m"/></body></worldbody></mujoco>"""
GIVEN = {"bin", "m.stl", "r.xml"}
WORDS = ("--printer", "mk4", "--material", "pla", "--quiet", "--out", "package")


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bin").mkdir()
    box = trimesh.creation.box((0.04, 0.03, 0.02))
    (tmp_path / "m.stl").write_bytes(box.export(file_type="stl"))
    (tmp_path / "r.xml").write_text(MJCF)
    monkeypatch.setenv("PATH", f"{tmp_path / 'bin'}{os.pathsep}{os.environ['PATH']}")
    return tmp_path


def slicer(place: Path, script: str) -> None:
    program = place / "bin" / "prusa-slicer"
    program.write_text(f"#!/bin/sh\n{HELP}\n{script}\n")
    program.chmod(0o755)


@pytest.mark.parametrize(
    ("script", "more", "says"),
    [
        ("echo no room for a support; exit 1", (), "ended with status 1; it said: no room"),
        ("kill -SEGV $$", (), "died of SIGSEGV"),
        ("sleep 600", ("--timeout", "0.3"), "did not end within 0.3 s and was killed"),
        (f"{OUT}; echo G1 X1 > $out", (), "wrote 6 bytes without the end of a G-code"),
        ("exit 0", (), "wrote no G-code"),
    ],
)
def test_a_faulty_slicer_ends_it_with_one_message_and_no_package(
    script: str,
    more: tuple[str, ...],
    says: str,
    place: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    slicer(place, script)
    assert main(["print", str(place / "r.xml"), *WORDS, *more]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert says in said.err
    assert said.err.count("error:") == 1
    assert "fix:" in said.err
    assert {each.name for each in place.iterdir()} == GIVEN


def test_ctrl_c_while_slicing_is_obeyed_at_once_and_leaves_nothing(place: Path) -> None:
    slicer(place, f"touch {place}/begun; sleep 600")
    # A shell that starts things in its background has them ignore interrupts.
    hears = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"
    call = f"{hears}; from morph.app.cli.main import entry; entry()"
    with subprocess.Popen(
        [sys.executable, "-c", call, "print", str(place / "r.xml"), *WORDS],
        stderr=subprocess.PIPE,
        text=True,
    ) as running:
        while not (place / "begun").exists():
            assert running.poll() is None, running.communicate()[1]
            time.sleep(0.05)
        # The slicer would sleep on for ten minutes.
        running.send_signal(signal.SIGINT)
        said = running.communicate(timeout=120)[1]
    assert (running.returncode, said) == (130, "interrupted; nothing was written\n")
    assert {each.name for each in place.iterdir()} == {*GIVEN, "begun"}
