"""`morph print` of what cannot be printed, under harmful names, or into a full disk."""

from __future__ import annotations

import csv
import json
import os
import re
import resource
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
import trimesh

from morph.app.cli.main import main
from morph.body.load import load
from morph.print.threemf import read_3mf

INERTIA = '<inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/>'
WORDS = ("--printer", "mk4", "--material", "pla", "--slicer", "none", "--quiet")
BOX = trimesh.creation.box((40.0, 30.0, 20.0))
STL: bytes = BOX.export(file_type="stl")


def described(folder: Path, stl: bytes, *, scale: str, robot: str, link: str) -> Path:
    (folder / "m.stl").write_bytes(stl)
    path = folder / "r.urdf"
    path.write_text(
        f'<robot name="{robot}"><link name="base"><inertial><mass value="1"/>{INERTIA}</inertial>'
        f'</link><link name="{link}"><inertial><mass value="0.1"/>{INERTIA}</inertial><visual>'
        f'<geometry><mesh filename="m.stl" scale="{scale}"/></geometry></visual></link>'
        f'<joint name="j" type="revolute"><parent link="base"/><child link="{link}"/>'
        '<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>',
        encoding="utf-8",
    )
    return path


def printed(
    folder: Path,
    stl: bytes = STL,
    *more: str,
    scale: str = "0.001 0.001 0.001",
    robot: str = "r",
    link: str = "arm",
) -> int:
    path = described(folder, stl, scale=scale, robot=robot, link=link)
    return main(["print", str(path), *WORDS, "--out", str(folder / "out"), *more])


def together(*solids: trimesh.Trimesh) -> bytes:
    made: bytes = trimesh.util.concatenate(solids).export(file_type="stl")
    return made


def cube(x: float = 0.0) -> trimesh.Trimesh:
    return trimesh.creation.box((20, 20, 20)).apply_translation((x, x / 3, x / 4))


NOT_A_NUMBER = STL[:100] + np.float32(np.nan).tobytes() + STL[104:]


@pytest.mark.parametrize(
    ("stl", "scale", "says"),
    [
        (STL, "1 1 1", "the largest side is at most 2000 mm"),
        (STL, "5e-6 5e-6 5e-6", "it looks like metres, so scale it by 1000"),
        (STL, "0 1 1", "the scale of 'm.stl' is 0 1 1"),
        (b"", "0.001 0.001 0.001", "m.stl is empty"),
        (STL[:342], "0.001 0.001 0.001", "declares 12 triangles, 684 bytes, and has 342 bytes"),
        (NOT_A_NUMBER, "0.001 0.001 0.001", "not at numbers within"),
        (together(cube(), cube(40)), "0.001 0.001 0.001", "2 solids in one mesh"),
        (together(cube(), cube(9)), "0.001 0.001 0.001", "its surface passes through itself"),
        (
            trimesh.creation.box((40, 30, 0.3)).export(file_type="stl"),
            "0.001 0.001 0.001",
            "walls of 0.3 mm",
        ),
        (
            trimesh.Trimesh(BOX.vertices, BOX.faces[3:]).export(file_type="stl"),
            "0.001 0.001 0.001",
            "it encloses no solid",
        ),
    ],
)
def test_what_cannot_be_printed_is_refused_with_its_reason(
    stl: bytes, scale: str, says: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert printed(tmp_path, stl, "--json", scale=scale) == 3
    said = json.loads(capsys.readouterr().out)
    (refused,) = {check["part"] for check in said["checks"] if check["verdict"] == "refused"}
    assert refused in {"m", "arm"}
    assert any(says in check["what"] + check["fix"] for check in said["checks"])
    assert all(check["fix"] for check in said["checks"] if check["verdict"] == "refused")
    assert said["plates"] == []
    # Nothing is known of its parts: the robot weighs what was described.
    assert load(tmp_path / "out" / "robot").mass == pytest.approx(1.1, rel=1e-12)


def test_nothing_to_print_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert printed(tmp_path, b"") == 3
    said = capsys.readouterr().out
    assert "there is nothing to print; 1 thing refused" in said
    assert "export the mesh again" in said


def test_flipped_faces_are_turned_and_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    flipped = BOX.copy()
    flipped.invert()
    assert printed(tmp_path, flipped.export(file_type="stl"), "--json") == 0
    said = json.loads(capsys.readouterr().out)
    assert any("turned" in check["what"] for check in said["checks"] if check["name"] == "repair")
    solid = trimesh.load(tmp_path / "out" / "parts" / "m.stl")
    # 40 * 30 * 20 mm3, in 32-bit floats: 3 * 6e-8 of it.
    assert solid.volume == pytest.approx(24000, rel=2e-7)


def test_pieces_of_what_is_too_long_for_the_bed_weigh_the_whole(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bar = trimesh.creation.box((400, 20, 20)).export(file_type="stl")
    words = ("--printer", "mini", "--infill", "1", "--json")
    assert printed(tmp_path, bar, *words) == 0
    said = json.loads(capsys.readouterr().out)
    pieces = [part for part in said["parts"] if part["piece_of"] == "m"]
    # Two, along the diagonal of a bed of 180 mm.
    assert len(pieces) >= 2
    grams = 1e3 * sum(part["weight"]["mass_kg"] * len(part["copies"]) for part in pieces)
    # 160 cm3 of PLA, 1.24 g/cm3. Play of 0.2 mm about the pins, a few cm2, takes under 1 %.
    assert grams == pytest.approx(160 * 1.24, rel=0.02)
    for plate in said["plates"]:
        read = read_3mf(tmp_path / "out" / plate["file"])
        for name, pose in read.items:
            low, high = read.meshes[name].moved(pose).bounds
            assert (low >= -1e-3).all()
            # The Mini's bed is 180 mm square, and it reaches 180 mm high.
            assert (high <= 180.001).all()


HOSTILE = {
    "path": "../../../etc/evil",
    "html": "&lt;/script&gt;&lt;img src=x onerror=alert(1)&gt;",
    "formula": "=cmd|' /C calc'!A0",
    "long": "n" * 200,
    "newline": "a&#10;+b",
    "turned": "ärm\u202e\U0001f600",
}


@pytest.mark.parametrize("name", HOSTILE.values(), ids=HOSTILE)
def test_names_that_mean_harm_do_none(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert printed(tmp_path, robot=name, link=name) == 0
    assert "\u202e" not in capsys.readouterr().out
    out = tmp_path / "out"
    assert sorted(each.name for each in tmp_path.iterdir()) == ["m.stl", "out", "r.urdf"]
    for path in out.rglob("*"):
        assert re.fullmatch(r"[A-Za-z0-9_.-]{1,100}", path.name), path
    for row in csv.reader(StringIO((out / "bom.csv").read_text(encoding="utf-8"), newline="")):
        assert not any(cell.startswith(("=", "+", "-", "@", "\n")) for cell in row)
    for page in ("report.html", "assembly.html"):
        assert "<img src=x" not in (out / page).read_text(encoding="utf-8")
    (mesh,) = read_3mf(out / "plates" / "plate_1.3mf").meshes.values()
    assert mesh.volume == pytest.approx(24000, rel=1e-6)
    assert load(out / "robot").mass == pytest.approx(1.1, rel=1e-12)


def test_a_full_disk_leaves_the_earlier_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert printed(tmp_path) == 0
    before = {path: path.read_bytes() for path in (tmp_path / "out").rglob("*") if path.is_file()}
    whole, written = os.fsync, []

    def full(handle: int) -> None:
        written.append(handle)
        if len(written) > 6:
            raise OSError(28, "No space left on device")
        whole(handle)

    monkeypatch.setattr(os, "fsync", full)
    capsys.readouterr()
    assert printed(tmp_path) == 2
    said = capsys.readouterr().err
    assert "No space left on device" in said
    assert "fix:" in said
    after = {path: path.read_bytes() for path in (tmp_path / "out").rglob("*") if path.is_file()}
    assert after == before
    assert sorted(each.name for each in tmp_path.iterdir()) == ["m.stl", "out", "r.urdf"]


def test_a_limit_on_files_is_an_error_and_not_the_end(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    # The report holds a library of four megabytes; Python ignores the signal of this limit.
    resource.setrlimit(resource.RLIMIT_FSIZE, (1_000_000, limits[1]))
    try:
        assert printed(tmp_path) == 2
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert "File too large" in capsys.readouterr().err
    assert sorted(each.name for each in tmp_path.iterdir()) == ["m.stl", "r.urdf"]


@pytest.mark.parametrize(
    ("place", "says"),
    [
        ("m.stl", "this is no folder"),
        (".", "holds no earlier package"),
        ("m.stl/below", "Not a directory|no folder|cannot be|nothing can be"),
        ("", "no folder is named"),
    ],
)
def test_a_place_where_nothing_may_be_written_is_refused_before_the_work(
    place: str, says: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = described(tmp_path, STL, scale="1 1 1", robot="r", link="arm")
    out = str(tmp_path / place) if place else ""
    assert main(["print", str(path), *WORDS, "--out", out]) == 2
    assert re.search(says, capsys.readouterr().err)


@pytest.mark.parametrize("words", [("--timeout", "0"), ("--seconds", "nan"), ("--timeout", "-1")])
def test_a_time_that_cannot_be_waited_is_refused(
    words: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert printed(tmp_path, STL, *words) == 2
    assert f"{words[0]}: " in capsys.readouterr().err
