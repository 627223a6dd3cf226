"""What a hypothesis leaves unexplained: the missing force under which runs are likeliest."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array
from morph.inference.disturbance import VIBRATIONS, log_likelihood
from morph.inference.finalist import Finalist
from morph.inference.observed import Observed, missing_by_joint
from morph.inference.validate import Validation
from morph.model.episodes import Episode, velocity_lag
from morph.model.hypothesis import Hypothesis

SHARE, NATS = 0.003, 400.0
"""Where what remains is as probably physics as not: share of the joints' force, and evidence."""
UNTOLD = 0.45
"""Most probability for a robot in contact: laws of its forces show in rollouts alone."""
ROUGH = 2.0
"""Error of rollouts, over that by errors of their initial states alone (impacts magnify these),
above which physics is left, if there are no findings."""
SEEN, CHAOS = 0.01, 0.3
"""The same over the variance of the motion, below which it may be the error of simulated contact;
and the part of it by initial states above which rollouts tell nothing: a robot that falls over."""
STEEP = 2.0
"""How steeply probability rises with the logarithm of each."""
MOST_UNKNOWN = 0.55
"""Greatest probability: laws of the library that a search has missed leave as much. All are set by
hand on development cases of `experiments.concealed`, before others judged."""

MOST_LAGS = 3.0
"""Missing force over what a step leaves of Coriolis forces, up to which it may be that."""

AT_NOISE, SMALL = 1.5, 0.25
"""Mean squared error of rollouts over the noise's variance up to which a set of effects predicts
well, and most probability then: of development cases so answered 1 of 7 held physics without a
name."""


@dataclass(frozen=True, kw_only=True)
class Remains:
    """What a model leaves of some runs."""

    share: float
    """Missing force over the inertial force, RMS over runs, of the worst joint."""
    channels: Mapping[str, float]
    """The same by the channel of each degree of freedom that was read."""
    nats: float
    """By how much readings are likelier with missing force and vibration than at their floor."""
    in_noise: float
    """Error of the rollouts of a typical segment: geometric mean over channels of 1 + MSE over the
    noise's variance, less 1."""
    named: bool = False
    """Whether the model has effects."""
    touching: bool = False
    """Whether the robot is in contact or its joints are at their described ends."""
    by_starts: float = 0.0
    """Of a robot in contact, `in_noise` as errors of the rollouts' starts alone make it."""
    in_motion: float = 0.0
    """Of a robot in contact, that error over the variance of the segment's readings, likewise."""

    @property
    def chaotic(self) -> bool:
        """Whether a robot in contact moves elsewhere for no more than errors of its start."""
        return self.in_motion * self.by_starts > CHAOS * self.in_noise

    @property
    def probability(self) -> float:
        """How probable it is that physics is left which has no name here."""
        predicts = self.named and self.in_noise < AT_NOISE
        return min(SMALL if predicts else MOST_UNKNOWN, self.any_physics)

    @property
    def any_physics(self) -> float:
        """How probable it is that any physics is left, without a name or missed.

        In contact rollouts tell of it too, beside what errors of their starts make of them.
        """
        tiny = 1e-12
        rough = self.in_noise > ROUGH * (1.0 + self.by_starts) and self.in_motion > SEEN
        if self.touching and rough and not self.named and not self.chaotic:
            return 1.0
        steep = STEEP * min(
            math.log(max(self.share, tiny) / SHARE), math.log(max(self.nats, tiny) / NATS)
        )
        some = float(1.0 / (1.0 + math.exp(-np.clip(steep, -30.0, 30.0))))
        return min(some, UNTOLD) if self.touching else some


def by_step(nominal: Hypothesis, episodes: Sequence[Episode], runs: Sequence[Observed]) -> bool:
    """Return whether what remains may be the error of the simulation's step.

    Args:
        nominal: The description, with the step.
        episodes: The runs, laid on the grid.
        runs: The same, smoothed by the best model.
    """
    share = missing_by_joint(runs)
    worst = int(share.argmax())
    if share[worst] < SHARE:
        return False
    lag = velocity_lag(nominal.robot, episodes, nominal.step)
    return bool(share[worst] < MOST_LAGS * lag[worst])


def remaining(result: Finalist, validation: Validation) -> Remains:
    """Return what a refit leaves unexplained of the runs it was fitted to."""
    runs, segments = result.refit.runs, validation.segments
    share = missing_by_joint(runs)
    touching = validation.constrained
    return Remains(
        share=float(share.max()),
        channels={
            segments.measurement.channels[at]: float(share[at]) for at in segments.read.tolist()
        },
        nats=sum(_over_floor(run) for run in runs),
        in_noise=_typical(result.fitted, validation),
        named=bool(result.effects),
        touching=touching,
        by_starts=_by_starts(result, validation) if touching else 0.0,
        in_motion=_in_motion(result, validation) if touching else 0.0,
    )


def _typical(losses: Array, validation: Validation) -> float:
    """Return the error of a typical segment over the noise's variance, by all segments' losses."""
    return float(np.expm1(2.0 * np.median(losses) / len(validation.segments.read)))


def _by_starts(result: Finalist, validation: Validation) -> float:
    """Return the error of rollouts by errors of their initial states alone, as `in_noise`."""
    rng, segments, runs = np.random.default_rng(0), validation.segments, result.refit.runs
    space, begun = segments.measurement.coordinates, []
    for run in runs:
        about = run.about
        noise = about.sensed[: about.velocity.shape[1]]
        off = noise * rng.standard_normal(about.velocity.shape)
        rate = about.velocity + about.spread * rng.standard_normal(about.velocity.shape)
        moved = replace(about, position=space.moved_by(about.position, off), velocity=rate)
        begun.append(replace(run, about=moved))
    points = [[result.about.point] * validation.folds]
    hypothesis = result.about.hypothesis
    one, other = (validation.rollouts(hypothesis, points, each)[0] for each in (runs, begun))
    squared = np.where(segments.valid, (one - other) ** 2, 0.0).sum(axis=1) / segments.counts
    return _typical(0.5 * np.log1p(squared / segments.noise**2).sum(axis=1), validation)


def _in_motion(result: Finalist, validation: Validation) -> float:
    """Return the error of a typical segment over the variance of its readings."""
    segments, points = validation.segments, [[result.about.point] * validation.folds]
    (read,) = validation.rollouts(result.about.hypothesis, points, result.refit.runs)
    off = np.where(segments.valid, segments.reading - read, 0.0)
    centred = np.where(segments.valid, segments.reading, np.nan)
    spread = np.nanvar(centred, axis=1) + segments.noise**2
    squared = (off**2).sum(axis=1) / segments.counts
    return _typical(0.5 * np.log1p(squared / spread).sum(axis=1), validation)


def _over_floor(run: Observed) -> float:
    """Return by how much the readings are likelier than with no more than a floor of force."""
    about = run.about
    noise = about.sensed[: about.velocity.shape[1]]
    least = replace(about.leaving(0.0), vibration=VIBRATIONS[0] * noise)
    return log_likelihood(about, about.disturbance) - log_likelihood(about, least)
