"""Content of a window: solid recording, ghost simulations, charts, errors and events."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from morph.app.viewer.content import Actor, Content, Moment
from morph.app.viewer.figure import Figure
from morph.app.viewer.mismatch.arrows import scale_of, wrenches
from morph.app.viewer.mismatch.case import MismatchCase
from morph.app.viewer.mismatch.freedoms import axes, freedoms
from morph.app.viewer.mismatch.heat import Heat, by_error, by_force
from morph.app.viewer.mismatch.mismatch_content import charts, notes, tables
from morph.app.viewer.mismatch.window import CORRECTED, DESCRIBED, MismatchModel, Take
from morph.app.viewer.mismatch.worst import worst_trace
from morph.app.viewer.motion import RATE, posed
from morph.arrays import Array

ARROWS = {DESCRIBED: "wrench", CORRECTED: "remaining"}
"""The kind of arrow that shows what each model lacks."""
BY_ERROR, BY_FORCE, PLAIN = "position error", "missing force", "nothing"
COLOURINGS = (BY_ERROR, BY_FORCE, PLAIN)
"""What links may be coloured by."""


def drawn(case: MismatchCase, take: Take, shown: Sequence[str], colouring: str) -> Content:
    """Return what is shown of a take.

    Args:
        case: Where it is from.
        take: What was computed.
        shown: Names of the models that are shown, at least one.
        colouring: One of `COLOURINGS`.
    """
    models = [model for model in case.models if model.name in shown] or list(case.models[:1])
    heat = _heat(case.figure, take, models, colouring)
    return Content(
        actors=_actors(case, take, models, heat),
        charts=charts(case.figure, take, models),
        tables=tables(case.figure, take, models),
        moments=_moments(case, take),
        notes=(*notes(case, take, models, heat), *take.notes),
        title=f"{case.robot.name}: {take.name}",
    )


def _heat(
    figure: Figure, take: Take, models: Sequence[MismatchModel], colouring: str
) -> Heat | None:
    # Where both are shown, the description is what is in question.
    name = models[0].name
    if colouring == BY_ERROR:
        return by_error(figure, take, name)
    return by_force(figure, take, name) if colouring == BY_FORCE else None


def _actors(
    case: MismatchCase, take: Take, models: Sequence[MismatchModel], heat: Heat | None
) -> tuple[Actor, ...]:
    figure = case.figure
    recorded = replace(
        posed(figure.model, take.measured),
        arrows=_arrows(figure, take, models),
        heat=None if heat is None else heat.share,
        marks=_marks(figure, take),
    )
    ghosts = (
        Actor(
            figure=case.ghost,
            motion=posed(figure.model, take.simulated[model.name]),
            lane=0,
            ghost=True,
            colour=model.colour,
            title="",
        )
        for model in models
    )
    return Actor(figure=figure, motion=recorded, lane=0, title=take.name), *ghosts


def _arrows(figure: Figure, take: Take, models: Sequence[MismatchModel]) -> dict[str, Array]:
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
    anchor, _ = axes(figure.model, figure.robot, take.measured)
    result = np.full((len(take.measured), 3), np.nan)
    links = [freedom.joint.link for freedom in freedoms(figure.robot)]
    # The worst stretch comes first, and has the last word where two overlap.
    for begin, end in reversed(take.worst):
        here = slice(int(begin * RATE), int(end * RATE) + 1)
        result[here] = anchor[here, links.index(worst_trace(take, begin, end).link)]
    return result


def _moments(case: MismatchCase, take: Take) -> tuple[Moment, ...]:
    """Return the worst stretches, then events, then where each finding shows most."""
    worst = [
        Moment(
            time=begin,
            title=f"worst {place}: {worst_trace(take, begin, end).channel}, "
            f"{take.start + begin:.2f} to {take.start + end:.2f} s",
        )
        for place, (begin, end) in enumerate(take.worst, start=1)
    ]
    shown = ((each, case.moment_of(each, take)) for each in case.found)
    return (
        *worst,
        *(Moment(time=event.time, title=event.title) for event in case.events(take)),
        *(
            Moment(time=time, title=f"finding {number}: {each.effect.label}")
            for number, (each, time) in enumerate(shown, start=1)
            if time is not None
        ),
    )
