"""A card written and read again."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from morph.body.card import CardParameter, Citation, load_card
from morph.body.card_text import LONGEST, card_text
from morph.body.shelf import builtin_shelf

CARDS = sorted(builtin_shelf().glob("*/card.toml"))


@pytest.mark.parametrize("path", CARDS, ids=lambda path: path.parent.name)
def test_every_card_of_the_shelf_survives(path: Path, tmp_path: Path) -> None:
    card = load_card(path)
    folder = tmp_path / card.name
    folder.mkdir()
    (folder / "card.toml").write_text(card_text(card), encoding="utf-8")
    assert load_card(folder / "card.toml") == card


@given(
    st.text(st.characters(exclude_categories=["Cs"]), max_size=LONGEST),
    st.floats(allow_nan=False, allow_infinity=False),
)
def test_any_text_and_any_number_survive(text: str, number: float) -> None:
    card = replace(
        load_card(CARDS[0]),
        title=text,
        source=(Citation(what=text, from_=text),),
        parameter=(CardParameter(name=text, operation="scale", link=text, low=number, high=1e300),),
    )
    found = tomllib.loads(card_text(card))
    assert found["title"] == text
    assert found["source"] == [{"what": text, "from": text}]
    assert found["parameter"][0]["name"] == text
    assert found["parameter"][0]["low"] == number


def test_a_text_that_no_line_of_a_card_holds_is_cut() -> None:
    card = replace(load_card(CARDS[0]), title="x" * 5000)
    assert len(tomllib.loads(card_text(card))["title"]) == LONGEST
