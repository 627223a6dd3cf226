"""`morph list`: the shelf of robots, effects, tasks, searches, printers and materials."""

from __future__ import annotations

import ast
import json
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from morph.app.cli.arguments import List
from morph.app.cli.console import harmless, say, table, width


def run_list(options: List) -> int:
    """Print what was asked for and return the exit status."""
    listed = {
        "robots": _robots,
        "effects": _effects,
        "tasks": _tasks,
        "searches": _searches,
        "printers": _printers,
        "materials": _materials,
    }
    rows = listed[options.what]()
    if options.json:
        schema = f"morph.list.{options.what}/1"
        sys.stdout.write(json.dumps({"schema": schema, options.what: rows}, indent=2) + "\n")
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
            "law": (effect.__doc__ or "").splitlines()[0],
            "twins": list(effect.twins),
            # Some have many, and the longest column stands last.
            "parameters": [f"{p.name} ({p.unit})" for p in effect.parameters()],
        }
        for effect in EFFECTS
    ]


def _tasks() -> list[dict[str, Any]]:
    from morph.body.card import load_card
    from morph.body.shelf import find, names
    from morph.search.searches import default
    from morph.task.tasks import TASKS

    cards = {name: load_card(find(name) / "card.toml").tasks for name in names()}
    return [
        {
            "name": name,
            "search": default(name),
            "what": _first_line(maker.__doc__),
            "robots": [robot for robot, tasks in cards.items() if name in tasks],
        }
        for name, maker in TASKS.items()
    ]


def _searches() -> list[dict[str, Any]]:
    from morph.search.searches import SEARCHES

    rows = []
    for name, place in SEARCHES.items():
        words, from_trials = _described(place)
        needs = "trials on the target" if from_trials else "a simulator"
        rows.append({"name": name, "needs": needs, "what": words})
    return rows


def _printers() -> list[dict[str, Any]]:
    from morph.print.printer import PRINTERS

    return [
        {
            "name": each.name,
            "title": each.title,
            "bed_mm": list(each.bed_mm),
            "nozzle_mm": each.nozzle_mm,
        }
        for each in PRINTERS
    ]


def _materials() -> list[dict[str, Any]]:
    from morph.print.printer import MATERIALS

    return [
        {
            "name": each.name,
            "density_kg_m3": each.density,
            "nozzle_c": each.nozzle_c,
            "bed_c": each.bed_c,
        }
        for each in MATERIALS
    ]


def _described(place: str) -> tuple[str, bool]:
    """Return a class's first line, and whether it learns from trials alone, without importing it.

    Several searches import torch, for which nobody waits who only reads a list.
    """
    module, _, name = place.partition(":")
    spec = find_spec(module)
    if spec is None or spec.origin is None:
        return "", False
    tree = ast.parse(Path(spec.origin).read_text(encoding="utf-8"))
    (result,) = (each for each in tree.body if isinstance(each, ast.ClassDef) and each.name == name)
    lines = [
        part.value.value
        for part in result.body
        if isinstance(part, ast.Assign | ast.AnnAssign)
        and isinstance(part.value, ast.Constant)
        and "from_trials" in {name.id for name in ast.walk(part) if isinstance(name, ast.Name)}
    ]
    if lines:
        return _first_line(ast.get_docstring(result)), bool(lines[-1])
    # What a class does not say itself, the class that it inherits from says.
    names = {base.id for base in result.bases if isinstance(base, ast.Name)}
    origins = {
        alias.name: f"{part.module}:{alias.name}"
        for part in tree.body
        if isinstance(part, ast.ImportFrom)
        for alias in part.names
        if alias.name in names
    }
    inherited = any(_described(origin)[1] for origin in origins.values() if "morph" in origin)
    return _first_line(ast.get_docstring(result)), inherited


def _first_line(words: str | None) -> str:
    """Return what a docstring says first; a function's says that it returns it."""
    first = (words or "").strip().splitlines()[0] if words else ""
    first = first.removeprefix("Return the task to ").removeprefix("Return ")
    return first[:1].upper() + first[1:]
