"""Into which folders a study writes, and what its manifest says."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from types import ModuleType

import pytest

import morph
from morph.errors import StudyError
from morph.study.cell import Cell, cells_of
from morph.study.engine import EngineOptions
from morph.study.manifest import MANIFEST, ROWS
from morph.study.run import run

INLINE = EngineOptions(engine="inline")


def squares(toy: ModuleType, count: int = 2) -> list[Cell]:
    return cells_of(toy.square, [{"x": x} for x in range(count)])


@pytest.mark.parametrize("how", [{}, {"resume": True}, {"fresh": True}])
@pytest.mark.parametrize("name", [MANIFEST, ROWS, "notes.txt"])
def test_a_folder_with_files_of_others_is_refused_and_left_as_it_was(
    toy: ModuleType, tmp_path: Path, name: str, how: dict[str, bool]
) -> None:
    mine = tmp_path / "out" / name
    mine.parent.mkdir()
    mine.write_text('{"mine": true}')
    with pytest.raises(StudyError, match=rf"holds {name}, which no study wrote\n.*empty folder"):
        run(squares(toy), folder=mine.parent, options=INLINE, **how)
    assert list(mine.parent.iterdir()) == [mine]
    assert mine.read_text() == '{"mine": true}'


@pytest.mark.parametrize("name", [MANIFEST, ROWS])
def test_a_file_that_somebody_put_into_a_study_s_folder_is_not_replaced(
    toy: ModuleType, tmp_path: Path, name: str
) -> None:
    run(squares(toy), folder=tmp_path / "out", options=INLINE)
    mine = tmp_path / "out" / name
    mine.write_text("[1, 2]")
    with pytest.raises(StudyError, match=f"holds {name}, which no study wrote"):
        run(squares(toy), folder=tmp_path / "out", options=INLINE, resume=True)
    assert mine.read_text() == "[1, 2]"


def test_hidden_files_do_not_make_a_folder_somebody_s(toy: ModuleType, tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / ".gitignore").write_text("*\n")
    assert len(run(squares(toy), folder=tmp_path / "out", options=INLINE)) == 2


def test_another_study_does_not_go_on_in_a_folder(toy: ModuleType, tmp_path: Path) -> None:
    out = tmp_path / "out"
    run(squares(toy), folder=out, name="squares", options=INLINE)
    before = (out / MANIFEST).read_bytes()
    others = cells_of(toy.process, [{"x": 1}])
    with pytest.raises(StudyError, match="the study squares of toy_cells:square, not pids of"):
        run(squares(toy), folder=out, name="pids", options=INLINE, resume=True)
    with pytest.raises(StudyError, match=r"not squares of toy_cells:process\n.*another folder"):
        run(others, folder=out, name="squares", options=INLINE, resume=True)
    assert (out / MANIFEST).read_bytes() == before
    # More cells of the same study are no other study.
    run(squares(toy, 4), folder=out, name="squares", options=INLINE, resume=True)


def test_the_manifest_names_the_commit_of_the_study_and_the_version_of_morph(
    toy: ModuleType, tmp_path: Path
) -> None:
    def manifest(folder: str) -> dict[str, object]:
        run(squares(toy), folder=tmp_path / folder, options=INLINE)
        entries: dict[str, object] = json.loads((tmp_path / folder / MANIFEST).read_text())
        return entries

    outside = manifest("outside")
    assert (outside["commit"], outside["morph_version"]) == (None, morph.__version__)

    def git(*arguments: str) -> str:
        who = ("-c", "user.name=a", "-c", "user.email=a@b")
        done = subprocess.run(["git", *who, *arguments], capture_output=True, text=True, check=True)
        return done.stdout.strip()

    git("init", "--quiet")
    git("add", "toy_cells.py")
    git("commit", "--quiet", "--message", "cells")
    assert manifest("inside")["commit"] == git("rev-parse", "HEAD")


def test_the_manifest_says_what_jobs_asked_for() -> None:
    options = EngineOptions(engine="slurm", workers=3, job={"mem_gb": 4})
    entries = {"name": "slurm", "workers": 3, "scheduler": None, "job": {"mem_gb": 4}}
    assert options.as_json() == entries
