"""`--save` and `--save-as`: who may write which result file."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import pytest

from experiments.engine_options import add_engine_options
from experiments.figures.result_file import RESULTS
from experiments.figures.save_options import Save, parse_and_save

MODULE = "experiments.interval"
CATALOGUE = """
words = []
[[study]]
name = "sums"
command = "experiments.interval --count 3"
answers = "What is the sum?"
headline = "{sums.total}"
notes = "sums"
"""


def parsed(tmp_path: Path, *arguments: str) -> tuple[argparse.Namespace, Save]:
    catalogue = tmp_path / "figures.toml"
    catalogue.write_text(CATALOGUE)
    parser = argparse.ArgumentParser()
    parser.add_argument("--count", type=int, default=1)
    add_engine_options(parser, out=str(tmp_path / "interval"))
    return parse_and_save(parser, arguments, module=MODULE, catalogue=catalogue)


def test_without_an_option_nothing_is_saved(tmp_path: Path) -> None:
    asked, save = parsed(tmp_path, "--count", "3")
    assert asked.count == 3
    assert not save


def test_the_listed_settings_save_under_the_listed_name(tmp_path: Path) -> None:
    _, save = parsed(tmp_path, "--count", "3", "--save")
    assert save.to == "sums"
    assert save.command == "experiments.interval --count 3"
    assert save.settings == {"count": 3}


def test_how_many_workers_run_is_no_setting(tmp_path: Path) -> None:
    _, save = parsed(tmp_path, "--count", "3", "--workers", "7", "--save")
    assert save.to == "sums"


def test_listed_studies_of_one_module_keep_their_rows_apart_and_go_on_with_them(
    tmp_path: Path,
) -> None:
    asked, save = parsed(tmp_path, "--count", "3", "--save")
    assert asked.out == tmp_path / "sums"
    assert not asked.resume
    assert save.start is not None
    assert not save.start.resumed
    (tmp_path / "sums").mkdir()
    asked, save = parsed(tmp_path, "--count", "3", "--save")
    assert (asked.resume, asked.stale) == (True, "rerun")
    assert save.start is not None
    assert save.start.resumed
    asked, _ = parsed(tmp_path, "--count", "3", "--save", "--fresh")
    assert not asked.resume
    asked, _ = parsed(tmp_path, "--count", "3", "--save", "--out", str(tmp_path / "own"))
    assert asked.out == tmp_path / "own"


def test_other_settings_cannot_replace_the_stated_figures(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="2"):
        parsed(tmp_path, "--count", "2", "--save")
    assert "experiments.interval --count 3 --save" in capsys.readouterr().err


def test_other_settings_are_saved_elsewhere(tmp_path: Path) -> None:
    file = tmp_path / "other.json"
    _, save = parsed(tmp_path, "--count", "2", "--save-as", str(file))
    save(figures={"total": 3}, controls={"nothing": {"total": 0}})
    found = json.loads(file.read_text())
    assert found["command"] == "experiments.interval --count 2"
    assert found["settings"] == {"count": 2}
    # Its own earlier result may be replaced.
    assert parsed(tmp_path, "--count", "2", "--save-as", str(file))[1]


def test_a_file_that_is_no_result_is_never_replaced(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "thesis.md"
    file.write_text("precious")
    with pytest.raises(SystemExit, match="2"):
        parsed(tmp_path, "--count", "2", "--save-as", str(file))
    assert "is no earlier result" in capsys.readouterr().err
    assert file.read_text() == "precious"


def test_no_other_file_is_written_among_the_stated_results(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="2"):
        parsed(tmp_path, "--count", "2", "--save-as", str(RESULTS / "sums.json"))
    assert "outside experiments/results" in capsys.readouterr().err


@pytest.mark.parametrize("file", ["folder", "file/one.json"])
def test_a_file_that_cannot_be_written_is_refused_before_anything_is_measured(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], file: str
) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_text("")
    with pytest.raises(SystemExit, match="2"):
        parsed(tmp_path, "--count", "2", "--save-as", str(tmp_path / file))
    assert "cannot write" in capsys.readouterr().err
