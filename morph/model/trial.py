"""Suspects tried in rollouts, all in one batch: what each would gain, to first order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array
from morph.model.fit import Fit, Room, room
from morph.model.screen import Suspect
from morph.model.segments import Segments
from morph.model.shooting import Sensitivity, predict, quadratic, residual
from morph.physics.effect import Effect


@dataclass(frozen=True, kw_only=True)
class Tried:
    """An effect added to a fit, its strength and everything else chosen to first order."""

    effect: Effect
    """The effect, its strength as chosen."""
    point: Array
    """The fit's own entries as chosen with it."""
    cost: float
    """Loss of all segments and price of straying, to first order."""


def try_all(found: Fit, segments: Segments, listed: Sequence[Suspect]) -> tuple[Tried, ...]:
    """Return what each effect would bring beside a fit, the best first.

    One rollout with the effect at a suggested strength gives the direction in which it
    moves the readings. A finite strength, because friction started at zero stalls;
    several, and a grid for delays, because their derivatives mislead.
    """
    versions = [version for suspect in listed for version in _versions(suspect)]
    if not versions:
        return ()
    moved = [_direction(found, segments, version) for version in versions]
    best: dict[str, Tried] = {}
    for version, direction in zip(versions, moved, strict=True):
        tried = _tried(found, segments, version, direction)
        had = best.get(version.label)
        if had is None or tried.cost < had.cost:
            best[version.label] = tried
    return tuple(sorted(best.values(), key=lambda tried: tried.cost))


def _versions(suspect: Suspect) -> list[Effect]:
    effect = suspect.effect
    known = {p.name: p for p in effect.parameters()}
    scanned = [name for name in effect.strengths if known[name].scan]
    if scanned:
        return [
            replace(effect, **{scanned[0]: value})  # type: ignore[type-var]
            for value in known[scanned[0]].scan
        ]
    return [effect, suspect.typical]


def _share(effect: Effect, share: float) -> Effect:
    """Return the effect with its strengths moved to a share of the way from neutral."""
    values = {
        p.name: p.neutral + share * (getattr(effect, p.name) - p.neutral)
        for p in effect.parameters()
        if p.neutral is not None
    }
    low_high = {p.name: (p.low, p.high) for p in effect.parameters()}
    kept = {name: float(np.clip(value, *low_high[name])) for name, value in values.items()}
    return replace(effect, **kept)  # type: ignore[type-var]


def _direction(found: Fit, segments: Segments, version: Effect) -> Array:
    more = found.hypothesis.adding(version)
    extra = more.start[found.hypothesis.size :]
    read = predict(more, segments, [np.concatenate([found.point, extra])], [found.start])[0]
    error = residual(segments, read, found.scale).reshape(len(segments), -1)
    return np.asarray(found.around.error - error)


def _tried(found: Fit, segments: Segments, version: Effect, direction: Array) -> Tried:
    around = Sensitivity(
        error=found.around.error,
        by_point=np.concatenate([found.around.by_point, direction[..., None]], axis=2),
        by_start=found.around.by_start,
        start=found.around.start,
    )
    curve = quadratic(segments, around, found.weight)
    own = room(found.hypothesis, found.point)
    # A share of the tried strength, up to half as much again; backwards if it may.
    space = Room(
        low=np.append(own.low, -1.5 if _signed(version) else 0.0),
        high=np.append(own.high, 1.5),
        trust=np.append(own.trust, 1e-6),
        centre=np.append(own.centre, 0.0),
    )
    point = np.append(found.point, 0.0)
    change = space.best_change(curve.hessian.sum(axis=0), curve.slope.sum(axis=0), point)
    return Tried(
        effect=_share(version, _at_least(float(change[-1]), 0.05)),
        point=found.point + change[:-1],
        cost=float(curve.at(change).sum()) + space.price(point + change),
    )


def _signed(effect: Effect) -> bool:
    """Return whether the effect's strengths may lie on either side of neutral."""
    return all(p.low < p.neutral < p.high for p in effect.parameters() if p.neutral is not None)


def _at_least(value: float, least: float) -> float:
    """Return a share that is not so small that a fit would stall at neutral."""
    return value if abs(value) >= least else np.copysign(least, value)
