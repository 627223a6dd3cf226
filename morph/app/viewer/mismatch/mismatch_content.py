"""Charts, errors and notes beside the mismatch view."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from morph.app.viewer.content import CellTable, Chart, ChartLine
from morph.app.viewer.figure import Figure
from morph.app.viewer.mismatch.arrows import scale_of
from morph.app.viewer.mismatch.case import MismatchCase
from morph.app.viewer.mismatch.freedoms import freedoms
from morph.app.viewer.mismatch.heat import Heat
from morph.app.viewer.mismatch.window import (
    CORRECTED,
    DESCRIBED,
    MismatchModel,
    MismatchTrace,
    Take,
)

MOST_CHARTED = 6
"""Channels that are charted, the worst ones."""
COLOURS = {DESCRIBED: "blue", CORRECTED: "green"}
"""What the ghosts' colours are called."""
MEASURED = "currentColor"
"""Colour of what was measured: that of the text, dark on light and light on dark."""


def charts(figure: Figure, take: Take, models: Sequence[MismatchModel]) -> tuple[Chart, ...]:
    """Return charts of the worst channels, of their errors, and of the forces that are missing."""
    worst = _worst_first(take)[:MOST_CHARTED]
    return tuple(chart for trace in worst for chart in _charts(trace, models)) + _force_charts(
        figure, take, models
    )


def tables(figure: Figure, take: Take, models: Sequence[MismatchModel]) -> tuple[CellTable, ...]:
    """Return the errors of each channel and the forces that are missing at each joint."""
    return (_errors(take, models), *_lacks(figure, take, models))


def _charts(trace: MismatchTrace, models: Sequence[MismatchModel]) -> tuple[Chart, Chart]:
    lines = [
        ChartLine(
            name=model.title, time=trace.time, value=trace.simulated[model.name], colour=model.css
        )
        for model in models
    ]
    measured = ChartLine(
        name="measured", time=trace.time, value=trace.measured, colour=MEASURED, leads=True
    )
    errors = tuple(replace(line, value=trace.measured - line.value) for line in lines)
    return (
        Chart(title=trace.channel, unit=trace.unit, lines=(measured, *lines)),
        Chart(title=f"{trace.channel}: measured - simulated", unit=trace.unit, lines=errors),
    )


def _force_charts(figure: Figure, take: Take, models: Sequence[MismatchModel]) -> tuple[Chart, ...]:
    if not take.missing:
        return ()
    worst = [trace.link for trace in _worst_first(take)][:MOST_CHARTED]
    return tuple(
        Chart(
            title=f"{freedom.name}: missing {'force' if freedom.unit == 'N' else 'torque'}",
            unit=freedom.unit,
            lines=tuple(
                ChartLine(
                    name=model.title,
                    time=take.missing[model.name].time,
                    value=take.missing[model.name].force[:, at],
                    colour=model.css,
                )
                for model in models
            ),
        )
        for at, freedom in enumerate(freedoms(figure.robot))
        if freedom.joint.link in worst
    )


def _errors(take: Take, models: Sequence[MismatchModel]) -> CellTable:
    how = "open loop" if take.horizon is None else f"restarted every {take.horizon:g} s"
    until = take.start + take.seconds
    return CellTable(
        title=f"Position error (RMS), {take.start:g} to {until:.3g} s, {how}",
        head=("", *(model.title for model in models), "noise"),
        rows=tuple(
            (
                f"{each.channel.removesuffix('.position')} ({each.unit})",
                *(f"{each.rmse[model.name]:.3g}" for model in models),
                f"{each.noise:.2g}",
            )
            for each in take.traces
        ),
    )


def _lacks(figure: Figure, take: Take, models: Sequence[MismatchModel]) -> tuple[CellTable, ...]:
    """Return the table of the forces that are missing, if they are known."""
    if not take.missing:
        return ()
    sizes = {name: np.sqrt(np.mean(each.force**2, axis=0)) for name, each in take.missing.items()}
    return (
        CellTable(
            title="Missing force (RMS)",
            head=("", *(model.title for model in models)),
            rows=tuple(
                (
                    f"{freedom.name} ({freedom.unit})",
                    *(f"{sizes[model.name][at]:.3g}" for model in models),
                )
                for at, freedom in enumerate(freedoms(figure.robot))
            ),
        ),
    )


def notes(
    case: MismatchCase, take: Take, models: Sequence[MismatchModel], heat: Heat | None
) -> tuple[str, ...]:
    """Return what colours, arrows and marks mean, and what does not fit together."""
    scale = scale_of(case.figure, take)
    ghosts = " and ".join(f"{model.title} ({COLOURS[model.name]})" for model in models)
    how = (
        "starts where the recording does"
        if take.horizon is None
        else f"is put back to the recording every {take.horizon:g} s"
    )
    return tuple(
        note
        for note in (
            f"Solid: as recorded. Ghosts: the simulation {ghosts}; it gets the recorded commands "
            f"and {how}.",
            "" if heat is None else heat.note,
            "" if scale is None else scale.note(len(models) > 1),
            "A red ball marks the worst joint in the worst stretches." if take.worst else "",
            *(
                f"Finding {number}: {each.statement} {each.figures}."
                for number, each in enumerate(case.found, start=1)
            ),
            *case.notes,
        )
        if note
    )


def _worst_first(take: Take) -> list[MismatchTrace]:
    return sorted(take.traces, key=lambda each: -each.rmse[DESCRIBED] / each.noise)
