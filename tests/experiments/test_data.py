"""`python -m experiments.data`, and the folders in which studies and tests look."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from experiments.data import main
from experiments.plant.originals import robots_root
from experiments.public.audit import audit
from experiments.public.manifest import data_root, load_sets

ROOT = Path(__file__).parents[2]


def test_the_environment_names_the_folders_first(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("MORPH_RECORDINGS", str(tmp_path / "a"))
    monkeypatch.setenv("MORPH_ROBOTS", str(tmp_path / "b"))
    assert (data_root(), data_root("robots")) == (tmp_path / "a", tmp_path / "b")
    assert robots_root() == (tmp_path / "b").resolve()


@pytest.mark.parametrize("kind", ["recordings", "robots"])
def test_what_stands_beside_the_repository_goes_before_what_was_fetched(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, kind: str
) -> None:
    for name in ("MORPH_RECORDINGS", "MORPH_ROBOTS"):
        monkeypatch.delenv(name, raising=False)
    repository, shared = tmp_path / "morph", tmp_path / "shared" / kind
    fetched = repository / "experiments" / "data" / kind
    assert data_root(kind, repository=repository) == fetched
    fetched.mkdir(parents=True)
    assert data_root(kind, repository=repository) == fetched
    shared.mkdir(parents=True)
    assert data_root(kind, repository=repository) == shared


def test_list_names_every_set_its_licence_and_what_is_not_established(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["--list"]) == 0
    told = capsys.readouterr().out
    for whole in load_sets():
        assert f"\n{whole.name}: " in f"\n{told}"
        assert whole.licence in told
    assert "from Daniella1/urdf_files_dataset commit unknown, urdf_files" in told
    assert told.count("not established: ") == 2
    assert "from poppy-project/poppy-humanoid at d66c8fb, hardware/URDF" in told


def test_check_ends_with_1_where_files_are_missing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["--check", str(tmp_path), "--set", "urma_sea_snake"]) == 1
    told = capsys.readouterr().out
    assert "missing: urma_sea_snake/sea_snake.xml\n" in told
    assert "0 files as they were used, 2 missing, 0 different, 0 unlisted" in told


def test_check_of_a_point_is_of_the_folder_that_one_is_in(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["--check", ".", "--set", "urma_sea_snake"]) == 1
    assert "robots under .: 0 files as they were used, 2 missing" in capsys.readouterr().out


def test_a_name_that_a_terminal_would_obey_is_printed_as_escapes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "urma_sea_snake"
    folder.mkdir()
    (folder / "red\x1b[31m\n\u202eend").write_text("")
    (folder / os.fsdecode(b"bytes\xff")).write_text("")
    assert main(["--check", str(tmp_path), "--set", "urma_sea_snake"]) == 1
    told = capsys.readouterr().out
    assert "unlisted: urma_sea_snake/red\\x1b[31m\\n\\u202eend\n" in told
    assert "unlisted: urma_sea_snake/bytes\\udcff\n" in told


def test_a_reader_of_the_list_may_go_before_its_end() -> None:
    words = [sys.executable, "-m", "experiments.data", "--list"]
    with subprocess.Popen(
        words, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == b""
    # What a shell says of a program that SIGPIPE ended.
    assert process.returncode == 141


@pytest.mark.parametrize("kind", ["recordings", "robots"])
def test_the_data_on_this_machine_are_those_that_were_used(
    kind: str, request: pytest.FixtureRequest
) -> None:
    root = request.getfixturevalue({"robots": "real_robots"}.get(kind, kind))
    # A folder that the environment names need not have every set.
    sets = [one for one in load_sets() if one.kind == kind and (root / one.name).is_dir()]
    found = audit(root, sets)
    assert (found.missing, found.different) == ((), ())
    assert found.right == sum(len(whole.files) for whole in sets) > 0


def test_without_a_server_the_address_and_the_way_out_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    # Port 1 of this machine answers nobody.
    asked = ["--set", "so101_sage", "--to", str(tmp_path), "--mirror", "http://127.0.0.1:1"]
    assert main(asked) == 2
    told = capsys.readouterr()
    assert "http://127.0.0.1:1/isaac-sim2real/sage/4ffd2627" in told.err
    assert "cannot download: [Errno 111] Connection refused" in told.err
    assert "MORPH_RECORDINGS" in told.err
    # It does not try the other eighty files of the set.
    assert told.err.count("cannot download") == 3
    assert "so101_sage: 3 files failed, given up" in told.err
    assert list(tmp_path.rglob("*")) == []
