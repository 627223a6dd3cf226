from __future__ import annotations

import re
import shlex
from dataclasses import fields
from pathlib import Path

import pytest

from morph.app.cli.arguments import Learn
from morph.app.cli.main import main
from morph.search.searches import SEARCHES, default
from morph.task.tasks import TASKS

PAGE = Path(__file__).resolve().parents[2] / "docs" / "learn.md"
TEXT = PAGE.read_text(encoding="utf-8")
COMMANDS = re.findall(r"^morph learn .*$", TEXT, re.MULTILINE)


def test_every_option_is_explained() -> None:
    options = {field.name for field in fields(Learn)} - {"task"}
    # Whole words: `--effect` is not explained by `--effects`.
    explained = set(re.findall(r"--([a-z]+)\b", TEXT))
    assert options - explained == set()


def test_every_command_names_what_there_is() -> None:
    assert len(COMMANDS) >= 3
    for line in COMMANDS:
        words = shlex.split(line)
        assert words[2] in TASKS, line
        named = words[words.index("--search") + 1] if "--search" in words else default(words[2])
        assert named in SEARCHES, line


def test_the_table_of_searches_holds_every_search_and_no_other() -> None:
    (rows,) = re.findall(r"^\| search \|.*\n((?:\|.*\n)+)", TEXT, re.MULTILINE)
    named = re.findall(r"`([\w-]+)`", " ".join(row.split("|")[1] for row in rows.splitlines()))
    assert sorted(named) == sorted(SEARCHES)


def test_the_quickest_command_of_the_page_leaves_what_the_page_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    line = next(line for line in COMMANDS if line.startswith("morph learn balance"))
    assert main([*shlex.split(line)[1:], "--quiet"]) == 0
    assert capsys.readouterr().err == ""
    (files,) = re.findall(r"^\| in the folder of .*\n(?:\|.*\n)+", TEXT, re.MULTILINE)
    told = set(re.findall(r"^\| `([\w.]+)/?` \|", files, re.MULTILINE))
    found = {path.name for path in Path("balanced").iterdir()}
    # Pictures are drawn where there is something to draw with.
    assert told - {"strip.jpg"} == found - {"strip.jpg"}


def test_every_file_that_the_page_links_to_is_there() -> None:
    links = re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", TEXT)
    assert links
    assert [link for link in links if not (PAGE.parent / link).exists()] == []
