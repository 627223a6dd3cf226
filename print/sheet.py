"""The assembly sheet: one page that tells how parts become the body, on screen and on paper."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import jinja2
import numpy as np
from markupsafe import Markup

from morph.print.assembly import AssemblyStep, short, steps
from morph.print.explode import exploded
from morph.print.gauge import PLAYS_MM
from morph.print.job import Job
from morph.print.part import Hinge, Part
from morph.print.picture import Colour, PlacedMesh, picture

FOLDER = Path(__file__).parent

COLOURS: tuple[Colour, ...] = (
    (203, 219, 233),
    (240, 206, 160),
    (188, 222, 203),
    (234, 198, 210),
    (222, 214, 240),
    (236, 226, 160),
)
"""Of printed parts, in turn; bright, for paper."""

BOUGHT: Colour = (128, 134, 142)
"""Of what is bought."""

MOST_LABELS = 45
"""Copies that a number points at; of more only the first of each part has one."""

LEANING = np.array([0.55, -1.0, 0.75])
"""From a part on the bed to who looks."""

SMALL, SMALL_IN_ALL = 900, 20_000
"""Faces of the picture of one part, and of those of all parts."""


@dataclass(frozen=True, kw_only=True)
class Row:
    """A part as the table has it; all text, none of it HTML."""

    part: Part
    """The part."""
    plate: str
    """Where it is printed."""
    grams: str
    """What one copy weighs."""
    support: str
    """How it lies, and what that saves."""
    lies: Markup
    """A picture of it as it lies on the bed."""


def sheet(job: Job, hinges: Sequence[Hinge], *, title: str, command: str = "") -> str:
    """Return the assembly sheet as an HTML page that needs nothing else.

    Args:
        job: What is printed.
        hinges: How the links move.
        title: What the body is called; from a file, and escaped as all text is.
        command: What made it.
    """
    explosion = exploded(job.parts, hinges)
    colours = _colours(job.parts)
    page = _environment().get_template("sheet.html.j2")
    printed = [part for part in job.parts if part.kind == "printed"]
    return page.render(
        title=title,
        command=command,
        job=job,
        hours=_hours(job.seconds),
        plates=sum(not plate.name.startswith("gauge") for plate in job.plates),
        plays=", ".join(f"{play:g}" for play in PLAYS_MM),
        apart=Markup(_apart(job, hinges, title)),
        rows=[_row(part, job, colours, len(printed)) for part in printed],
        gauges=[_row(part, job, colours, len(job.gauges)) for part in job.gauges],
        bought=[part for part in job.parts if part.kind == "bought"],
        fused=[part for part in job.parts if part.kind == "fused"],
        steps=steps(job.parts, hinges, explosion),
        needs=_needs,
        short=short,
        style=Markup((FOLDER / "sheet.css").read_text(encoding="utf-8")),
    )


def _apart(job: Job, hinges: Sequence[Hinge], title: str) -> str:
    """Return the exploded picture; empty where nothing has a shape."""
    given, colours = exploded(job.parts, hinges), _colours(job.parts)
    copies = sum(part.count for part in job.parts if part.mesh is not None)
    drawn = [
        PlacedMesh(
            mesh=part.mesh.moved(given.pose(part, copy)),
            colour=colours[part.name],
            label="" if copy and copies > MOST_LABELS else part.number or part.name,
        )
        for part in job.parts
        if part.mesh is not None
        for copy in range(part.count)
    ]
    return picture(drawn, title=f"{title}, taken apart") if drawn else ""


def _colours(parts: Sequence[Part]) -> dict[str, Colour]:
    printed = [part.name for part in parts if part.kind != "bought"]
    results = {name: COLOURS[at % len(COLOURS)] for at, name in enumerate(printed)}
    return results | {part.name: BOUGHT for part in parts if part.kind == "bought"}


def _row(part: Part, job: Job, colours: dict[str, Colour], among: int) -> Row:
    sliced, lies = job.sliced.get(part.name), job.orientations.get(part.name)
    plates = [plate.name for plate in job.plates if part.name in {it.part for it in plate.laid}]
    drawing, support = Markup(), ""
    if part.mesh is not None and lies is not None:
        pose = np.eye(4)
        pose[:3, :3] = lies.turn
        drawn = PlacedMesh(mesh=part.mesh.moved(pose), colour=colours.get(part.name, COLOURS[0]))
        few = max(120, min(SMALL, SMALL_IN_ALL // max(among, 1)))
        name = f"{part.name} as it lies on the bed"
        drawing = Markup(picture([drawn], title=name, towards=LEANING, faces=few, margin=20.0))
        support = _support(lies.support_mm3, lies.first_support_mm3, lies.height_mm)
    return Row(
        part=part,
        plate=", ".join(plates).replace("_", " "),
        grams="" if sliced is None else f"{1e3 * sliced.weight.mass:.1f}",
        support=support,
        lies=drawing,
    )


def _support(now: float, before: float, height: float) -> str:
    needs = "no support" if now < 1.0 else f"support: {1e-3 * now:.1f} cm³"
    saved = f" (as drawn: {1e-3 * before:.1f} cm³)" if before - now >= 100.0 else ""
    return f"{needs}{saved}, {height:.0f} mm high"


def _hours(seconds: float) -> str:
    hours, rest = divmod(round(seconds / 60.0), 60)
    return f"{hours} h {rest:02d} min" if hours else f"{rest} min"


def _needs(step: AssemblyStep) -> str:
    times = "" if len(step.links) < 2 else f"{len(step.links)} times: "
    return times + ", ".join(
        f"{count} × {number or name.replace('_', ' ')}" for count, number, name in step.needs
    )


@cache
def _environment() -> jinja2.Environment:
    return jinja2.Environment(
        loader=jinja2.FileSystemLoader(FOLDER),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
