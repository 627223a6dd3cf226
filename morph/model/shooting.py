"""Batched multiple shooting: predicted readings, and how they change with everything."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array
from morph.model.effect_memory import recalled
from morph.model.hypothesis import Hypothesis
from morph.model.segments import Segments
from morph.model.sensor_readings import shown
from morph.sim.drive import all_received, stamped, unsensed
from morph.sim.rollout import Variant, rollout
from morph.sim.trapezoid import trapezoidal

MOST_ROWS_BYTES = 4e8
"""Memory that one batch's trajectories may take; larger ones run in turns."""


def predict(
    hypothesis: Hypothesis,
    segments: Segments,
    points: Sequence[Array],
    starts: Sequence[Array],
) -> Array:
    """Return predicted readings for several points, shape (points, segments, readings, channels).

    Args:
        hypothesis: The robot and effects.
        segments: Where rollouts start and what drives them.
        points: Where in the hypothesis to simulate.
        starts: As measured, for each point, shape (segments, nq + nv).
    """
    variants, commands, cache = [], [], {}
    for point in points:
        key = point.tobytes()
        if key not in cache:
            cache[key] = trapezoidal(hypothesis.at(point))
        variants.append(cache[key])
        commands.append(_commands(hypothesis, segments, cache[key]))
    rows_bytes = (
        len(segments)
        * (segments.steps + 1)
        * 8.0
        * (segments.start.shape[1] + segments.episodes[0].command.shape[1])
    )
    chunk = max(1, int(MOST_ROWS_BYTES / (2 * rows_bytes)))
    parts = [
        _predict(
            hypothesis,
            segments,
            variants[i : i + chunk],
            commands[i : i + chunk],
            starts[i : i + chunk],
        )
        for i in range(0, len(points), chunk)
    ]
    return np.concatenate(parts)


def _commands(hypothesis: Hypothesis, segments: Segments, variant: Variant) -> Array:
    effects, robot, step = variant.effects, hypothesis.robot, segments.step
    return segments.command(
        [all_received(effects, robot, each.command, step) for each in segments.episodes]
    )


def _predict(
    hypothesis: Hypothesis,
    segments: Segments,
    variants: Sequence[Variant],
    commands: Sequence[Array],
    starts: Sequence[Array],
) -> Array:
    space, channels = segments.measurement.coordinates, segments.measurement.channels
    count, size = len(segments), space.positions
    begin = []
    for variant, start in zip(variants, starts, strict=True):
        true, time = start.copy(), segments.step * segments.first.astype(float)
        for index, dof in zip(space.straight, space.dof, strict=True):
            channel = channels[dof]
            late = stamped(variant.effects, channel, time) - time
            # What is stamped late was read before: at that stamp there stands what is now.
            rate = start[:, size + dof] + segments.grown(size + dof, late)
            place = start[:, index] + segments.grown(index, late)
            before, after = (unsensed(variant.effects, channel, p) for p in (place, place + rate))
            true[:, size + dof], true[:, index] = after - before, before
        begin.append(true)
    start = np.concatenate(begin)
    which = np.repeat(np.arange(len(variants)), count)
    q, _ = rollout(
        variants,
        which,
        start[:, :size],
        start[:, size:],
        np.concatenate(commands),
        states=recalled(hypothesis, segments, variants, which.reshape(-1, count)),
    )
    q = q.reshape(len(variants), count, segments.steps + 1, size)
    read = [
        shown(variant.effects, segments, position)
        for variant, position in zip(variants, q, strict=True)
    ]
    return np.nan_to_num(np.stack(read), nan=1e3, posinf=1e3, neginf=-1e3)


@dataclass(frozen=True, kw_only=True)
class SegmentQuadratic:
    """The loss of each segment near a point, its start already chosen best: c - 2 g.d + d.H.d."""

    hessian: Array
    """H, shape (segments, parameters, parameters)."""
    slope: Array
    """g, shape (segments, parameters)."""
    loss: Array
    """c, shape (segments,)."""
    start_step: Array
    """Best change of the start at d = 0, shape (segments, 2 nv)."""
    start_slope: Array
    """How that changes with d, shape (segments, 2 nv, parameters)."""

    def start_change(self, change: Array, share: float = 1.0) -> Array:
        """Return the best change of starts with one of the point, shape (segments, 2 nv).

        Of their own best change only a share is taken, as of the point's.
        """
        return share * self.start_step + self.start_slope @ change


def residual(segments: Segments, predicted: Array, scale: Array) -> Array:
    """Return readings minus predictions in units of `scale`, padded readings zero."""
    difference = (segments.reading - predicted) / scale
    return np.where(segments.valid, difference, 0.0)


def loss(segments: Segments, predicted: Array, start: Array, scale: Array) -> Array:
    """Return each segment's squared error in units of `scale`, with its start's own cost."""
    error = residual(segments, predicted, scale)
    moved = segments.change(segments.start, start)
    return np.asarray((error**2).sum(axis=(1, 2)) + (moved**2 * segments.start_trust).sum(axis=1))


@dataclass(frozen=True, kw_only=True)
class Sensitivity:
    """The error about a point and how each entry and each start changes the prediction."""

    error: Array
    """Readings minus predictions in units of the scale, (segments, readings x channels)."""
    by_point: Array
    """Change of the prediction with each entry, (segments, readings x channels, parameters)."""
    by_start: Array
    """Change of the prediction with each start, (segments, readings x channels, 2 nv)."""
    start: Array
    """The starts, shape (segments, nq + nv)."""
    exact: bool = True
    """Whether the derivatives are those at this point, and not carried over from another."""

    def after(self, change: Array, error: Array, start: Array, moved: Array) -> Sensitivity:
        """Return the error after a step, and derivatives that tell what it changed.

        Of all such derivatives these are the nearest to the ones before, each in units of its size.
        Source: Broyden 1965, Mathematics of Computation 19(92), eq. 4.5.

        Args:
            change: Of the point, shape (parameters,).
            error: After the step, shape (segments, readings x channels).
            start: After the step, shape (segments, nq + nv).
            moved: What led to it, shape (segments, 2 nv).
        """
        whole = np.concatenate([self.by_point, self.by_start], axis=2)
        moved = np.concatenate([np.tile(change, (len(start), 1)), moved], axis=1)
        missed = self.error - error - (whole @ moved[..., None])[..., 0]
        along = moved * (whole**2).sum(axis=1)
        along /= np.maximum((along * moved).sum(axis=1), 1e-300)[:, None]
        whole += missed[:, :, None] * along[:, None, :]
        by_point, by_start = np.split(whole, [len(change)], axis=2)
        return Sensitivity(
            error=error, by_point=by_point, by_start=by_start, start=start, exact=False
        )

    def in_units(self, factor: Array) -> Sensitivity:
        """Return errors and derivatives times a factor for each channel, shape (channels,)."""
        each = np.tile(factor, self.error.shape[1] // len(factor))
        return replace(
            self,
            error=self.error * each,
            by_point=self.by_point * each[:, None],
            by_start=self.by_start * each[:, None],
        )

    def loss(self, segments: Segments) -> Array:
        """Return each segment's squared error with its start's own cost, (segments,)."""
        moved = segments.change(segments.start, self.start)
        cost = (moved**2 * segments.start_trust).sum(axis=1)
        return np.asarray((self.error**2).sum(axis=1) + cost)


def sensitivity(
    hypothesis: Hypothesis, segments: Segments, point: Array, start: Array, scale: Array
) -> Sensitivity:
    """Return the error and its derivatives by finite differences, all in one batch.

    Args:
        hypothesis: The robot and effects.
        segments: The rollouts.
        point: Where.
        start: Starts as measured, shape (segments, nq + nv).
        scale: Unit of each channel's error, shape (channels,).
    """
    nudge, shift = hypothesis.nudge(point), 1e-4
    points, starts = [point], [start]
    for entry in range(hypothesis.size):
        moved = point.copy()
        moved[entry] += nudge[entry]
        points.append(moved)
        starts.append(start)
    for axis in np.eye(2 * segments.measurement.coordinates.dofs):
        points.append(point)
        starts.append(segments.moved(start, shift * axis[None]))
    read = predict(hypothesis, segments, points, starts)
    flat = residual(segments, read, scale).reshape(len(points), len(segments), -1)
    # The error falls by what the prediction gains.
    change = np.moveaxis(flat[0] - flat[1:], 0, -1)
    return Sensitivity(
        error=flat[0],
        by_point=change[..., : hypothesis.size] / nudge,
        by_start=change[..., hypothesis.size :] / shift,
        start=start,
    )


def quadratic(segments: Segments, around: Sensitivity, weight: Array) -> SegmentQuadratic:
    """Return the loss with each segment's start eliminated, times the segments' weights.

    Source: variable projection, Golub and Pereyra 1973, SIAM J. Numer. Anal. 10(2).
    """
    by_start, by_point, error = around.by_start, around.by_point, around.error
    trust = np.diag(segments.start_trust)
    moved = segments.change(segments.start, around.start)
    transposed = by_start.transpose(0, 2, 1)
    inner = transposed @ by_start + trust
    cross = transposed @ by_point
    pull = (transposed @ error[..., None])[..., 0] + moved @ trust
    best: Array = np.asarray(np.linalg.solve(inner, pull[..., None])[..., 0], dtype=float)
    slope_of_best: Array = np.asarray(np.linalg.solve(inner, cross), dtype=float)
    crossed = cross.transpose(0, 2, 1)
    outer = by_point.transpose(0, 2, 1)
    least = (
        (error**2).sum(axis=1)
        + (moved**2 * segments.start_trust).sum(axis=1)
        - (pull * best).sum(axis=1)
    )
    return SegmentQuadratic(
        hessian=weight[:, None, None] * (outer @ by_point - crossed @ slope_of_best),
        slope=weight[:, None] * (outer @ error[..., None] - crossed @ best[..., None])[..., 0],
        loss=weight * least,
        start_step=best,
        start_slope=-slope_of_best,
    )
