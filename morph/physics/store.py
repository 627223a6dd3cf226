"""Effects as text and back: what `corrected.toml` and the command line hold."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from morph.errors import EffectError
from morph.physics import effect_class
from morph.physics.effect import Effect
from morph.toml_file import load_toml

MOST_BYTES = 2**22
"""Longest file of effects; a thousand of the longest effects have a million bytes."""


def effects_text(effects: Sequence[Effect]) -> str:
    """Return effects as TOML, a table each, every parameter at full precision."""
    lines = ['schema = "morph.effects/1"']
    for effect in effects:
        lines += ["", "[[effect]]", f'name = "{effect.name}"', f"where = {_quoted(effect.where)}"]
        lines += [f"{p.name} = {float(getattr(effect, p.name))!r}" for p in effect.parameters()]
    return "\n".join(lines) + "\n"


def load_effects(path: Path) -> tuple[Effect, ...]:
    """Return the effects that a TOML file lists.

    Raises:
        EffectError: The file is missing or not TOML, an effect or a parameter is
            unknown, or a value is out of bounds.
    """
    fix = "write it as corrected.toml of a diagnosis is written"
    try:
        content, _ = load_toml(path, MOST_BYTES)
    # A number of thousands of digits is refused by Python itself, as a ValueError.
    except (OSError, ValueError) as error:
        raise EffectError(f"cannot be read: {error}", where=str(path), fix=fix) from error
    tables = content.get("effect", [])
    if content.get("schema") != "morph.effects/1" or not isinstance(tables, list):
        raise EffectError('no schema = "morph.effects/1"', where=str(path), fix=fix)
    return tuple(
        effect_of(table, where=f"{path}, effect {index + 1}") for index, table in enumerate(tables)
    )


def effect_of(table: object, *, where: str) -> Effect:
    """Return the effect that one table of name, where and parameters describes.

    Raises:
        EffectError: The effect or a parameter is unknown, or a value is out of bounds.
    """
    if not isinstance(table, dict) or not {"name", "where"} <= set(table):
        raise EffectError(
            "it needs a name and a where", where=where, fix='say name = "..." and where = "..."'
        )
    kind = effect_class(str(table["name"]))
    known = {p.name for p in kind.parameters()}
    values = {}
    for name, value in table.items():
        if name in {"name", "where"}:
            continue
        if name not in known or isinstance(value, bool) or not isinstance(value, int | float):
            raise EffectError(
                f"{name} = {value!r} is not a number for one of {', '.join(sorted(known))}",
                where=where,
                fix="give the law's own parameters, in SI units",
            )
        try:
            values[name] = float(value)
        except OverflowError as error:
            raise EffectError(
                f"{name} = a number of hundreds of digits is too large",
                where=where,
                fix="give it in SI units",
            ) from error
    return replace(kind.at(str(table["where"])), **values)  # type: ignore[type-var]


def _quoted(text: str) -> str:
    # A JSON string without what lies beyond the basic plane is a TOML string.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
