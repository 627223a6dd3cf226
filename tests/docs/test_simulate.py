from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from morph.app.cli.main import main

PAGE = Path(__file__).resolve().parents[2] / "docs" / "simulate.md"
COMMANDS = re.findall(r"^morph simulate .*$", PAGE.read_text(encoding="utf-8"), re.MULTILINE)


def test_there_are_commands() -> None:
    assert len(COMMANDS) >= 4


@pytest.mark.parametrize("line", COMMANDS)
def test_every_command_of_the_page_works(
    line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    # Films and the browser have tests of their own.
    words = re.sub(r" --view| --video \S+", "", line)
    assert main(shlex.split(words)[1:]) == 0
    assert capsys.readouterr().err == ""


def test_every_file_that_the_page_links_to_is_there() -> None:
    links = re.findall(r"\]\(([^)#:]+)\)", PAGE.read_text(encoding="utf-8"))
    assert links
    assert [link for link in links if not (PAGE.parent / link).exists()] == []
