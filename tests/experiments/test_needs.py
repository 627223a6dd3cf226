"""A study without its data, or with a part of it, refuses."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from experiments.needs import DataMissing, need_packaged, need_recordings, need_robots
from experiments.public.manifest import load_sets


def test_sets_that_are_whole_give_their_folder(recordings: Path) -> None:
    assert need_recordings("dfki_double_pendulum") == recordings.resolve()


def test_one_missing_file_is_enough_to_refuse(
    tmp_path: Path, real_robots: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copytree(real_robots / "urma_sea_snake", tmp_path / "urma_sea_snake")
    monkeypatch.setenv("MORPH_ROBOTS", str(tmp_path))
    assert need_robots("urma_sea_snake") == tmp_path.resolve()
    (whole,) = [each for each in load_sets() if each.name == "urma_sea_snake"]
    (tmp_path / "urma_sea_snake" / whole.files[0].file).unlink()
    with pytest.raises(DataMissing, match=f"1 of {len(whole.files)} files of urma_sea_snake"):
        need_robots("urma_sea_snake")
    with pytest.raises(DataMissing, match=r"also incomplete: .*solo") as error:
        need_robots()
    # One command a set, so that the message need not be met once for each.
    assert "--set aqua && " in error.value.fix


def test_the_message_names_the_set_and_the_variable(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MORPH_RECORDINGS", str(tmp_path))
    with pytest.raises(DataMissing) as told:
        need_recordings("so101_sage")
    assert "python -m experiments.data --set so101_sage" in told.value.fix
    assert "MORPH_RECORDINGS name experiments/data/recordings" in told.value.fix


def test_a_packaged_description_that_is_not_there_is_refused() -> None:
    with pytest.raises(DataMissing, match="no_such_robot"):
        need_packaged("no_such_robot")
