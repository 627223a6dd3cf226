"""Tables and notes as HTML; every name and text in them is escaped."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape

from morph.app.viewer.content import Actor, CellTable, LiveCell, Marked

SIGNS = {"arrowleft": "←", "arrowright": "→", "arrowup": "↑", "arrowdown": "↓", "f": "F"}
"""How keys are written."""

PLAIN = 1e6
"""Numbers below it are written without a power of ten."""

SHORT = 10
"""A cell of so few characters stays on one line."""


def table_html(table: CellTable, actors: Sequence[Actor], time: float) -> str:
    """Return a table with the values where the clock is, s."""
    head = "".join(f"<th>{escape(each)}</th>" for each in table.head)
    rows = "".join(
        "<tr>"
        + "".join(
            f"<{'td' if at else 'th'}>{_cell(cell, actors, time)}</{'td' if at else 'th'}>"
            for at, cell in enumerate(row)
        )
        + "</tr>"
        for row in table.rows
    )
    kind = "morph words" if table.words else "morph"
    return (
        f'<table class="{kind}"><caption>{escape(table.title)}</caption>'
        f"<thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"
    )


def notes_html(notes: Sequence[str]) -> str:
    """Return sentences as a list."""
    return '<ul class="morph">' + "".join(f"<li>{escape(note)}</li>" for note in notes) + "</ul>"


def keys_html(keys: Sequence[tuple[str, str | None, str]]) -> str:
    """Return a list of keys: the key, what is held with it, and what it does."""
    rows = "".join(
        f"<dt>{''.join(f'<kbd>{SIGNS.get(part, part)}</kbd>' for part in (held, key) if part)}</dt>"
        f"<dd>{escape(statement)}</dd>"
        for key, held, statement in keys
    )
    return f'<dl class="morph keys">{rows}</dl>'


def _cell(cell: str | LiveCell | Marked, actors: Sequence[Actor], time: float) -> str:
    if isinstance(cell, str):
        short = len(cell) <= SHORT
        return f'<span class="mark">{escape(cell)}</span>' if short else escape(cell)
    if isinstance(cell, Marked):
        red, green, blue = cell.colour
        patch = f'<i style="background:rgb({red},{green},{blue})"></i>'
        return f'<span class="mark">{patch}{escape(cell.text)}</span>'
    motion = actors[cell.actor].motion
    text = told(float(motion.series[cell.series][motion.at(time)]), cell.digits)
    return f'<span class="live">{text}</span>'


def told(value: float, digits: int) -> str:
    """Return a number as a cell shows it, with a dash for what is no number."""
    if not math.isfinite(value):
        return "–"
    text = f"{value:.{digits}g}"
    # Nobody reads 8.93e+03 where 8930 has room.
    return f"{float(text):.0f}" if "e+" in text and abs(value) < PLAIN else text
