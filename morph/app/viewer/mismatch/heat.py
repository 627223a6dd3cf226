"""How strongly links are coloured: by the error of their joints, or by the force they lack."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from morph.app.viewer.figure import Figure
from morph.app.viewer.mismatch.freedoms import freedoms
from morph.app.viewer.mismatch.window import DESCRIBED, MismatchTrace, Take
from morph.app.viewer.motion import RATE
from morph.arrays import Array
from morph.model.motion import low_pass

SMOOTHED = 3.0
"""Hz: what changes faster is not shown, so that colours do not flicker."""
FULL = 0.95
"""Full red is what the description exceeds in one picture of twenty."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Heat:
    """Colours of links, and what they mean."""

    share: Array
    """0 to 1, shape (pictures, links)."""
    note: str
    """What full red is."""
    full: dict[str, float] = field(default_factory=dict)
    """By unit, what full red is."""


def by_error(figure: Figure, take: Take, model: str) -> Heat | None:
    """Return colours by the error of each joint's position in units of its noise."""
    pictures = len(take.measured)
    if not take.traces:
        return None
    scale = max(
        _high(_smooth(_error(each, DESCRIBED, pictures)) / each.noise) for each in take.traces
    )
    if scale <= 0.0:
        return None
    parts = [
        (each.link, _smooth(_error(each, model, pictures)) / each.noise / scale)
        for each in take.traces
    ]
    worst = max(take.traces, key=lambda each: each.rmse[DESCRIBED] / each.noise)
    return Heat(
        share=on_links(figure, parts, pictures),
        note=(
            f"Links are coloured by the error of their joint: full red is {_plain(scale)} times "
            f"its noise, {scale * worst.noise:.2g} {worst.unit} for {worst.channel}."
        ),
    )


def by_force(figure: Figure, take: Take, model: str) -> Heat | None:
    """Return colours by the force that is missing at each joint."""
    if model not in take.missing:
        return None
    pictures = len(take.measured)
    known = freedoms(figure.robot)
    full: dict[str, float] = {}
    for at, freedom in enumerate(known):
        high = _high(np.abs(forces(take, DESCRIBED, pictures)[:, at]))
        full[freedom.unit] = max(high, full.get(freedom.unit, 0.0))
    missed = forces(take, model, pictures)
    parts = [
        (freedom.joint.link, np.abs(missed[:, at]) / full[freedom.unit])
        for at, freedom in enumerate(known)
        if full[freedom.unit] > 0.0
    ]
    text = " and ".join(f"{value:.2g} {unit}" for unit, value in full.items())
    return Heat(
        share=on_links(figure, parts, pictures),
        note=f"Links are coloured by the force that is missing at their joint: full red is {text}.",
        full=full,
    )


def forces(take: Take, model: str, pictures: int) -> Array:
    """Return the missing force in the pictures, (pictures, dofs); NaN where it is not known."""
    missed = take.missing[model]
    when = np.arange(pictures) / RATE
    return np.stack(
        [
            np.interp(when, missed.time, column, left=np.nan, right=np.nan)
            for column in missed.force.T
        ],
        axis=1,
    )


def on_links(figure: Figure, parts: Sequence[tuple[str, Array]], pictures: int) -> Array:
    """Return values of links, 0 to 1; a link that is bolted to another has its value.

    Args:
        figure: Whose links.
        parts: A link by name and its value in the pictures; of several the greatest counts.
        pictures: How many there are.
    """
    names = figure.links
    own: dict[int, Array] = {}
    for link, value in parts:
        at = names.index(link)
        own[at] = np.maximum(own.get(at, np.zeros(pictures)), np.nan_to_num(value))
    result = np.zeros((pictures, len(names)))
    for body in range(1, len(names)):
        if body in own:
            result[:, body] = own[body]
        elif not figure.model.body_jntnum[body]:
            result[:, body] = result[:, int(figure.model.body_parentid[body])]
    return np.clip(result, 0.0, 1.0)


def _error(trace: MismatchTrace, model: str, pictures: int) -> Array:
    """Return how far a model is off in the pictures; 0 where nothing is simulated."""
    known = np.isfinite(trace.time)
    if not known.any():
        return np.zeros(pictures)
    error = np.abs(trace.measured - trace.simulated[model])[known]
    when = np.arange(pictures) / RATE
    return np.interp(when, trace.time[known], error, left=0.0, right=0.0)


def _smooth(values: Array) -> Array:
    when = np.arange(len(values)) / RATE
    return np.abs(low_pass(values, when, SMOOTHED)) if len(values) > 1 else values


def _plain(value: float) -> str:
    """Return two figures without an exponent."""
    return f"{float(f'{value:.2g}'):g}"


def _high(values: Array) -> float:
    known = values[np.isfinite(values)]
    return float(np.quantile(known, FULL)) if len(known) else 0.0
