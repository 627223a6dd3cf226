"""The page on printing says what holds, and its commands do what it says."""

from __future__ import annotations

import re
import shlex
from dataclasses import fields
from pathlib import Path

import pytest

from morph.app.cli.main import main
from morph.app.cli.print_arguments import Print
from morph.app.cli.weigh_arguments import Weigh
from morph.app.report.print.files import ASSEMBLY, REPORT
from morph.app.viewer.view_request import ViewRequest
from morph.app.viewer.views.views import makers
from morph.fabrication.link_mass import Source
from morph.fabrication.packed import SCHEMA
from morph.print.check.checks import CHECKS
from morph.print.gauge import PLAYS_MM
from morph.print.repair import DISTANCE_MM, VOLUME
from morph.print.servos import SERVOS

DOCS = Path(__file__).resolve().parents[2] / "docs"
TEXT = (DOCS / "print.md").read_text(encoding="utf-8")
(COMMANDS,) = re.findall(r"```\n(morph print .*?)```", TEXT, re.DOTALL)
OTHERS = {"check_part": {"repair"}, "prepare": {"split"}, "clearances": {"clearance"}}
"""Checks that are made beside those of the list, by what makes them."""


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder in which the commands of the page were given; the last one serves a page."""
    folder = tmp_path_factory.mktemp("page")
    printed, weighed, viewed = (shlex.split(line) for line in COMMANDS.splitlines())
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert main([*printed[1:], "--slicer", "none", "--quiet"]) == 0
        assert main([*weighed[1:], "--quiet"]) == 0
    assert viewed == ["morph", "view", "--package", "package"]
    return folder / "package"


def test_every_option_of_the_commands_is_on_the_page_and_no_other() -> None:
    named = set(re.findall(r"--([a-z][a-z-]*)", TEXT)) - {"package", "first"}
    told = {"no-gcode": "gcode", "no-match": "match"}
    known = {each.name for command in (Print, Weigh) for each in fields(command)}
    arguments = {"robot", "package", "reading"}
    assert {told.get(name, name) for name in named} == known - arguments


def test_every_file_of_a_package_is_on_the_page_and_the_other_way_round(package: Path) -> None:
    (table,) = re.findall(r"## What is in the package\n(.*?)\n## ", TEXT, re.DOTALL)
    named = {
        name.rstrip("/")
        for row in re.findall(r"^\| (`.*?) \|", table, re.MULTILINE)
        for name in re.findall(r"`([^`]+)`", row)
    }
    # This body holds nothing in seats, so that there are no gauges; nothing of it is refused, and
    # no policy was given.
    unseen = {"gauges", "refused"}
    assert {path.name for path in package.iterdir()} | unseen == named - {"policy"}
    assert {REPORT, ASSEMBLY} <= named
    assert f"`{SCHEMA}`" in TEXT


def test_the_view_takes_the_package(package: Path) -> None:
    (make,), _ = makers(ViewRequest(robots=(), asked=(), package=package))
    content = make().content()
    assert content.actors[0].figure.shapes
    masses = next(table for table in content.tables if table.title.startswith("Mass"))
    # The body's plastic was weighed, and so were the four lower legs.
    weighed = {str(row[0]) for row in masses.rows if row[3] != "–"}
    assert "body" in weighed
    assert sum(name.endswith("lower leg") for name in weighed) == 4


def test_every_check_is_explained() -> None:
    said = set(re.findall(r"^\| `([\w ]+)` \|", TEXT, re.MULTILINE))
    assert said >= {rule.name for rule in CHECKS} | set().union(*OTHERS.values())


def test_numbers_are_those_of_the_code() -> None:
    assert f"{100 * VOLUME:g} %" in TEXT
    assert f"{DISTANCE_MM:g} mm" in TEXT
    plays = ", ".join(f"{play:g}" for play in PLAYS_MM[:-1])
    assert f"{plays} and {PLAYS_MM[-1]:g} mm" in TEXT
    assert {servo.name for servo in SERVOS if servo.name not in TEXT} == set()
    assert {source for source in Source.__args__ if f"`{source}`" not in TEXT} == set()  # type: ignore[attr-defined]


def test_every_file_that_the_page_links_to_is_there() -> None:
    links = re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", TEXT)
    assert links
    assert [link for link in links if not (DOCS / link).exists()] == []
