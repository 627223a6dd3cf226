"""The page on alignments says what holds."""

from __future__ import annotations

import json
import re
from dataclasses import fields
from pathlib import Path

import pytest

import morph.app.report.align
from morph.app.cli.align_arguments import Align
from morph.app.cli.align_inputs import ARRAYS, TOLD

DOCS = Path(__file__).resolve().parents[2] / "docs"
TEXT = (DOCS / "align.md").read_text(encoding="utf-8")


def test_every_option_of_the_page_is_one_of_the_command_and_the_other_way_round() -> None:
    named = set(re.findall(r"--([a-z][a-z-]*)", TEXT))
    assert named == {each.name for each in fields(Align)} - {"bodies"}


def test_every_array_of_a_file_is_on_the_page() -> None:
    assert {name for name in (*ARRAYS, *TOLD) if f"`{name}`" not in TEXT} == set()


def test_its_example_gives_what_it_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (code,) = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)
    exec(compile(code, "docs/align.md", "exec"), {})
    said = json.loads(Path("aligned/align.json").read_text())
    signs = sorted(round(arrow["weight"]) for arrow in said["parts"]["states"])
    assert signs == [-1, 1]
    assert len(said["parts"]["commands"]) == 1
    assert {name for name in said["quality"] if f"`{name}`" not in TEXT} == set()


def test_the_schema_is_the_one_that_is_named() -> None:
    path = Path(morph.app.report.align.__file__).parent / "align.schema.json"
    assert f"`{json.loads(path.read_text())['title']}`" in TEXT
