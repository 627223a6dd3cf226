"""Suspects by linear algebra: which effect's force along the recording explains what is missing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.model.episodes import Episode
from morph.model.hypothesis import Hypothesis, same_kind
from morph.model.motion import Needed, all_needed
from morph.physics import EFFECTS
from morph.physics.effect import Effect


@dataclass(frozen=True, kw_only=True)
class Suspect:
    """An effect at a place, with the strength that the recording suggests."""

    effect: Effect
    """The effect as a linear fit sees it."""
    typical: Effect
    """The effect at a strength that would be felt: a tenth of the forces at work."""
    gain: float
    """Share of the missing force's square that it explains beyond the robot's own figures."""


@dataclass(frozen=True, kw_only=True)
class Screen:
    """Recorded motion as forces, and what of them is missing from a fitted model."""

    hypothesis: Hypothesis
    """The model."""
    parts: Sequence[Needed]
    """The motion, an episode each."""
    weights: Sequence[Array]
    """Of each sample and degree of freedom, (samples, dofs) an episode."""
    target: Array
    """The missing force in units of its size, shape (rows,)."""
    own: Array
    """What each entry of the hypothesis would explain, shape (rows, entries)."""
    price: Array
    """What trust in each entry costs in units of the rows' squares, shape (entries,)."""
    independent: float
    """How many of the samples of one degree of freedom are independent."""

    def columns(self, effect: Effect) -> Array:
        """Return an effect's regressor as columns, shape (rows, strengths)."""
        raw = [part.smooth(effect.regressor(part.motion)) for part in self.parts]
        return _stack(raw, self.weights)


def screened(hypothesis: Hypothesis, point: Array, episodes: Sequence[Episode]) -> Screen:
    """Return the forces along recordings that a model at a point cannot account for."""
    parts = all_needed(hypothesis, point, episodes)
    weights = _weights(parts)
    own = _own_columns(hypothesis, point, episodes, parts, weights)
    target = _stack([part.missing for part in parts], weights)
    # The trust in the description, in units of the samples that are independent.
    independent = max(_independent(parts), 1.0)
    return Screen(
        hypothesis=hypothesis,
        parts=parts,
        weights=weights,
        target=target,
        own=own,
        price=hypothesis.trust[: own.shape[1]] * len(target) / independent,
        independent=independent,
    )


def suspects(screen: Screen) -> tuple[Suspect, ...]:
    """Return every effect at every place, the one that explains most first.

    The force missing from the model along the recording is projected off what a
    change of the robot's own figures could explain (within their trust), and each
    effect's regressor is fitted to the rest. No simulation is run.

    Source: Swevers, Verdonck and De Schutter 2007, eq. 7, with both sides smoothed alike.
    """
    at_work = [_at_work(part) for part in screen.parts]
    forces = float(np.sqrt(np.mean(_stack(at_work, screen.weights) ** 2)))
    own = screen.own
    inner = own.T @ own + np.diag(screen.price + 1e-12)

    def off_own(columns: Array) -> Array:
        return columns - own @ np.linalg.solve(inner, own.T @ columns)

    rest = off_own(screen.target)
    found = []
    for effect in _all(screen.hypothesis):
        best: Suspect | None = None
        for shaped in effect.shapes(screen.parts[0].motion):
            raw = screen.columns(shaped)
            suspect = _fitted(shaped, off_own(raw), rest, _sizes(raw, forces))
            if best is None or suspect.gain > best.gain:
                best = suspect
        if best is not None:
            found.append(best)
    return tuple(sorted(found, key=lambda s: -s.gain))


def _fitted(effect: Effect, columns: Array, rest: Array, sizes: Array) -> Suspect:
    scale = np.sqrt((columns**2).sum(axis=0)) + 1e-12
    # What moves nothing, as an offset along a hinge's axis, is rounding beside the others.
    scale[scale < 1e-9 * scale.max()] = np.inf
    coefficients = np.linalg.lstsq(columns / scale, rest, rcond=1e-8)[0] / scale
    suspect = effect.with_strengths(coefficients)
    # What the bounds leave of the coefficients decides how much is explained.
    left = rest - columns @ suspect.coefficients
    gain = float(1.0 - (left**2).sum() / ((rest**2).sum() + 1e-30))
    return Suspect(effect=suspect, typical=suspect.typical(sizes), gain=gain)


def _sizes(columns: Array, forces: float) -> Array:
    """Return the coefficients at which each column's force is a tenth of the forces at work."""
    size = np.sqrt((columns**2).mean(axis=0)) * np.sqrt(columns.shape[0]) + 1e-12
    moving = np.sqrt((columns != 0.0).any(axis=1).sum() + 1.0)
    return np.asarray(0.1 * forces * moving / size)


def _at_work(part: Needed) -> Array:
    """Return the forces along one episode that drive or are driven, (samples, dofs)."""
    return np.asarray(np.abs(part.missing) + np.abs(part.motion.drive).sum(axis=1))


def _all(hypothesis: Hypothesis) -> list[Effect]:
    return [
        effect
        for kind in EFFECTS
        for effect in (kind.at(place) for place in kind.suspects(hypothesis.robot))
        if not any(same_kind(effect, had) for had in hypothesis.effects)
    ]


def _weights(parts: Sequence[Needed]) -> list[Array]:
    """Return the weight of each sample and degree of freedom, (samples, dofs) an episode.

    A joint held still by dry friction needs exactly what it is given, whatever that
    is: such samples would teach that its actuator does nothing, so they are left out.
    """
    missing = np.concatenate([part.missing for part in parts])
    speed = np.sqrt(np.mean(np.concatenate([part.motion.velocity**2 for part in parts]), axis=0))
    unit = 1.0 / np.sqrt(np.mean(missing**2, axis=0) + 1e-18)
    return [
        unit * (part.smooth((np.abs(part.motion.velocity) > 0.15 * speed).astype(float)) > 0.9)
        for part in parts
    ]


def _stack(parts: Sequence[Array], weights: Sequence[Array]) -> Array:
    """Return (samples, dofs, ...) of all episodes as rows, each in units of its weight."""
    rows = np.concatenate(
        [
            part * weight.reshape(*weight.shape, *([1] * (part.ndim - 2)))
            for part, weight in zip(parts, weights, strict=True)
        ]
    )
    return rows.reshape(-1, *rows.shape[2:])


def _own_columns(
    hypothesis: Hypothesis,
    point: Array,
    episodes: Sequence[Episode],
    parts: Sequence[Needed],
    weights: Sequence[Array],
) -> Array:
    """Return what each entry of the hypothesis would explain, shape (rows, entries)."""
    nudge = hypothesis.nudge(point)
    columns = []
    for entry in range(hypothesis.size):
        moved = point.copy()
        moved[entry] += nudge[entry]
        after_it = all_needed(hypothesis, moved, episodes, suspects=False)
        change = [
            (before.missing - after.missing) / nudge[entry]
            for before, after in zip(parts, after_it, strict=True)
        ]
        columns.append(_stack(change, weights))
    return np.stack(columns, axis=1) if columns else np.zeros((0, 0))


def _independent(parts: Sequence[Needed]) -> float:
    """Return how many samples are independent after smoothing: twice the band times the time."""
    return sum(2.0 * p.episode.cutoff * float(p.time[-1] - p.time[0]) for p in parts)
