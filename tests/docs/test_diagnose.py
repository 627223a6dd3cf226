"""The page of worked examples: its vehicle, from the description to the finding."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import pytest

from morph.app.cli.main import main

PAGE = Path(__file__).resolve().parents[2] / "docs" / "diagnose.md"
TEXT = PAGE.read_text(encoding="utf-8")


def test_the_vehicle_is_diagnosed_as_the_page_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    vehicle = TEXT[TEXT.index("## A vehicle") : TEXT.index("## An arm")]
    (description,) = re.findall(r"```xml\n<!-- (\S+) -->\n(.*?)```", vehicle, re.DOTALL)
    Path(description[0]).write_text(description[1])
    commands = re.findall(r"^morph .*$", vehicle, re.MULTILINE)
    assert len(commands) == 4
    for line in commands:
        assert main([*shlex.split(line)[1:], "--quiet"]) == 0, line
    told = json.loads(Path("report/diagnosis.json").read_text())
    (finding,) = told["findings"]
    assert (finding["effect"], finding["where"]["name"]) == ("torque_scale", "left")
    # What a thruster gives may be wrong by 5 %, one standard deviation.
    assert finding["parameters"]["gain"]["value"] == pytest.approx(0.7, abs=0.07)


def test_the_descriptions_of_the_page_load(tmp_path: Path) -> None:
    from morph.body.load import load

    blocks = re.findall(r"```xml\n<!-- (\S+) -->\n(.*?)```", TEXT, re.DOTALL)
    assert [name for name, _ in blocks] == ["rov.xml", "arm.xml", "leg.xml"]
    for name, text in blocks:
        (tmp_path / name).write_text(text)
        assert load(tmp_path / name).actuators


def test_every_file_that_the_page_links_to_is_there() -> None:
    links = re.findall(r"\]\(([^)#:]+)\)", TEXT)
    assert links
    assert [link for link in links if not (PAGE.parent / link).exists()] == []
