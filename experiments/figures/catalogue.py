"""Catalogue of studies with a result file: question, command, and sentences that state figures."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path

from morph.errors import StudyError

CATALOGUE = Path(__file__).resolve().parents[1] / "figures.toml"
PYTHON = ".venv/bin/python -m"
"""What stands before a study's command in pages and messages."""


@dataclass(frozen=True, kw_only=True)
class Statement:
    """A row of README's table."""

    question: str
    """Template of the first column."""
    figure: str
    """Template of the second column."""
    baseline: str
    """Template of the third column: its strongest baseline."""


@dataclass(frozen=True, kw_only=True)
class Study:
    """One study with its full settings."""

    name: str
    """Name of its result file, without `.json`."""
    command: str
    """Command that runs it, from `experiments.` on, without --save."""
    answers: str
    """Template of one line: the question that it answers."""
    headline: str
    """Template of one line: its figures beside those of its controls."""
    notes: str
    """Page below `experiments/notes`, without `.md`."""
    minutes: float | None = None
    """Minutes that an earlier run took on two cores; None if nobody measured it."""
    readme: tuple[Statement, ...] = ()
    """Its rows of README's table."""

    @property
    def module(self) -> str:
        """The module that `python -m` is given."""
        return self.command.split()[0]


def load_catalogue(path: Path = CATALOGUE) -> tuple[tuple[Study, ...], frozenset[str]]:
    """Return all studies in the order of the file, and the names that may hold digits.

    Raises:
        StudyError: The file cannot be read, lacks a key, or lists a name twice.
    """
    fix = "see the head of experiments/figures.toml for what a study has"
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
        studies = tuple(
            Study(**{**each, "readme": tuple(Statement(**row) for row in each.get("readme", ()))})
            for each in table["study"]
        )
        words = frozenset(table["words"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise StudyError(f"is no catalogue: {error}", where=str(path), fix=fix) from error
    names = [study.name for study in studies]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise StudyError(f"{twice[0]!r} stands twice", where=str(path), fix="give each one name")
    return studies, words
