"""Comparison of two runs of a study, row by row."""

from __future__ import annotations

import math
from collections.abc import Iterator, Set
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Literal

from morph.arrays import JSON
from morph.study.cell import label_of
from morph.study.manifest import identities
from morph.study.store import FINAL, read

NO_ENTRIES: frozenset[str] = frozenset()

ABSENT: Final = object()
"""Stands for an entry that a row does not have; no value of a row is this object."""


@dataclass(frozen=True, kw_only=True)
class RowDifference:
    """An entry of a row that two runs do not agree on."""

    entry: str
    """Path inside the row: `legs[2].mass`."""
    first: Any
    """Value in the first run; None also where it has no such entry."""
    second: Any
    """Value in the second run, likewise."""
    only: Literal["first", "second"] | None = None
    """Run that alone has the entry; None where both have it."""

    @property
    def by(self) -> float | None:
        """Absolute difference of two finite numbers, if a float can hold it; None for others."""
        pair = (self.first, self.second)
        if any(isinstance(each, bool) or not isinstance(each, int | float) for each in pair):
            return None
        try:
            by = float(abs(self.first - self.second))
        except OverflowError:
            return None
        return by if math.isfinite(by) else None


@dataclass(frozen=True, kw_only=True)
class StudyComparison:
    """Comparison of two runs; a cell is named by its label."""

    same: int
    """Number of cells whose rows are equal."""
    different: tuple[tuple[str, tuple[RowDifference, ...]], ...]
    """Cells whose rows differ, each with its differences."""
    missing_first: tuple[str, ...]
    """Cells that have a row in the second run only."""
    missing_second: tuple[str, ...]
    """Cells that have a row in the first run only."""

    @property
    def equal(self) -> bool:
        """Whether nothing differs and nothing is missing."""
        return not (self.different or self.missing_first or self.missing_second)


def compare(first: Path, second: Path, *, without: Set[str] = NO_ENTRIES) -> StudyComparison:
    """Return how the rows in two folders differ, whatever code made them.

    Args:
        first: Folder of a study.
        second: Folder of another run of it.
        without: Names of entries that are not compared, such as `seconds`.

    Raises:
        StudyError: A folder holds no study.
    """
    ones, twos = _ended(first), _ended(second)
    pairs = [(one, twos[name]) for name, one in ones.items() if name in twos]
    rows = [(label_of(one["case"]), tuple(_differences(one, two, without))) for one, two in pairs]
    return StudyComparison(
        same=sum(not differences for _, differences in rows),
        different=tuple(pair for pair in rows if pair[1]),
        missing_first=_absent(twos, ones),
        missing_second=_absent(ones, twos),
    )


def _absent(there: dict[str, JSON], here: dict[str, JSON]) -> tuple[str, ...]:
    return tuple(label_of(entries["case"]) for name, entries in there.items() if name not in here)


def _ended(folder: Path) -> dict[str, JSON]:
    """Return the final results of the study in a folder, by identity of their cells."""
    results = {}
    for identity in identities(folder):
        entries = read(folder, identity)
        if entries is not None and entries["status"] in FINAL:
            results[identity] = entries
    return results


def _differences(one: JSON, two: JSON, without: Set[str]) -> Iterator[RowDifference]:
    if one["status"] != two["status"]:
        yield RowDifference(entry="status", first=one["status"], second=two["status"])
        return
    yield from _apart("", one["row"], two["row"], without)


def _apart(at: str, one: Any, two: Any, without: Set[str]) -> Iterator[RowDifference]:
    if isinstance(one, dict) and isinstance(two, dict):
        for key in (each for each in dict.fromkeys((*one, *two)) if each not in without):
            pair = one.get(key, ABSENT), two.get(key, ABSENT)
            yield from _apart(f"{at}.{key}" if at else key, *pair, without)
    elif isinstance(one, list) and isinstance(two, list) and len(one) == len(two):
        for i, (left, right) in enumerate(zip(one, two, strict=True)):
            yield from _apart(f"{at}[{i}]", left, right, without)
    elif (one != two or isinstance(one, bool) != isinstance(two, bool)) and not (
        one != one and two != two
    ):
        yield RowDifference(
            entry=at or "row",
            first=None if one is ABSENT else one,
            second=None if two is ABSENT else two,
            only="second" if one is ABSENT else "first" if two is ABSENT else None,
        )
