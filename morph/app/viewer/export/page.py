"""The exported page: bodies that move, with charts, tables and notes beside them."""

from __future__ import annotations

import json
from collections.abc import Collection
from functools import partial
from pathlib import Path

import numpy as np
from jinja2.utils import htmlsafe_json_dumps
from markupsafe import Markup

import morph
from morph.app.report.templates import environment
from morph.app.viewer.camera import Camera
from morph.app.viewer.charts import chart_html
from morph.app.viewer.content import Content, LiveCell
from morph.app.viewer.export.recorded import recorded
from morph.app.viewer.export.scripts import policy
from morph.app.viewer.fragments import notes_html, table_html, told
from morph.app.viewer.player import ARROWS, SAID
from morph.app.viewer.style import style
from morph.arrays import JSON

FOLDER = Path(__file__).parent

MOST_BYTES = 5_000_000
"""Of a page; beyond it fewer pictures a second are kept."""

OTHER = (255, 196, 0)
"""Colour of arrows of a kind that has none of its own."""

STEP = 0.1
"""Cells that change do so every so many seconds: nobody reads faster."""


def exported_page(
    content: Content,
    *,
    title: str = "",
    command: str = "",
    arrows: Collection[str] | None = None,
    following: bool = True,
    camera: Camera | None = None,
) -> str:
    """Return what is shown as one HTML page that needs no network.

    Its own policy forbids browsers to load anything, or to run any script but those that it
    holds. Names from files are escaped wherever they stand.

    Args:
        content: What is shown.
        title: What the view is called; the bodies' names stand after it where the content has
            no title of its own.
        command: What makes this page again.
        arrows: Kinds of arrows that are drawn; by default all.
        following: Whether what travels stays in the middle.
        camera: From where one looks at first; by default all bodies are seen.

    Raises:
        OutputError: This machine lets no server run, which viser needs to make it.
    """
    beside = _beside(content)
    room = MOST_BYTES - sum(len(part) for part in beside.values()) - 40_000
    film = recorded(content, room, arrows=arrows, following=following, camera=camera)
    script = (FOLDER / "page.js").read_text(encoding="utf-8")
    kinds = sorted({kind for actor in content.actors for kind in actor.motion.arrows})
    shown = [kind for kind in kinds if arrows is None or kind in arrows]
    return environment(FOLDER).get_template("page.html.j2").render(
        title=_title(content, title),
        policy=policy(film.html, script),
        style=Markup(style() + _style()),
        film=Markup(film.html.replace("&", "&amp;").replace('"', "&quot;")),
        script=Markup(script),
        moments=[(f"{moment.time:.2f} s", moment.time, moment.title) for moment in content.moments],
        arrows=[_legend(kind) for kind in shown],
        still=content.seconds == 0.0,
        bodies=_bodies(content),
        version=morph.__version__,
        command=command,
        rate=film.rate,
        **{name: Markup(part) for name, part in beside.items()},
    )  # fmt: skip


def _beside(content: Content) -> dict[str, str]:
    """Return what stands beside the bodies, as HTML by its place."""
    return {
        "tables": "".join(table_html(table, content.actors, 0.0) for table in content.tables),
        "charts": "".join(chart_html(chart, content.seconds) for chart in content.charts),
        "notes": notes_html(content.notes) if content.notes else "",
        "data": str(htmlsafe_json_dumps(_data(content), dumps=_dumps)),
    }


def _data(content: Content) -> JSON:
    """Return what the page's script needs: the texts of each cell that changes, in their order."""
    cells = [
        cell
        for table in content.tables
        for row in table.rows
        for cell in row
        if isinstance(cell, LiveCell)
    ]
    return {
        "seconds": round(content.seconds, 6),
        "step": STEP,
        "live": [_texts(content, cell) for cell in cells],
    }


def _texts(content: Content, cell: LiveCell) -> list[str]:
    motion = content.actors[cell.actor].motion
    times = np.arange(0.0, content.seconds + STEP, STEP)
    values = motion.series[cell.series]
    return [told(float(values[motion.at(min(time, content.seconds))]), cell.digits)
            for time in times.tolist()]  # fmt: skip


def _title(content: Content, view: str) -> str:
    if content.title != Content.title:
        return content.title
    names = ", ".join(dict.fromkeys(name for name, _ in _bodies(content)))
    return ": ".join(filter(None, (view, names))) or content.title


def _legend(kind: str) -> tuple[str, str]:
    """Return what arrows of a kind are called, and their colour as CSS has it."""
    return SAID.get(kind, kind), "#{:02x}{:02x}{:02x}".format(*ARROWS.get(kind, OTHER))


def _bodies(content: Content) -> list[tuple[str, str]]:
    """Return each body's name and the hash of its description, once."""
    robots = [actor.figure.robot for actor in content.actors]
    return list(dict.fromkeys((robot.name, robot.sha256) for robot in robots))


def _style() -> str:
    return f"<style>{(FOLDER / 'page.css').read_text(encoding='utf-8')}</style>"


_dumps = partial(json.dumps, allow_nan=False, separators=(",", ":"))
