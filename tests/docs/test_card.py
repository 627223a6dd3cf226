from __future__ import annotations

import re
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any

import pytest

from morph.body import card
from morph.body.linkage import KINDS
from morph.body.servo import SERVOS
from morph.body.vary import OPERATIONS

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "card.md").read_text(encoding="utf-8")

TABLES = {
    "Top of the file": card.Card,
    "`source`": card.Citation,
    "`checks`": card.Checks,
    "`[[motor]]`": card.Motor,
    "`[[measured]]`": card.Measured,
    "`[[closure]]`": card.Closure,
    "`[[posture]]`": card.CardPosture,
    "`[[parameter]]`": card.CardParameter,
    "`[water]`": card.Water,
    "`[print]`": card.PrintTable,
    "`bought`": card.Bought,
}
"""The heading under which the keys of each table of a card stand."""


def rows(heading: str) -> dict[str, tuple[str, str]]:
    """Return, for each key of the table under a heading, what if left out, and what it is."""
    found = re.search(rf"^## {re.escape(heading)}\n(.*?)(?=^## |\Z)", PAGE, re.M | re.S)
    assert found, heading
    cells = re.findall(r"^\| `(\w+)` \| (.+?) \| (.+?) \|$", found[1], re.M)
    return {key: (default, what) for key, default, what in cells}


def test_every_table_that_a_card_may_have_stands_on_the_page() -> None:
    kinds = {
        kind for kind in vars(card).values() if getattr(kind, "__module__", "") == card.__name__
    }
    assert {kind for kind in kinds if hasattr(kind, "__dataclass_fields__")} == set(TABLES.values())


@pytest.mark.parametrize("heading", TABLES)
def test_a_table_of_the_page_has_the_keys_that_the_reader_knows(heading: str) -> None:
    known: tuple[Any, ...] = fields(TABLES[heading])
    assert list(rows(heading)) == [field.name.rstrip("_") for field in known]
    for field, (default, _) in zip(known, rows(heading).values(), strict=True):
        needed = field.default is MISSING
        assert (default == "refused") == needed, field.name
        if isinstance(field.default, str | float):
            assert default == _toml(field.default)


def _toml(value: str | float) -> str:
    return f'`"{value}"`' if isinstance(value, str) else f"`{value}`"


@pytest.mark.parametrize(
    ("heading", "key", "words"),
    [
        ("Top of the file", "base", card.BASES),
        ("Top of the file", "schema", (f'"{card.SCHEMA}"',)),
        ("`[[closure]]`", "kind", KINDS),
        ("`[[motor]]`", "model", ("ideal", "servo", *(servo.name for servo in SERVOS))),
        ("`[water]`", "wetted", ("mesh", "hull", "box")),
        ("`[[parameter]]`", "operation", [kind.name for kind in OPERATIONS if kind.amount]),
    ],
)
def test_a_key_of_the_page_has_the_words_that_it_may_hold(
    heading: str, key: str, words: tuple[str, ...]
) -> None:
    amounts = {kind.amount for kind in OPERATIONS}
    told = re.findall(r"`(.+?)`", rows(heading)[key][1])
    assert set(told) - (amounts if key == "operation" else set()) == set(words)
