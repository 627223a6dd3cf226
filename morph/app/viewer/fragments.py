"""Tables, charts and notes as HTML; every name and text in them is escaped."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape

from morph.app.viewer.content import Actor, Chart, Live, Table


def table_html(table: Table, actors: Sequence[Actor], time: float) -> str:
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
    return (
        f'<table class="morph"><caption>{escape(table.title)}</caption>'
        f"<thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"
    )


def notes_html(notes: Sequence[str]) -> str:
    """Return sentences as a list."""
    return '<ul class="morph">' + "".join(f"<li>{escape(note)}</li>" for note in notes) + "</ul>"


def chart_html(chart: Chart, seconds: float, time: float) -> str:
    """Return a chart with its cursor where the clock is, s."""
    # The cursor is drawn over the chart; the chart itself is drawn once.
    return f'<figure class="morph"><figcaption>{escape(chart.title)}</figcaption></figure>'


def _cell(cell: str | Live, actors: Sequence[Actor], time: float) -> str:
    if isinstance(cell, str):
        return escape(cell)
    motion = actors[cell.actor].motion
    value = float(motion.series[cell.series][motion.at(time)])
    return f"{value:.{cell.digits}g}" if math.isfinite(value) else "–"
