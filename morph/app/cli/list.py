"""`morph list`: the shelf of robots, the library of effects."""

from __future__ import annotations

import json
import sys
from typing import Any

from morph.app.cli.arguments import List
from morph.app.cli.words import harmless, say, table, width


def run_list(asked: List) -> int:
    """Print what was asked for and return the exit status."""
    rows = _robots() if asked.what == "robots" else _effects()
    if asked.json:
        schema = f"morph.list.{asked.what}/1"
        sys.stdout.write(json.dumps({"schema": schema, asked.what: rows}, indent=2) + "\n")
        return 0
    cells = [[harmless(_cell(value)) for value in row.values()] for row in rows]
    head, *body = table(list(rows[0]), cells, columns=width())
    say([(head, "bold"), *((line, "") for line in body)])
    return 0


def _cell(value: Any) -> str:
    return ", ".join(map(str, value)) if isinstance(value, list) else str(value)


def _robots() -> list[dict[str, Any]]:
    from morph.body.card import load_card
    from morph.body.shelf import find, names

    rows = []
    for name in names():
        card = load_card(find(name) / "card.toml")
        rows.append({"name": name, "title": card.title, "tasks": list(card.tasks)})
    return rows


def _effects() -> list[dict[str, Any]]:
    from morph.physics import EFFECTS

    return [
        {
            "name": effect.name,
            "where": effect.kind,
            "parameters": [f"{p.name} ({p.unit})" for p in effect.parameters()],
            "twins": list(effect.twins),
            "law": (effect.__doc__ or "").splitlines()[0],
        }
        for effect in EFFECTS
    ]
