"""What happens with a slicer that is not there, hangs, dies, or writes what cannot be used."""

from __future__ import annotations

import errno
import tempfile
from collections.abc import Callable
from pathlib import Path

import pytest
import trimesh

from morph.print.errors import SlicerError
from morph.print.job import Orientation
from morph.print.part import Part
from morph.print.printer import Profile
from morph.print.sliced import Sliced
from morph.print.slicer import Slicer, find_slicer

WHOLE = "printf 'G1 X1 E1\\n; filament used [mm] = 1.00\\n; prusaslicer_config = end\\n'"
OUT = 'while [ "$1" != --output ]; do shift; done; out="$2"'
"""Finds where the G-code is to go, as our command names it."""

Ask = Callable[[str], Sliced]


@pytest.fixture
def ask(
    tmp_path: Path, pla: Profile, upright: Orientation, part: Callable[[trimesh.Trimesh], Part]
) -> Ask:
    """Slice a cube with a script in the place of the slicer."""
    cube = part(trimesh.creation.box((20, 20, 20)))

    def asked(script: str, timeout_s: float = 20.0) -> Sliced:
        program = tmp_path / "fake-slicer"
        program.write_text(f"#!/bin/sh\n{script}\n")
        program.chmod(0o755)
        fake = Slicer(program=program, name="Fake 1.0")
        return fake.sliced(cube, upright, pla, timeout_s=timeout_s)

    return asked


def test_the_script_in_the_place_of_the_slicer_is_believed(ask: Ask) -> None:
    found = ask(f"{OUT}; {WHOLE} > $out")
    assert found.slicer == "Fake 1.0"
    assert found.gcode is not None
    assert found.gcode.startswith(b"G1 X1 E1")


@pytest.mark.parametrize(
    ("script", "said"),
    [
        ("echo bad mesh; exit 1", "Fake 1.0 ended with status 1; it said: bad mesh"),
        ("kill -SEGV $$", "Fake 1.0 died of SIGSEGV; it said: nothing"),
        ("kill -KILL $$", "died of SIGKILL"),
        ("echo '10 => Slicing'", "as if all were well but wrote no G-code"),
        (f"{OUT}; : > $out", "wrote no G-code"),
        (f"{OUT}; {WHOLE} | head -c 20 > $out", "wrote 20 bytes without the end of a G-code"),
        (f"{OUT}; head -c 5000 /dev/urandom > $out", "wrote 5000 bytes without the end"),
        (f"{OUT}; {WHOLE} | sed s/1.00/9.00/ > $out", r"1.0 mm of filament.*say 9.0 mm"),
        (f"{OUT}; {WHOLE} | sed s/X1/X./ > $out", "a coordinate is no number"),
        (f"{OUT}; {WHOLE} | grep -v X1 > $out", "lays plastic"),
    ],
)
def test_a_faulty_slicer_is_named_with_its_fault(ask: Ask, script: str, said: str) -> None:
    with pytest.raises(SlicerError, match=said) as caught:
        ask(script)
    assert "sample" in caught.value.where
    assert caught.value.fix


def test_a_slicer_that_hangs_is_killed_after_its_time(ask: Ask) -> None:
    with pytest.raises(SlicerError, match=r"did not end within 0.3 s and was killed.*: thinking"):
        ask("echo thinking; sleep 60", timeout_s=0.3)


def test_a_slicer_that_leaves_a_child_behind_is_not_waited_for(ask: Ask) -> None:
    assert ask(f"sleep 60 & {OUT}; {WHOLE} > $out").seconds == 0.0


def test_what_it_warns_of_is_passed_on_once(ask: Ask) -> None:
    warn = "echo 'print warning: Empty layer between 5 and 8.2.'"
    debug = "echo '[2026-11-22 19:33] [0x7f] [warning] odd'; echo '[t] [0x7f] [trace] even'"
    found = ask(f"{warn}; {warn}; echo '10 => Slicing'; {debug}; {OUT}; {WHOLE} > $out")
    assert found.warnings == ("Empty layer between 5 and 8.2.", "odd")


def test_what_it_put_right_itself_is_no_warning(ask: Ask) -> None:
    first = "[t] [0x7f] [warning] Detected missing Voronoi vertex"
    log = f"{first}, input polygons will be rotated back and forth."
    vain = f"{first} even after the rotation of input."
    found = ask(f"echo '{log}'; echo '{vain}'; {OUT}; {WHOLE} > $out")
    assert found.warnings == ("Detected missing Voronoi vertex even after the rotation of input.",)


@pytest.mark.parametrize(
    ("text", "seconds"), [("1d 2h 3m 4s", 93784.0), ("13m 45s", 825.0), ("7s", 7.0)]
)
def test_the_time_is_read_with_days_hours_and_minutes(ask: Ask, text: str, seconds: float) -> None:
    line = f"; estimated printing time (normal mode) = {text}"
    assert ask(f"{OUT}; (echo '{line}'; {WHOLE}) > $out").seconds == seconds


def test_it_sees_neither_our_screen_nor_our_home(ask: Ask, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DISPLAY", ":99")
    found = ask(f'{OUT}; (echo "; $HOME|$DISPLAY|$PWD"; {WHOLE}) > $out')
    assert found.gcode is not None
    home, display, here = found.gcode.splitlines()[0][2:].split(b"|")
    assert (home, display) == (here, b"")
    assert not Path(here.decode()).exists()


def test_a_full_disk_is_told_with_the_folder(ask: Ask, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(self: Path, data: bytes) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(SlicerError, match="No space left on device") as caught:
        ask("exit 0")
    assert tempfile.gettempdir() in caught.value.what
    assert "TMPDIR" in caught.value.fix


def test_a_slicer_that_was_removed_is_told_with_how_to_install_one(
    pla: Profile, upright: Orientation, part: Callable[[trimesh.Trimesh], Part]
) -> None:
    gone = Slicer(program=Path("/nowhere/prusa-slicer"), name="PrusaSlicer 2.5.0")
    with pytest.raises(SlicerError, match="/nowhere/prusa-slicer is no program") as caught:
        gone.sliced(part(trimesh.creation.box((9, 9, 9))), upright, pla)
    assert "apt-get install prusa-slicer" in caught.value.fix


def test_without_one_on_the_path_there_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "/nowhere")
    assert find_slicer() is None


@pytest.mark.parametrize("script", ["exit 1", "echo hello", "kill $$"])
def test_a_program_of_that_name_that_is_no_prusaslicer_is_not_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, script: str
) -> None:
    program = tmp_path / "prusa-slicer"
    program.write_text(f"#!/bin/sh\n{script}\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    assert find_slicer() is None


def test_what_lies_off_the_bed_is_refused_before_the_slicer_is_asked(
    pla: Profile, upright: Orientation, part: Callable[[trimesh.Trimesh], Part]
) -> None:
    never = Slicer(program=Path("/bin/false"), name="Fake 1.0")
    with pytest.raises(SlicerError, match=r"it \(400.0 x 10.0 x 10.0 mm\) lies from") as caught:
        never.sliced(part(trimesh.creation.box((400, 10, 10))), upright, pla)
    assert "Prusa MK4 (250 x 210 x 220 mm)" in caught.value.what


def test_a_part_without_a_mesh_is_refused(pla: Profile, upright: Orientation) -> None:
    bought = Part(name="motor", kind="bought", mesh=None, placements=())
    with pytest.raises(SlicerError, match="it has no mesh"):
        Slicer(program=Path("/bin/false"), name="Fake").sliced(bought, upright, pla)
