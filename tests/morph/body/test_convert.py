from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import jsonschema
import mujoco
import pytest

import morph.body.inspect
from morph.body import shelf
from morph.body.convert import FORMATS, Conversion, convert
from morph.body.load import load
from morph.errors import OutputError

SCHEMA = json.loads((Path(morph.body.inspect.__file__).parent / "findings.schema.json").read_text())


def mass_of(path: Path) -> float:
    return float(mujoco.MjModel.from_xml_path(str(path)).body_mass.sum())


@pytest.mark.parametrize("to", FORMATS)
def test_a_folder_that_is_moved_still_loads(
    to: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot = load("quadruped_printed")
    path = convert(robot, to, tmp_path / "out").files[0]
    assert any((tmp_path / "out" / FORMATS[to][1]).iterdir())
    moved = shutil.move(path.parent, tmp_path / "else where")
    (tmp_path / "empty").mkdir()
    monkeypatch.chdir(tmp_path / "empty")
    assert mass_of(Path(moved) / path.name) == pytest.approx(robot.mass, rel=1e-12)
    assert str(shelf.builtin_shelf()) not in (Path(moved) / path.name).read_text()


@pytest.mark.parametrize("to", FORMATS)
def test_what_was_written_is_read_again_without_a_repair(to: str, tmp_path: Path) -> None:
    robot = load("quadruped_printed")
    again = load(convert(robot, to, tmp_path / "out").files[0])
    assert again.mass == pytest.approx(robot.mass, rel=1e-12)
    assert {link.name for link in again.links} >= {link.name for link in robot.links}
    assert [finding for finding in again.findings if finding.severity != "info"] == []


@pytest.mark.parametrize("name", ["quadruped_printed", "pendulum"])
@pytest.mark.parametrize("to", FORMATS)
def test_converting_twice_writes_the_same_bytes(name: str, to: str, tmp_path: Path) -> None:
    first = snapshot(convert(load(name), to, tmp_path / "one"), tmp_path / "one")
    assert snapshot(convert(load(name), to, tmp_path / "two"), tmp_path / "two") == first
    assert snapshot(convert(load(name), to, tmp_path / "one"), tmp_path / "one") == first
    assert sorted(path.name for path in tmp_path.iterdir()) == ["one", "two"]


def snapshot(conversion: Conversion, folder: Path) -> dict[str, bytes]:
    """Return every file in a folder; they are those that were named."""
    there = {path for path in folder.rglob("*") if path.is_file()}
    assert there == set(conversion.files)
    return {str(path.relative_to(folder)): path.read_bytes() for path in there}


def test_both_formats_share_a_folder(tmp_path: Path) -> None:
    robot = load("quadruped_printed")
    for to in FORMATS:
        convert(robot, to, tmp_path)
    for name, _ in FORMATS.values():
        assert mass_of(tmp_path / name) == pytest.approx(robot.mass, rel=1e-12)


def test_what_was_found_is_written_by_its_schema(real_robots: Path, tmp_path: Path) -> None:
    robot = load(real_robots / "erd_bolt/robots/bolt.urdf")
    convert(robot, "urdf", tmp_path)
    found = json.loads((tmp_path / "findings.json").read_text())
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    jsonschema.Draft202012Validator(SCHEMA).validate(found)
    assert [each["code"] for each in found["findings"]] == [each.code for each in robot.findings]
    assert found["source_sha256"] == robot.sha256


def test_an_unknown_format_is_refused(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="no format is called 'sdf'"):
        convert(load("pendulum"), "sdf", tmp_path / "out")
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_holds_something_else_is_refused(tmp_path: Path) -> None:
    (tmp_path / "robot.urdf").write_text("mine")
    with pytest.raises(OutputError, match="holds no earlier conversion"):
        convert(load("pendulum"), "urdf", tmp_path)
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [
        ("robot.urdf", "mine")
    ]


def test_nothing_is_written_over_what_is_read(tmp_path: Path) -> None:
    path = convert(load("pendulum"), "urdf", tmp_path / "out").files[0]
    before = path.read_bytes()
    with pytest.raises(OutputError, match="written over what it is read from"):
        convert(load(path), "urdf", tmp_path / "out")
    assert path.read_bytes() == before


@pytest.mark.parametrize("out", ["file", "file/below"])
def test_a_place_that_takes_no_folder_is_refused(out: str, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine")
    with pytest.raises(OutputError) as refused:
        convert(load("pendulum"), "urdf", tmp_path / out)
    assert refused.value.where == str(tmp_path / out)
    assert (tmp_path / "file").read_text() == "mine"


def test_a_full_disk_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(_handle: int) -> None:
        raise OSError(28, "No space left on device")

    robot = load("pendulum")
    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OutputError, match="No space left on device"):
        convert(robot, "urdf", tmp_path / "out")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("to", FORMATS)
def test_a_stop_at_any_moment_leaves_no_description_with_meshes_of_another(
    to: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    small, large = load("pendulum"), load("quadruped_printed")
    out, moved = tmp_path / "out", os.replace
    whole = snapshot(convert(large, to, tmp_path / "whole"), tmp_path / "whole")
    # Two renames for each file: into the folder beside, and from there.
    for stop in range(2 * len(whole)):
        shutil.rmtree(out, ignore_errors=True)
        before = snapshot(convert(small, to, out), out)
        left = iter(range(stop, -1, -1))

        def stopped(source: str, target: str, left: Any = left) -> None:
            if next(left) == 0:
                raise KeyboardInterrupt
            moved(source, target)

        monkeypatch.setattr(os, "replace", stopped)
        with pytest.raises(KeyboardInterrupt):
            convert(large, to, out)
        monkeypatch.setattr(os, "replace", moved)
        there = {
            str(path.relative_to(out)): path.read_bytes()
            for path in out.rglob("*")
            if path.is_file()
        }
        assert all(text in (before.get(name), whole.get(name)) for name, text in there.items())
        name = FORMATS[to][0]
        assert there == before or name not in there
        assert sorted(path.name for path in tmp_path.iterdir()) == ["out", "whole"]


def test_a_kill_leaves_the_old_description_or_none(tmp_path: Path) -> None:
    code = (
        "import os, signal, sys\n"
        "from pathlib import Path\n"
        "from morph.body.convert import convert\n"
        "from morph.body.load import load\n"
        "os.rename = lambda *_: os.kill(os.getpid(), signal.SIGKILL)\n"
        "convert(load('quadruped_printed'), 'mjcf', Path(sys.argv[1]))\n"
    )
    out = tmp_path / "out"
    done = subprocess.run([sys.executable, "-c", code, str(out)], check=False)
    assert done.returncode == -signal.SIGKILL
    assert not out.exists()


@pytest.mark.parametrize("kind", ["deep", "large", "pipe"])
def test_what_only_bears_the_name_of_our_findings_is_no_conversion(
    kind: str, tmp_path: Path
) -> None:
    findings = tmp_path / "findings.json"
    if kind == "pipe":
        os.mkfifo(findings)
    else:
        findings.write_text("[" * 200_000)
    if kind == "large":
        # Sparse: 1 TiB of zeros fits no memory.
        os.truncate(findings, 2**40)
    with pytest.raises(OutputError, match="holds no earlier conversion"):
        convert(load("pendulum"), "mjcf", tmp_path)


@pytest.mark.parametrize("to", FORMATS)
def test_meshes_are_not_written_through_a_link(to: str, tmp_path: Path) -> None:
    robot = load("quadruped_printed")
    out, victim = tmp_path / "out", tmp_path / "victim"
    convert(robot, to, out)
    shutil.move(out / FORMATS[to][1], victim)
    for mesh in victim.iterdir():
        mesh.write_text("not to be touched")
    (out / FORMATS[to][1]).symlink_to(victim)
    with pytest.raises(OutputError, match="is a link") as caught:
        convert(robot, to, out)
    assert caught.value.where == str(out / FORMATS[to][1])
    assert {mesh.read_text() for mesh in victim.iterdir()} == {"not to be touched"}
