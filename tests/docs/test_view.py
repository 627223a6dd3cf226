"""The page on the viewer names what there is."""

from __future__ import annotations

import re
import shlex
from dataclasses import fields
from pathlib import Path

from morph.app.cli.view_arguments import ViewCommand
from morph.app.viewer.compare.figures import COST, ENERGY, MARGIN
from morph.app.viewer.transport import KEYS, STEPS
from morph.app.viewer.views.views import VIEWS
from morph.body.shelf import names
from morph.task.tasks import TASKS

DOCS = Path(__file__).resolve().parents[2] / "docs"
TEXT = (DOCS / "view.md").read_text(encoding="utf-8")
COMMANDS = re.findall(r"^morph view .*$", TEXT, re.MULTILINE)
OPTIONS = {each.name for each in fields(ViewCommand)} - {"robots"}


def test_every_option_of_the_page_is_one_of_the_command_and_the_other_way_round() -> None:
    assert set(re.findall(r"--([a-z][a-z-]*)", TEXT)) - {"out"} == OPTIONS


def test_every_command_names_bodies_tasks_and_views_that_there_are() -> None:
    assert len(COMMANDS) >= 5
    for line in COMMANDS:
        words = shlex.split(line)[2:]
        first = next((at for at, word in enumerate(words) if word.startswith("--")), len(words))
        assert set(words[:first]) <= set(names()), line
        told = dict(zip(words[first::2], words[first + 1 :: 2], strict=True))
        assert {option.removeprefix("--") for option in told} <= OPTIONS, line
        assert told.get("--task", "balance") in TASKS, line
        assert told.get("--first", "design") in VIEWS, line


def test_every_view_has_a_section_and_no_other_has() -> None:
    (views,) = re.findall(r"^## The views\n(.*?)^## ", TEXT, re.MULTILINE | re.DOTALL)
    assert re.findall(r"^### (\w+)", views, re.MULTILINE) == [name.title() for name in VIEWS]


def test_every_knob_of_the_clock_is_on_the_page() -> None:
    assert {step for step in STEPS if f"`{step}`" not in TEXT} == set()
    keys = {key.removeprefix("arrow") for key, _, _ in KEYS.values()}
    assert {key for key in keys if not re.search(rf"\b{key}\b", TEXT)} == set()


def test_every_figure_of_the_comparison_is_explained() -> None:
    said = re.findall(r"^\| (\w[\w ]*) \|", TEXT, re.MULTILINE)
    for series in (MARGIN, ENERGY, COST):
        assert any(word in said for word in (series.partition(" (")[0], series)), series


def test_every_file_that_the_page_links_to_is_there() -> None:
    links = re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", TEXT)
    assert links
    assert [link for link in links if not (DOCS / link).exists()] == []
