"""Jobs of submitit: what they leave in the study's folder, and Slurm where there is none."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import pytest

from morph.errors import StudyError
from morph.study.cell import cells_of
from morph.study.engine import EngineOptions
from morph.study.run import run


def test_jobs_leave_the_user_s_folders_alone_and_none_of_their_own(
    toy: ModuleType, tmp_path: Path
) -> None:
    out, options = tmp_path / "out", EngineOptions(engine="submitit-local")
    run(cells_of(toy.square, [{"x": 1}]), folder=out, options=EngineOptions(engine="inline"))
    (out / "jobs").mkdir()
    (out / "jobs" / "thesis.txt").write_text("x")
    # Killed before it had written its manifest.
    (out / ".jobs.killed").mkdir()
    before = {path.name for path in out.iterdir()}
    cells = cells_of(toy.process, [{"x": x} for x in range(2)])
    results = run(
        [*cells_of(toy.square, [{"x": 1}]), *cells], folder=out, options=options, resume=True
    )
    assert [each.status for each in results] == ["done"] * 3
    assert (out / "jobs" / "thesis.txt").read_text() == "x"
    assert {path.name for path in out.iterdir()} == before


def test_a_study_killed_before_its_manifest_leaves_a_folder_that_can_be_used(
    toy: ModuleType, tmp_path: Path
) -> None:
    killed = EngineOptions(engine="submitit-local").start(tmp_path / "out")
    (jobs,) = (tmp_path / "out").iterdir()
    assert jobs.stat().st_mode & 0o777 == 0o700
    inline = EngineOptions(engine="inline")
    assert len(run(cells_of(toy.square, [{"x": 1}]), folder=tmp_path / "out", options=inline)) == 1
    killed.shutdown()


def test_slurm_without_sbatch_says_how_to_try_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(StudyError, match=r"no `sbatch`.*\n.*submitit-local"):
        EngineOptions(engine="slurm").start(tmp_path)


def test_a_fresh_study_whose_engine_does_not_start_deletes_nothing(
    toy: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cells = cells_of(toy.square, [{"x": 1}])
    run(cells, folder=tmp_path / "out", options=EngineOptions(engine="inline"))
    before = {path: path.stat().st_mtime_ns for path in (tmp_path / "out").rglob("*.json")}
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(StudyError, match="no `sbatch`"):
        run(cells, folder=tmp_path / "out", options=EngineOptions(engine="slurm"), fresh=True)
    assert {path: path.stat().st_mtime_ns for path in before} == before
