"""A card as TOML text."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

from morph.body.card import Card

LONGEST = 800
"""Letters of a text; a line of a card has at most 1024 bytes."""


WIDEST = 100
"""Letters of a list on one line; a longer one has a line for each of its values."""


def card_text(card: Card) -> str:
    """Return a card as the text of a `card.toml`, without what is as if it were left out."""
    plain, tables = [], []
    for name, value in _settings(card):
        if is_dataclass(value):
            tables.append(f"\n[{name}]\n" + _lines(value))
        elif isinstance(value, tuple) and value and is_dataclass(value[0]) and name != "source":
            tables += [f"\n[[{name}]]\n" + _lines(each) for each in value]
        elif name == "source":
            each = "".join(f"  {_written(source)},\n" for source in value)
            plain.append(f"source = [\n{each}]\n")
        else:
            plain.append(f"{name} = {_written(value)}\n")
    return "".join((*plain, *tables))


def _settings(table: Any) -> Iterator[tuple[str, Any]]:
    """Yield the keys of a table that are not as if left out, and their values."""
    for field in fields(table):
        value = getattr(table, field.name)
        if value is None or value == field.default:
            continue
        yield field.name.rstrip("_"), value


def _lines(table: Any) -> str:
    return "".join(f"{name} = {_written(value)}\n" for name, value in _settings(table))


def _written(value: Any) -> str:
    if is_dataclass(value):
        return "{ " + ", ".join(f"{name} = {_written(v)}" for name, v in _settings(value)) + " }"
    if isinstance(value, str):
        return _quoted(value)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return repr(value) if math.isfinite(value) else {True: "inf", False: "-inf"}[value > 0]
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_quoted(k)} = {_written(v)}" for k, v in value.items()) + " }"
    written = [_written(each) for each in value]
    line = ", ".join(written)
    if len(line) <= WIDEST:
        return f"[{line}]"
    return "[\n" + "".join(f"  {each},\n" for each in written) + "]"


def _quoted(text: str) -> str:
    # TOML's basic strings escape as JSON's do, and DEL too.
    short = text if len(text) <= LONGEST else text[: LONGEST - 3] + "..."
    return json.dumps(short, ensure_ascii=False).replace("\x7f", "\\u007f")
