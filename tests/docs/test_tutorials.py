from __future__ import annotations

import re
import shlex
import warnings
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import pytest

from morph.app.cli.main import main

DOCS = Path(__file__).resolve().parents[2] / "docs"
TUTORIALS = sorted(DOCS.glob("tutorial_*.md"))
WORLDS = [DOCS / f"{name}.md" for name in ("water", "contact", "policies")]
"""Pages that also hold commands, on what their Python has written before."""
PAGES = [
    *TUTORIALS,
    *WORLDS,
    DOCS / "card.md",
    DOCS / "ensemble.md",
    DOCS / "gym.md",
    DOCS / "latent.md",
    DOCS / "python.md",
    DOCS / "tasks.md",
    DOCS / "vary.md",
    DOCS.parent / "README.md",
]
STUDIES = DOCS.parent / "experiments" / "README.md"
LONGEST = 20.0
"""Seconds that a reader may wait for a tutorial."""


def blocks(page: Path) -> list[str]:
    """Return the Python of a page, each block padded so that errors name the page's lines."""
    text = page.read_text(encoding="utf-8")
    return [
        "\n" * text.count("\n", 0, found.start(1)) + found.group(1)
        for found in re.finditer(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    ]


def commands(page: Path) -> list[str]:
    """Return the simulations of a page that are to be run after its Python."""
    text = page.read_text(encoding="utf-8")
    return re.findall(r"^morph simulate .*$", text, re.MULTILINE) if page in WORLDS else []


@pytest.mark.parametrize("page", WORLDS, ids=lambda page: page.stem)
def test_a_page_of_worlds_has_commands(page: Path) -> None:
    assert commands(page)


def test_there_are_two_tutorials() -> None:
    assert [page.stem for page in TUTORIALS] == ["tutorial_diagnose", "tutorial_simulate"]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_a_page_runs_from_top_to_bottom_as_it_stands(
    page: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    processor: Callable[[float], AbstractContextManager[None]],
) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {"__name__": page.stem}
    # The processor's time: other tests may be running beside this one. Two cores at most.
    with processor(2 * LONGEST):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            for block in blocks(page):
                exec(compile(block, str(page), "exec"), names)
        for line in commands(page):
            assert main(shlex.split(line)[1:]) == 0


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_no_python_of_a_page_is_left_unrun(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert len(blocks(page)) == text.count("```python") >= 1


@pytest.mark.parametrize(
    "page", [*PAGES, STUDIES], ids=lambda page: str(page.relative_to(DOCS.parent))
)
def test_every_file_that_a_page_links_to_is_there(page: Path) -> None:
    links = re.findall(r"\]\(([^)#:]+)\)", page.read_text(encoding="utf-8"))
    assert [link for link in links if not (page.parent / link).exists()] == []
