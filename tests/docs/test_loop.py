"""The page on the loop names what there is."""

from __future__ import annotations

import json
import re
from dataclasses import fields
from pathlib import Path

import morph.policy_transfer
from morph.app.cli.arguments import Loop
from morph.app.cli.outputs import LOOP, RECORDED
from morph.app.report.loop.words import FIGURES
from morph.policy_transfer.loop_checkpoint import STATE, TRIALS

TEXT = (Path(__file__).resolve().parents[2] / "docs" / "loop.md").read_text(encoding="utf-8")


def test_every_option_of_the_page_is_one_of_the_command_and_the_other_way_round() -> None:
    named = set(re.findall(r"--([a-z][a-z-]*)", TEXT))
    known = {each.name.replace("_", "-") for each in fields(Loop)} - {"task"}
    assert named == known


def test_every_file_and_every_figure_is_on_the_page() -> None:
    folders = {name.partition("/")[0] for name in (*LOOP.results, *LOOP.progress)} | {
        STATE,
        TRIALS,
        RECORDED,
    }
    assert {name for name in folders if f"`{name}" not in TEXT} == set()
    assert {name for name in FIGURES if f"`{name}" not in TEXT} == set()


def test_every_field_of_the_record_is_on_the_page() -> None:
    path = Path(morph.policy_transfer.__file__).parent / "transfer.schema.json"
    schema = json.loads(path.read_text())
    hop = set(schema["$defs"]["hop"]["properties"])
    plain = {"source", "target", "map", "quality", "samples", "succeeded", "why"}
    assert {name for name in hop - plain if f"`{name}`" not in TEXT} == set()
    whole = set(schema["properties"]) - {"schema"}
    assert {name for name in whole if f"`{name}`" not in TEXT} == set()
