"""A take as content: the recording solid, simulations as ghosts, charts, errors, moments."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from morph.app.viewer.content import Actor, Chart, Content, Line, Moment, Table
from morph.app.viewer.figure import Figure
from morph.app.viewer.mismatch.arrows import axes, scale_of, wrenches
from morph.app.viewer.mismatch.case import Case
from morph.app.viewer.mismatch.heat import Heat, by_error, by_force
from morph.app.viewer.mismatch.take import CORRECTED, DESCRIBED, Model, Take, Trace
from morph.app.viewer.motion import RATE, posed
from morph.arrays import Array

MOST_CHARTED = 6
"""Channels that are charted, the worst ones."""
MEASURED = "#333333"
"""Colour of what was measured."""
ARROWS = {DESCRIBED: "wrench", CORRECTED: "remaining"}
"""The kind of arrow that shows what each model lacks."""
BY_ERROR, BY_FORCE, PLAIN = "position error", "missing force", "nothing"
COLOURINGS = (BY_ERROR, BY_FORCE, PLAIN)
"""What links may be coloured by."""


def drawn(case: Case, take: Take, shown: Sequence[str], colouring: str) -> Content:
    """Return what is shown of a take.

    Args:
        case: Where it is from.
        take: What was computed.
        shown: Names of the models that are shown, at least one.
        colouring: One of `COLOURINGS`.
    """
    models = [model for model in case.models if model.name in shown] or list(case.models[:1])
    heat = _heat(case.figure, take, models, colouring)
    traces = _worst_first(take)
    return Content(
        actors=_actors(case.figure, take, models, heat),
        charts=tuple(chart for trace in traces[:MOST_CHARTED] for chart in _charts(trace, models))
        + _force_charts(case.figure, take, models),
        tables=(_errors(take, models), *_lacks(case.figure, take, models)),
        moments=tuple(
            Moment(time=begin, title=_moment(take, begin, end, place))
            for place, (begin, end) in enumerate(take.worst, start=1)
        ),
        notes=(*_notes(case, take, models, heat), *take.notes),
        title=f"{case.robot.name}: {take.name}",
    )


def _heat(figure: Figure, take: Take, models: Sequence[Model], colouring: str) -> Heat | None:
    # Where both are shown, the description is what is in question.
    name = models[0].name
    if colouring == BY_ERROR:
        return by_error(figure, take, name)
    return by_force(figure, take, name) if colouring == BY_FORCE else None


def _actors(
    figure: Figure, take: Take, models: Sequence[Model], heat: Heat | None
) -> tuple[Actor, ...]:
    recorded = replace(
        posed(figure.model, take.measured),
        arrows=_arrows(figure, take, models),
        heat=None if heat is None else heat.share,
        marks=_marks(figure, take),
    )
    ghosts = (
        Actor(
            figure=figure,
            motion=posed(figure.model, take.simulated[model.name]),
            lane=0,
            ghost=True,
            colour=model.colour,
            title="",
        )
        for model in models
    )
    return Actor(figure=figure, motion=recorded, lane=0, title=take.name), *ghosts


def _arrows(figure: Figure, take: Take, models: Sequence[Model]) -> dict[str, Array]:
    scale = scale_of(figure, take)
    if scale is None:
        return {}
    return {
        ARROWS[model.name]: wrenches(figure, take, model.name, scale, aside=float(place))
        for place, model in enumerate(models)
    }


def _marks(figure: Figure, take: Take) -> Array | None:
    """Return where the worst joint is in the worst stretches, (pictures, 3), NaN elsewhere."""
    if not take.worst or not take.traces:
        return None
    anchor, _ = axes(figure, take.measured)
    found = np.full((len(take.measured), 3), np.nan)
    links = [joint.link for joint in figure.robot.joints]
    # The worst stretch comes first, and has the last word where two overlap.
    for begin, end in reversed(take.worst):
        here = slice(int(begin * RATE), int(end * RATE) + 1)
        found[here] = anchor[here, links.index(worst_trace(take, begin, end).link)]
    return found


def worst_trace(take: Take, begin: float, end: float) -> Trace:
    """Return the channel that the description misses most in a stretch, in units of its noise."""

    def lost(trace: Trace) -> float:
        here = (trace.time >= begin) & (trace.time <= end)
        error = (trace.measured - trace.simulated[DESCRIBED])[here] / trace.noise
        return float(np.mean(error**2)) if len(error) else 0.0

    return max(take.traces, key=lost)


def _moment(take: Take, begin: float, end: float, place: int) -> str:
    channel = worst_trace(take, begin, end).channel
    return f"{place}. worst: {channel}, {take.start + begin:.2f} to {take.start + end:.2f} s"


def _worst_first(take: Take) -> list[Trace]:
    return sorted(take.traces, key=lambda each: -each.rmse[DESCRIBED] / each.noise)


def _charts(trace: Trace, models: Sequence[Model]) -> tuple[Chart, Chart]:
    lines = [
        Line(name=model.title, time=trace.time, value=trace.simulated[model.name], colour=model.css)
        for model in models
    ]
    measured = Line(
        name="measured", time=trace.time, value=trace.measured, colour=MEASURED, leads=True
    )
    errors = tuple(replace(line, value=trace.measured - line.value) for line in lines)
    return (
        Chart(title=trace.channel, unit=trace.unit, lines=(measured, *lines)),
        Chart(title=f"{trace.channel}: measured - simulated", unit=trace.unit, lines=errors),
    )


def _force_charts(figure: Figure, take: Take, models: Sequence[Model]) -> tuple[Chart, ...]:
    if not take.missing:
        return ()
    worst = [trace.link for trace in _worst_first(take)][:MOST_CHARTED]
    return tuple(
        Chart(
            title=f"{joint.name}: missing {'force' if joint.kind == 'slide' else 'torque'}",
            unit=joint.effort_unit,
            lines=tuple(
                Line(
                    name=model.title,
                    time=take.missing[model.name].time,
                    value=take.missing[model.name].force[:, at],
                    colour=model.css,
                )
                for model in models
            ),
        )
        for at, joint in enumerate(figure.robot.joints)
        if joint.link in worst
    )


def _errors(take: Take, models: Sequence[Model]) -> Table:
    how = "open loop" if take.horizon is None else f"restarted every {take.horizon:g} s"
    until = take.start + take.seconds
    return Table(
        title=f"Error (RMS) in {take.name}, {take.start:g} to {until:.3g} s, {how}",
        head=("channel", *(model.title for model in models), "noise", "unit"),
        rows=tuple(
            (
                each.channel,
                *(f"{each.rmse[model.name]:.3g}" for model in models),
                f"{each.noise:.2g}",
                each.unit,
            )
            for each in take.traces
        ),
    )


def _lacks(figure: Figure, take: Take, models: Sequence[Model]) -> tuple[Table, ...]:
    """Return the table of the forces that are missing, if they are known."""
    if not take.missing:
        return ()
    sizes = {name: np.sqrt(np.mean(each.force**2, axis=0)) for name, each in take.missing.items()}
    return (
        Table(
            title="Missing force (RMS)",
            head=("joint", *(model.title for model in models), "unit"),
            rows=tuple(
                (joint.name, *(f"{sizes[m.name][at]:.3g}" for m in models), joint.effort_unit)
                for at, joint in enumerate(figure.robot.joints)
            ),
        ),
    )


def _notes(case: Case, take: Take, models: Sequence[Model], heat: Heat | None) -> tuple[str, ...]:
    scale = scale_of(case.figure, take)
    how = (
        "starts where the recording does"
        if take.horizon is None
        else f"is put back to the recording every {take.horizon:g} s"
    )
    return tuple(
        note
        for note in (
            f"The simulation gets the recorded commands, and {how}.",
            "" if heat is None else heat.note,
            "" if scale is None else scale.note(len(models) > 1),
            "A red ball marks the worst joint in the worst stretches." if take.worst else "",
            *case.notes,
        )
        if note
    )
