"""The page on transfers along a chain says what holds."""

from __future__ import annotations

import json
import re
from dataclasses import fields
from pathlib import Path

import pytest

from morph.app.cli.align_arguments import Transfer
from morph.app.cli.outputs import TRANSFER
from morph.app.report.transfer.words import NAMED

DOCS = Path(__file__).resolve().parents[2] / "docs"
TEXT = (DOCS / "transfer.md").read_text(encoding="utf-8")


def test_every_option_of_the_page_is_one_of_the_command_and_the_other_way_round() -> None:
    named = set(re.findall(r"--([a-z][a-z-]*)", TEXT))
    known = {each.name for each in fields(Transfer)}
    assert named == known - {"policy"} | {"from"}


def test_every_file_and_every_control_is_on_the_page() -> None:
    folders = {name.partition("/")[0] for name in (*TRANSFER.results, *TRANSFER.progress)}
    assert {name for name in folders if f"`{name}" not in TEXT} == set()
    assert {name for name in NAMED if f"`{name}`" not in TEXT} - {"transfer"} == set()


def test_its_example_gives_what_it_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (code,) = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)
    known: dict[str, object] = {}
    exec(compile(code, "docs/transfer.md", "exec"), known)
    assert 0.9 < float(capsys.readouterr().out) <= 1.0
    said = json.loads(Path("carried/transfer.json").read_text())
    (line,) = re.findall(r"^(\w+)  -+>  (\w+)  -100 %$", TEXT, re.MULTILINE)
    (arrow,) = (
        each for each in said["hops"][0]["relay"]["parts"]["states"] if each["from"] == line[0]
    )
    assert (arrow["to"], round(arrow["weight"])) == (line[1], -1)
    relay = said["hops"][0]["relay"]
    assert {name for name in relay if f"`{name}`" not in TEXT} == set()
    assert {
        name for name in said["hops"][0]["relay"]["measured"] if f"`{name}`" not in TEXT
    } == set()
