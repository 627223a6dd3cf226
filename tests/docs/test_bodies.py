from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path

import pytest

from morph.app.cli.arguments import Convert, Inspect
from morph.app.cli.main import main
from morph.body.finding import CODES

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "bodies.md").read_text(encoding="utf-8")


def section(title: str) -> str:
    """Return the text of the page below a heading."""
    found = re.search(rf"^## {title}\n(.*?)(?=^## |\Z)", PAGE, re.MULTILINE | re.DOTALL)
    assert found, title
    return found[1]


def test_every_finding_stands_in_the_table_with_its_own_words() -> None:
    rows = re.findall(
        r"^\| `([a-z-]+)` \| (.+?) \| (.+?) \|$", section("What each finding means"), re.M
    )
    assert {code: says for code, says, _ in rows} == CODES
    assert [code for code, _, _ in rows] == list(CODES)


def test_what_a_reader_is_shown_is_what_a_terminal_shows(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    shown = re.search(
        r"^```\n\$ morph inspect (\w+)\n(.*?)^```$", section("Inspecting"), re.M | re.S
    )
    assert shown
    assert main(["inspect", shown[1]]) == 0
    told = capsys.readouterr().out
    # Where it was read from depends on where morph is.
    place = r"  read from .*(?:\n    .*)*?(?=\n  centre)"
    assert re.sub(place, "", told) == re.sub(place, "", shown[2])


def test_every_option_is_explained() -> None:
    # What a conversion shares with an inspection is explained there.
    inspecting, converting = section("Inspecting"), section("Converting")
    for command, text in ((Inspect, inspecting), (Convert, inspecting + converting)):
        options = {field.name for field in fields(command)} - {"robot"}
        assert {option for option in options if f"--{option}" not in text} == set()
