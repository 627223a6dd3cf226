"""One hop of a gait: a pattern carried to another body, and what few trials make of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from morph.arrays import Array, Mask
from morph.errors import TransferError
from morph.policy.pattern import Pattern
from morph.policy_transfer.gait.direct import direct
from morph.policy_transfer.gait.landscape import Landscape
from morph.policy_transfer.gait.legs import legs
from morph.policy_transfer.gait.limbs import Limb, limbs, responses
from morph.policy_transfer.gait.mover import SETTLE, Mover
from morph.policy_transfer.gait.pace import Pace, pace
from morph.policy_transfer.gait.wave import Wave, at, wave

FASTER = (1.0, 0.5, 2.0, 4.0)
"""Time scales that are tried first, over the one that the responses tell."""

SHORTER = (1.5, 2.0, 3.0)
"""Lags that are tried next, over the source's: how long a wave is no geometry tells."""

ALONE = (1.0, 2.0)
"""Time scales of the wave that a search without a source begins with: tried beside the source's."""

CANDIDATES = 1500
"""Points among which the most promising one is tried next."""


@dataclass(frozen=True, kw_only=True, eq=False)
class GaitBody:
    """A body with its gait: what a hop begins from, and what it ends with."""

    mover: Mover
    """The body."""
    limbs: tuple[Limb, ...]
    """Where each of its servos was found to belong."""
    late: float
    """How late it follows its commands, s."""
    values: Array
    """The numbers of its best wave."""
    speed: float
    """How fast that takes it, m/s."""
    tried: Array
    """The numbers of every wave that was tried on it, shape (trials, numbers)."""
    speeds: Array
    """How fast each went, m/s, shape (trials,)."""
    samples: int
    """Transitions and trials on this body, in control periods."""
    first: Mapping[str, float] = field(default_factory=dict)
    """Speeds of what was carried before any trial chose, by name, m/s."""

    @property
    def policy(self) -> Pattern:
        """The best wave, as a policy of the body."""
        return family_of(self.mover, self.limbs).make(self.values)


def family_of(mover: Mover, results: tuple[Limb, ...]) -> Wave | Pace:
    """Return the waves of a swimmer, or the paces of a body on legs, whose limbs are known."""
    made = wave if mover.wet else pace
    return made(mover.action, results, period=mover.task.period)


def scaled(values: Array, faster: float, shorter: float = 1.0) -> Array:
    """Return waves that are so much faster and shorter, or paces so much faster and higher.

    The frequency is the first of their numbers, a wave's lag and a pace's lift the third.
    """
    return np.asarray(values * np.array([faster, 1.0, shorter, *[1.0] * (values.shape[-1] - 3)]))


@dataclass(frozen=True, kw_only=True)
class Budget:
    """What a hop may cost."""

    transitions: int = 20
    """For each servo."""
    width: float = 0.5
    """How far a servo swings in them, rad."""
    trials: int = 32
    """Runs on the target, the first ones included."""

    def __post_init__(self) -> None:
        """Check the numbers."""
        if self.transitions < 5 or self.trials < 1 or not 0.0 < self.width <= 2.0:
            raise TransferError(
                f"{self.transitions} transitions for a servo that swings {self.width:g} rad, "
                f"and {self.trials} trials",
                where="the budget of a hop",
                fix="give 5 transitions or more, above 0 to 2 rad, and a trial or more",
            )


def felt(
    mover: Mover, budget: Budget, rng: np.random.Generator
) -> tuple[tuple[Limb, ...], float, int]:
    """Return where the servos of a body belong, how late it is, s, and the samples that it took."""
    each = budget.transitions + (0 if mover.wet else SETTLE)
    count = each * len(mover.action)
    seen = mover.transitions(count, rng, width=budget.width)
    result = responses(seen, period=mover.task.period)
    where = limbs(result) if mover.wet else legs(result, mover.robot)
    return where, result.late, len(seen.state)


def hop(
    source: GaitBody, target: Mover, *, rng: np.random.Generator, budget: Budget | None = None
) -> GaitBody:
    """Return the gait of a source on another body.

    From transitions in which one servo swings at a time it learns where each belongs, which way
    it works and how late. The source's wave then becomes one of the target, as fast as the
    target is quick; a few trials tell how far off that is; and the trials that follow are those
    that promise most, where all that was tried on the source says what to expect.

    Raises:
        TransferError: The target's transitions do not tell its limbs.
    """
    budget = budget or Budget()
    result, late, samples = felt(target, budget, rng)
    return tuned(source, target, result, late, samples, rng=rng, trials=budget.trials)


def tuned(
    source: GaitBody | None,
    target: Mover,
    results: tuple[Limb, ...],
    late: float,
    samples: int,
    *,
    rng: np.random.Generator,
    trials: int,
    blind: bool = False,
) -> GaitBody:
    """Return what trials make of a source's wave on a target with these limbs.

    Without a source the trials begin in the middle of the family and nothing is foreseen: so
    much the limbs alone are worth. If they are blind, each is drawn by chance.
    """
    family = family_of(target, results)
    quick = 1.0 if source is None else source.late / late
    start = family.values(family.start)
    middle = start if source is None else scaled(_told(source, source.values, start), quick)
    first = [scaled(middle, each) for each in FASTER][:trials]
    points = np.array([at(family, each) for each in first])
    speeds = target.speed([family.policy(each) for each in points])
    faster = FASTER[int(speeds.argmax())]
    second = [scaled(middle, faster, each) for each in SHORTER][: trials - len(points)]
    if second:
        more = np.array([at(family, each) for each in second])
        points = np.vstack([points, more])
        speeds = np.append(speeds, target.speed([family.policy(each) for each in more]))
    top = int(speeds.argmax())
    shorter = SHORTER[top - len(first)] if top >= len(first) else 1.0
    foreseen = None if source is None else _foreseen(source, family, quick * faster, shorter)
    own = [] if source is None else [scaled(start, each) for each in ALONE][: trials - len(points)]
    if own:
        more = np.array([at(family, each) for each in own])
        gone = target.speed([family.policy(each) for each in more])
        # A source that is worse than none is not believed.
        foreseen = foreseen if speeds.max() >= gone.max() else None
        points, speeds = np.vstack([points, more]), np.append(speeds, gone)
    while len(points) < trials:
        # Where all are still slow, one that goes back says no more than that it does.
        best = max(float(np.abs(speeds).max()), 1e-6)
        known = Landscape(point=points, share=speeds / best, foreseen=foreseen)
        point = rng.random(len(points[0])) if blind else _next(known, points[speeds.argmax()], rng)
        points = np.vstack([points, point])
        speeds = np.append(speeds, target.speed([family.policy(point)]))
    top = int(speeds.argmax())
    return GaitBody(
        mover=target,
        limbs=results,
        late=late,
        values=family.values(points[top]),
        speed=float(speeds[top]),
        tried=np.array([family.values(each) for each in points]),
        speeds=speeds,
        samples=samples + trials * target.trial,
        first={"zero_shot": float(speeds[0])},
    )


def _told(source: GaitBody, values: Array, start: Array) -> Array:
    """Return a source's numbers, and for those that it cannot tell where a search would begin.

    A body of one leg knows of no lag between sides, nor between front and rear.
    """
    if source.mover.wet:
        return values
    among = [limb for limb in source.limbs if limb.role]
    silent = np.zeros(len(start), dtype=bool)
    silent[4] = len({limb.side for limb in among}) < 2
    silent[5] = len({limb.place for limb in among}) < 2
    return np.where(silent, start, values)


def _foreseen(source: GaitBody, family: Wave | Pace, faster: float, shorter: float) -> Landscape:
    """Return what a source says of a target that is faster, and whose waves are shorter."""
    low, high = (np.array([getattr(n, end) for n in family.numbers]) for end in ("low", "high"))
    values = scaled(_told(source, source.tried, family.values(family.start)), faster, shorter)
    within = (values >= low - 1e-9) & (values <= high + 1e-9)
    near: Mask = np.asarray(within.all(axis=1))
    near[int(source.speeds.argmax())] = True
    share = np.maximum(source.speeds / max(source.speed, 1e-9), -0.2)
    return Landscape(
        point=np.array([at(family, each) for each in values[near]]),
        share=share[near],
        prior=1.0,
    )


def _next(known: Landscape, best: Array, rng: np.random.Generator) -> Array:
    """Return the point that promises most, of many near the best and some anywhere."""
    size = len(best)
    reach = rng.choice([0.03, 0.08, 0.2], CANDIDATES)[:, None]
    near = best + reach * rng.standard_normal((CANDIDATES, size))
    far = rng.uniform(0.0, 1.0, (CANDIDATES // 3, size))
    points = np.clip(np.concatenate([near, far]), 0.0, 1.0)
    return np.asarray(points[int(known.promise(points).argmax())])


def begun(
    mover: Mover, *, rng: np.random.Generator, trials: int, budget: Budget | None = None
) -> GaitBody:
    """Return a gait that a body has learned by itself, the first of a chain.

    Args:
        mover: The body.
        rng: The chance of its transitions and of its search.
        trials: Runs of the search.
        budget: What its transitions cost.
    """
    result, late, samples = felt(mover, budget or Budget(), rng)
    family = family_of(mover, result)
    learned = direct(mover, family, trials=trials, sigma=0.25, seed=int(rng.integers(2**31)))
    top = int(learned.speed.argmax())
    return GaitBody(
        mover=mover,
        limbs=result,
        late=late,
        values=family.values(learned.point[top]),
        speed=learned.best,
        tried=np.array([family.values(each) for each in learned.point]),
        speeds=learned.speed,
        samples=samples + trials * mover.trial,
    )
