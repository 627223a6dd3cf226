from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

import numpy as np
import pytest
import trimesh

from experiments import print_gate
from morph.print.printer import Profile, material, printer

PROFILE = Profile(printer=printer("mk4"), material=material("pla"))


def judged(folder: Path, *ways: str) -> list[print_gate.Row]:
    paths = sorted(path for path in folder.iterdir() if path.suffix.lower() == ".stl")
    return [print_gate.judged(path, "m", PROFILE, ways=ways) for path in paths]


def test_all_parts_of_a_published_printed_robot_are_accepted(
    real_robots: Path, processor: Callable[[float], AbstractContextManager[None]]
) -> None:
    # 20 s for 50 parts is the budget; this takes about 3 of the processor.
    with processor(20.0):
        rows = judged(real_robots / "open_duck_mini_v2" / "urdf")
    assert len(rows) == 44
    assert [row.file for row in rows if row.verdict not in ("passed", "noted")] == []


def test_most_meshes_that_merge_motors_and_plastic_are_refused_with_a_reason(
    real_robots: Path,
) -> None:
    rows = judged(real_robots / "poppy_humanoid" / "meshes")
    assert len(rows) == 52
    shown = [row for row in rows if "_visual" in row.file]
    refused = [row for row in shown if row.verdict == "refused"]
    assert len(refused) > len(shown) / 2
    assert all(len(row.why) > 20 for row in refused)
    assert {row.verdict for row in rows} <= {"passed", "noted", "refused"}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    cube = trimesh.creation.box((0.02, 0.02, 0.02))
    whole = cube.export(file_type="stl")
    (tmp_path / "cube.stl").write_bytes(whole)
    (tmp_path / "half.stl").write_bytes(whole[: len(whole) // 2])
    (tmp_path / "empty.stl").write_bytes(b"")
    (tmp_path / "flipped.ply").write_bytes(
        trimesh.Trimesh(cube.vertices, cube.faces[:, ::-1], process=False).export(file_type="ply")
    )
    (tmp_path / "notes.txt").write_text("not a mesh")
    return tmp_path


@pytest.mark.parametrize("way", print_gate.SPOILED)
def test_a_spoiled_copy_of_a_good_mesh_is_refused(folder: Path, way: str) -> None:
    rows = judged(folder, way)
    copies = [row.spoiled[way] for row in rows if way in row.spoiled]
    assert copies == ["refused"] * len(copies)
    assert print_gate.headline(rows)["controls"][way]["copies"] == len(copies) > 0


def test_a_table_of_a_folder_has_a_row_for_each_mesh(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    print_gate.main([str(folder)])
    table = capsys.readouterr().out
    verdicts = {line.split()[0].rpartition("/")[2]: line.split()[1] for line in table.splitlines()}
    assert verdicts["cube.stl"] == "passed"
    assert verdicts["flipped.ply"] == "noted"
    assert verdicts["half.stl"] == verdicts["empty.stl"] == "unreadable"
    assert "4 meshes in" in table


def test_the_unit_matters_and_the_json_holds_the_same(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out" / "gate.json"
    out.parent.mkdir()
    print_gate.main([str(folder / "cube.stl"), "--unit", "mm", "--json", "--out", str(out)])
    said = json.loads(capsys.readouterr().out)
    assert said == json.loads(out.read_text())
    assert said["rows"][0]["verdict"] == "refused"
    assert "metres" not in said["rows"][0]["why"]
    assert np.isclose(said["seconds"], said["rows"][0]["seconds"])


def test_a_folder_without_meshes_is_said(tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match="no mesh"):
        print_gate.main([str(tmp_path)])
