"""The page on planning an experiment: its commands, in their order, do what it says."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from morph.app.cli.main import main

PAGE = Path(__file__).resolve().parents[2] / "docs" / "excite.md"
TEXT = PAGE.read_text(encoding="utf-8")


def test_every_command_of_the_page_works(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    commands = re.findall(r"^morph .*$", TEXT, re.MULTILINE)
    assert len(commands) == 3
    for line in commands:
        assert main(shlex.split(line)[1:]) == 0, line
        assert capsys.readouterr().err == ""
    assert (tmp_path / "plan" / "run_1.csv").is_file()
    assert (tmp_path / "survey" / "experiment.json").is_file()


def test_every_file_that_the_page_links_to_is_there() -> None:
    links = re.findall(r"\]\(([^)#:]+)\)", TEXT)
    assert links
    assert [link for link in links if not (PAGE.parent / link).exists()] == []
