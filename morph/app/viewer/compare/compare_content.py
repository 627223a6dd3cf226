"""The content of the comparison: actors, table, charts and notes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from morph.app.viewer.compare.arrows import arrows, said, scales
from morph.app.viewer.compare.body_show import Show
from morph.app.viewer.compare.figures import COST, ENERGY, MARGIN
from morph.app.viewer.compare.shared_work import Work
from morph.app.viewer.content import Actor, CellTable, Chart, ChartLine, Content, LiveCell
from morph.app.viewer.motion import RATE

COLOURS = (
    "#0072b2",
    "#d55e00",
    "#009e73",
    "#cc79a7",
    "#e69f00",
    "#56b4e9",
    "#7b3294",
    "#7f7f7f",
)
"""Of the bodies' lines, told apart by the colour-blind too; after Okabe and Ito 2008."""

HOLDING = "holding margin (%)"
"""What the margin is called where nothing moves by physics."""

LIVE = {"margin (%)": (MARGIN, 3), "energy (J)": (ENERGY, 3), "cost": (COST, 3)}
"""The columns of what is done, each with its series and its figures."""

MOST_POINTS = 400
"""Points of a line in a chart: more are finer than a screen."""

NO_PHYSICS = (
    "No physics: each joint goes through its range. The holding margin is what is left of the "
    "limit of the motor that is nearest to it, had the body to stand still in the poses so far, "
    "in air, its base held."
)

SIMULATED = (
    "Simulated. Margin: the least that was left so far of the torque of a motor. Energy: "
    "the work of all motors so far, |torque x way|, braking counted like driving. Goals: "
    "those reached at the end."
)


def told(
    task: str | None,
    rest: Sequence[Show],
    works: Sequence[Work[Show]],
) -> Content:
    """Return what is shown of bodies of which some are ready.

    Args:
        task: Name of the task; None where joints go through their ranges.
        rest: Each body at rest, shown until it is ready, or if it fails.
        works: What comes of each.
    """
    ready = [work.found for work in works]
    shows = [result or still for result, still in zip(ready, rest, strict=True)]
    full = scales([show.felt for show in shows if show.felt is not None])
    actors = tuple(_actor(show, full) for show in shows)
    return Content(
        actors=actors,
        tables=(_bodies(shows), _figures(task, shows, works)),
        charts=_charts(shows) if task is not None else (),
        notes=(
            *_failures(rest, works),
            *(note for show in shows for note in show.notes),
            NO_PHYSICS if task is None else SIMULATED,
            *(f"Arrows of {kind}: {length}." for kind, length in lengths(works).items()),
        ),
        title=f"{task or 'compare'}: {', '.join(show.figure.name for show in shows)}",
    )


def lengths(works: Sequence[Work[Show]]) -> Mapping[str, str]:
    """Return what the length of each kind of arrow means, in words, of the kinds that there are."""
    shows = [work.found for work in works if work.found is not None]
    return said(scales([show.felt for show in shows if show.felt is not None]))


def _actor(show: Show, full: Mapping[str, float]) -> Actor:
    moved = show.motion
    if show.felt is not None:
        moved = replace(moved, arrows=arrows(show.felt, full))
    return Actor(figure=show.figure, motion=moved)


def _bodies(shows: Sequence[Show]) -> CellTable:
    """Return what the bodies are, whatever they do."""
    rows = []
    for show in shows:
        robot = show.figure.robot
        moving = [joint for joint in robot.joints if joint.kind != "free" and joint.mimic is None]
        driven = set(robot.driven)
        rows.append((show.figure.name, f"{robot.mass:.4g}", str(len(moving)), str(len(driven))))
    return CellTable(
        title="Bodies", head=("body", "mass (kg)", "joints", "driven"), rows=tuple(rows)
    )


def _figures(task: str | None, shows: Sequence[Show], works: Sequence[Work[Show]]) -> CellTable:
    """Return what the bodies do, where the clock is."""
    live = {HOLDING: (MARGIN, 3)} if task is None else LIVE
    rows = []
    for at, (show, work) in enumerate(zip(shows, works, strict=True)):
        row: list[str | LiveCell] = [show.figure.name]
        for name, digits in live.values():
            there = name in show.motion.series
            row.append(LiveCell(actor=at, series=name, digits=digits) if there else _waiting(work))
        if task is not None:
            row.append(_goals(show) if work.done else _waiting(work))
        rows.append(tuple(row))
    head = ("body", *live) if task is None else ("body", *live, "goals")
    return CellTable(title=task or "Joints through their ranges", head=head, rows=tuple(rows))


def _waiting(work: Work[Show]) -> str:
    return "\N{EN DASH}" if work.done else "\N{HORIZONTAL ELLIPSIS}"


def _goals(show: Show) -> str:
    if show.verdict is None:
        return "\N{EN DASH}"
    reached, missed = len(show.verdict.reached), len(show.verdict.missed)
    return f"{reached} of {reached + missed}".replace(" ", "\N{NO-BREAK SPACE}")


def _charts(shows: Sequence[Show]) -> tuple[Chart, ...]:
    results = []
    for name, title, unit in ((COST, "Cost so far", ""), (ENERGY, "Energy so far", "J")):
        lines = []
        for at, show in enumerate(shows):
            if name in show.motion.series:
                value = np.asarray(show.motion.series[name])
                some = np.unique(np.linspace(0, len(value) - 1, MOST_POINTS).round().astype(int))
                lines.append(
                    ChartLine(
                        name=show.figure.name,
                        time=some / RATE,
                        value=value[some],
                        colour=COLOURS[at % len(COLOURS)],
                    )
                )
        if lines:
            results.append(Chart(title=title, unit=unit, lines=tuple(lines)))
    return tuple(results)


def _failures(rest: Sequence[Show], works: Sequence[Work[Show]]) -> tuple[str, ...]:
    return tuple(
        f"{still.figure.name} stands still: {work.error.what}; {work.error.fix}"
        for still, work in zip(rest, works, strict=True)
        if work.error is not None
    )
