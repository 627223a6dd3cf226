"""The page on studies says what holds."""

from __future__ import annotations

import json
import re
import shlex
import sys
from dataclasses import fields
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from morph.app.cli.main import main
from morph.app.cli.study_arguments import Study
from morph.study.engine import ENGINES
from morph.study.store import Status

DOCS = Path(__file__).resolve().parents[2] / "docs"
TEXT = (DOCS / "study.md").read_text(encoding="utf-8")


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the page's module and file, which is the current one."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    monkeypatch.delitem(sys.modules, "swing", raising=False)
    module, _ = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)
    (study,) = re.findall(r"```toml\n(.*?)```", TEXT, re.DOTALL)
    Path("swing.py").write_text(module)
    Path("swing.toml").write_text(study)
    return tmp_path


def test_its_commands_run_go_on_and_compare(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    commands = re.findall(r"^    morph (study .*)$", TEXT, re.MULTILINE)
    assert len(commands) == 3
    for command in commands:
        assert main(shlex.split(command)) == 0
    assert "7 cells the same, 0 different" in capsys.readouterr().out
    rows = json.loads(Path("swing/rows.json").read_text())["rows"]
    # One alone, then the product: 2 lengths of time, 3 starts.
    assert [(each["case"]["seconds"], each["case"]["start"]) for each in rows] == [
        *[(2.0, 0.1), (0.5, 0.2), (0.5, 0.4), (0.5, 0.6), (1.0, 0.2), (1.0, 0.4), (1.0, 0.6)]
    ]


def test_its_program_gives_a_row_for_each_case(
    home: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    _, program = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)
    exec(compile(program, "docs/study.md", "exec"), {})
    at_rest, *moved = json.loads(capsys.readouterr().out)
    assert at_rest == 0.0
    assert np.all(np.abs(moved) <= [0.1, 0.2])


def test_every_option_of_the_page_is_one_of_the_command_and_the_other_way_round() -> None:
    named = set(re.findall(r"--([a-z][a-z-]*)", TEXT))
    assert {each.name for each in fields(Study)} - {"file", "quiet"} == named


def test_every_engine_and_every_status_has_its_row() -> None:
    rows = re.findall(r"^\| `([a-z][a-z-]*)` \|", TEXT, re.MULTILINE)
    assert rows == [*get_args(Status), *ENGINES]
