"""Least squares of inverse dynamics over the samples at which joints slip.

Where stiction holds a joint no force is known, and no model of a missing force tells it from a weak
motor: filters and rollouts go wrong together. While the joint slips its equation of motion holds
whatever the others do, and forces are linear in nearly all that may be wrong.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import minimum_filter1d
from scipy.signal import butter, filtfilt

from morph.arrays import Array
from morph.inference.columns import Columns, acting, forces_by
from morph.inference.observed import Observed, force_of
from morph.inference.output_error import output_error
from morph.inference.quadratic import LogPosterior, information, offset
from morph.inference.validate import Validation
from morph.inference.whitened import Whitened
from morph.model.deadline import NEVER, Deadline
from morph.model.hypothesis import Hypothesis
from morph.physics.body_motion import body_motions
from morph.physics.dynamics import supplied
from morph.physics.effect import Effect
from morph.sim.drive import all_received
from morph.sim.threads import each

BAND = 5.0
"""Forces are compared below this frequency, Hz: above it gears of arms swing."""
ORDER = 3
"""Order of the filter that leaves the higher ones out."""
SLIPS = 0.2
"""Velocity, as a share of its RMS in the run, from which a joint slips."""
ROUNDS, REWEIGHTED = 25, 3
"""Most Gauss-Newton steps, and estimates of the residuals' sizes under each."""
FIRST, FAILED = 1e-3, 3
"""Damping of the first step, and most steps in turn that gain nothing."""
TINY = 1e-9
"""Least size of an error, N m or N."""
SETTLED = 1.0
"""Nats: a refit ends with a step that gains less."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ForceRows:
    """Missing forces of one run and their columns, below `BAND` and at twice its rate."""

    rows: Array
    """[error, columns] of each joint's force, N m or N, shape (rows, dofs, 1 + columns)."""
    slips: Array
    """1 where the joint slips all the while that a row covers, else 0, shape (rows, dofs)."""


def as_moved(hypothesis: Hypothesis, point: Array, seen: Observed) -> Observed:
    """Return a run with the accelerations of its smoothed motion, whatever force they took.

    Dry friction acts against the velocities.
    """
    motion, run, about = seen.motion, seen.run, seen.about
    acceleration = np.empty_like(about.velocity)
    acceleration[:-1] = np.diff(about.velocity, axis=0) / run.step
    acceleration[-1] = acceleration[-2]
    model, links = hypothesis.at(point).model, [link.name for link in hypothesis.robot.links]
    motion = replace(
        motion,
        acceleration=acceleration,
        bodies=body_motions(model, links, motion.qpos, motion.velocity, acceleration),
        senses={name: np.sign(motion.speed(name)) for name in motion.joints},
    )
    return replace(seen, motion=motion)


def force_rows(columns: Columns, seen: Observed, grids: Sequence[tuple[Effect, ...]]) -> ForceRows:
    """Return what a model lacks of the forces that a smoothed motion needs, and their columns.

    Args:
        columns: The model, and the derivatives by the entries of its point.
        seen: A run from `as_moved`.
        grids: Effects, each at some shapes; those on sensors have no column here.
    """
    hypothesis, model, run = columns.hypothesis, columns.model, seen.run
    _, beside = acting(hypothesis, columns.point)
    command = all_received(beside, hypothesis.robot, seen.sent, run.step)
    motion = replace(seen.motion, command=command)
    seen = replace(seen, motion=motion)
    lacking = -supplied(model, motion.qpos, motion.velocity, motion.acceleration, command)
    lacking -= force_of(beside, motion)
    force, _ = columns.forces(seen)
    effects, parts = hypothesis.effects_at(columns.point), [lacking[:, :, None], force]
    for shapes in grids:
        if shapes[0].kind == "sensor":
            count = sum(len(effect.strengths) for effect in shapes)
            parts.append(np.zeros((*lacking.shape, count)))
        else:
            parts.append(forces_by(shapes, motion, effects))
    whole = np.concatenate(parts, axis=2)
    speed = np.abs(motion.velocity)
    slips = speed > SLIPS * np.sqrt(np.mean(speed**2, axis=0))
    width = max(1, round(0.5 / BAND / run.step))
    if len(whole) > 8 * width:
        numerator, denominator = butter(ORDER, min(2.0 * BAND * run.step, 0.99))
        whole = filtfilt(numerator, denominator, whole, axis=0)
    # The smoother's edges know a motion poorly.
    inside = slice(width, len(whole) - width, width)
    kept = minimum_filter1d(slips.astype(np.uint8), size=2 * width + 1, axis=0)
    return ForceRows(rows=whole[inside], slips=kept[inside].astype(float))


@dataclass(frozen=True, kw_only=True, eq=False)
class ForceErrors:
    """Gram matrices of [errors, columns] of each joint's force."""

    grams: Array
    """Shape (folds, dofs, 1 + columns, 1 + columns)."""
    counts: Array
    """How many rows there are, shape (folds, dofs)."""

    @classmethod
    def of(cls, rows: Sequence[ForceRows], blocks: int = 1) -> ForceErrors:
        """Return those of the rows of some runs, each divided into folds."""
        grams, counts = [], []
        for run in rows:
            for part in np.array_split(np.arange(len(run.rows)), blocks):
                kept = run.rows[part] * run.slips[part, :, None]
                turned = kept.transpose(1, 0, 2)
                grams.append(turned.transpose(0, 2, 1) @ turned)
                counts.append(run.slips[part].sum(axis=0))
        return cls(grams=np.stack(grams), counts=np.stack(counts))

    def sizes(self, step: Array) -> Array:
        """Return the RMS error of each joint's force after a step, N m or N, shape (dofs,)."""
        turn = np.concatenate([[1.0], -step])
        squares = np.einsum("c,fjcd,d->j", turn, self.grams, turn, optimize=True)
        return np.asarray(
            np.sqrt(np.maximum(squares, 0.0) / np.maximum(self.counts.sum(axis=0), 1.0))
        )

    def quadratic(self, hypothesis: Hypothesis, point: Array, sizes: Array) -> LogPosterior:
        """Return the log posterior about a point, with errors in units of their sizes."""
        grams = np.einsum("j,fjcd->fcd", sizes**-2.0, self.grams)
        rows = int(self.counts.sum())
        return LogPosterior(hypothesis=hypothesis, point=point, grams=grams, readings=rows)

    def value(self, about: LogPosterior) -> float:
        """Return the log posterior, errors at their likeliest sizes, nats, up to a constant."""
        sizes = self.sizes(np.zeros(len(about.point)))
        at = offset(about.hypothesis, about.point)
        prior = 0.5 * float(at @ (information(about.hypothesis) * at))
        return -float(self.counts.sum(axis=0) @ np.log(sizes + TINY)) - prior


def likeliest_forces(
    hypothesis: Hypothesis,
    point: Array,
    runs: Sequence[Observed],
    *,
    blocks: int = 1,
    deadline: Deadline = NEVER,
) -> LogPosterior:
    """Return the log posterior about the point at which forces err least.

    The sizes of the errors are not known: each joint's is estimated with the point. The motion
    stays as it was smoothed.

    Source: Swevers, Verdonck and De Schutter 2007, IEEE Control Systems 27(5), 58-71; damped as by
    Marquardt 1963, Journal of SIAM 11(2).

    Args:
        hypothesis: Own parameters and effects.
        point: Where it begins, shape (entries,).
        runs: Smoothed by a similar hypothesis.
        blocks: Into how many folds each run is divided.
        deadline: After which no step begins.
    """

    def errors(point: Array) -> ForceErrors:
        columns = Columns.of(hypothesis, point)
        return ForceErrors.of(each(lambda seen: force_rows(columns, seen, ()), runs), blocks)

    runs = each(lambda seen: as_moved(hypothesis, point, seen), runs)
    none = np.zeros(len(point))
    result = errors(point)
    about = result.quadratic(hypothesis, point, result.sizes(none) + TINY)
    damping, failed, best = FIRST, 0, result.value(about)
    for _ in range(ROUNDS):
        if failed > FAILED or deadline.passed:
            break
        step = none
        for _ in range(REWEIGHTED):
            sizes = result.sizes(step) + TINY
            step, _, _ = result.quadratic(hypothesis, about.point, sizes).step(damping=damping)
        there = np.clip(about.point + step, hypothesis.low, hypothesis.high)
        tried = errors(there)
        new = tried.quadratic(hypothesis, there, tried.sizes(none) + TINY)
        value = tried.value(new)
        if not value > best:
            damping, failed = 10.0 * damping, failed + 1
            continue
        gained, damping, failed = value - best, 0.1 * damping, 0
        best, about, result = value, new, tried
        if gained < SETTLED:
            break
    return about


def weighed_forces(
    own: Columns, grids: Sequence[tuple[Effect, ...]], runs: Sequence[Observed]
) -> tuple[list[ForceRows], Array]:
    """Return rows in units of the errors' sizes without the effects, and these, shape (dofs,)."""

    def one(seen: Observed) -> ForceRows:
        return force_rows(own, as_moved(own.hypothesis, own.point, seen), grids)

    result = each(one, runs)
    counts = sum(run.slips.sum(axis=0) for run in result)
    squares = sum((run.slips * run.rows[:, :, 0] ** 2).sum(axis=0) for run in result)
    sizes = np.sqrt(squares / np.maximum(counts, 1.0)) + TINY
    return [
        replace(run, rows=run.rows * (run.slips / sizes)[:, :, None]) for run in result
    ], np.asarray(sizes)


def force_levels(
    own: Columns, grids: Sequence[tuple[Effect, ...]], runs: Sequence[Observed], blocks: int,
    shares: Sequence[float],
) -> list[list[Whitened]]:  # fmt: skip
    """Return Gram matrices of [errors, entries of the point, effects], by level and by fold.

    A level's errors are taken to be a share of what they are without the effects.

    Args:
        own: The model, and the derivatives by the entries of its point.
        grids: Effects, each at some shapes.
        runs: Smoothed by the model.
        blocks: Into how many folds each run is divided.
        shares: One for each level.
    """
    result, sizes = weighed_forces(own, grids, runs)
    levels: list[list[Whitened]] = [[] for _ in shares]
    for run in result:
        for part in np.array_split(np.arange(len(run.rows)), blocks):
            rows = run.rows[part].reshape(-1, run.rows.shape[2])
            gram, count = rows.T @ rows, run.slips[part].sum(axis=0)
            for level, share in zip(levels, shares, strict=True):
                logarithm = 2.0 * float(count @ np.log(share * sizes))
                readings = int(count.sum())
                level.append(Whitened(gram=gram / share**2, logarithm=logarithm, readings=readings))
    return levels


def force_error(
    hypothesis: Hypothesis,
    point: Array,
    validation: Validation,
    deadline: Deadline = NEVER,
    *,
    runs: Sequence[Observed] | None,
) -> LogPosterior:
    """Return the log posterior where forces err least, or rollouts, whichever predicts better.

    Args:
        hypothesis: Own parameters and effects; of sensors forces tell nothing.
        point: Where it begins, shape (entries,).
        validation: The rollouts. They are fitted from the better of the two points.
        deadline: After which no step begins.
        runs: Smoothed by a similar hypothesis; None if they are not yet.
    """
    if runs is None or any(effect.kind == "sensor" for effect in hypothesis.effects):
        return output_error(hypothesis, point, validation, deadline)
    blocks = validation.blocks
    forces = likeliest_forces(hypothesis, point, runs, blocks=blocks, deadline=deadline)
    points = [[each] * validation.folds for each in (point, forces.point)]
    before, after = validation.losses(hypothesis, points, runs).mean(axis=1)
    start = forces.point if after < before else point
    result = output_error(hypothesis, start, validation, deadline)
    if after >= before:
        return result
    every = [range(len(hypothesis.effects))]
    losses = [validation.losses_of(one, runs, every).mean() for one in (forces, result)]
    return forces if losses[0] < losses[1] else result
