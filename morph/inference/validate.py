"""Blocked cross-validation of hypotheses on nonlinear rollouts."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from morph.arrays import Array, Integers
from morph.errors import EffectError
from morph.inference.explained import certain
from morph.inference.observed import Observed
from morph.inference.quadratic import LogPosterior
from morph.model.effect_memory import recalled
from morph.model.episodes import Episode
from morph.model.hypothesis import Hypothesis
from morph.model.segments import Segments, cut
from morph.model.sensor_readings import shown
from morph.physics.effect import Effect
from morph.physics.joint.motor_side import MotorSideEffect
from morph.sim.drive import all_received
from morph.sim.rollout import Variant, rollout
from morph.sim.trapezoid import trapezoidal

HORIZON = 1.0
"""Seconds of a rollout: long enough for friction to show, short enough not to diverge."""
MOST_ROLLOUTS = 60
"""Rollouts; of longer recordings an even spread."""
FOLDS = 4
"""Least number of folds: whole runs, or stretches of them where there are fewer runs."""
MATERIAL = 0.02
"""Least mean gain of an effect, nats a stretch: two per cent of the size of one channel's error."""
STANDARD_ERRORS = 2.0
"""Least mean gain in standard errors. Prices of the evidence correct for how much was looked at."""
FAR, FARTHEST = 1.0, 10.0
"""Missing force over the inertial force, RMS, from which its model is not believed; and from which
columns of servos tell nothing, and their limits are simulated."""
BRIEF = 0.2
"""Least time that may be claimed, as a share of the period of readings: simulations step, loggers
stamp and controllers hold at moments that differ by as much."""
FAR_OFF = 1e3
"""What a rollout is said to read that is not finite, or that no model can simulate, rad or m."""
HARM = 0.5
"""Most that folds may lose together, as a share of what the others gain."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Validation:
    """Stretches of runs, and which fold each belongs to."""

    segments: Segments
    """The stretches."""
    blocks: int
    """Into how many folds each run is divided."""
    touching: bool = False
    """Whether the robot is in contact with what does not move."""
    stopped: bool = False
    """Whether joints are at the ends of their described ranges in part of the runs."""

    @property
    def constrained(self) -> bool:
        """Whether forces of contact or of stops act, of whose laws rollouts alone tell."""
        return self.touching or self.stopped

    @classmethod
    def of(
        cls, episodes: Sequence[Episode], *, touching: bool = False, stopped: bool = False
    ) -> Validation:
        """Return stretches of episodes.

        Args:
            episodes: The runs.
            touching: Whether the robot is in contact: stretches begin with the run where they can,
                as velocities are known poorly about an impact.
            stopped: Whether joints are at their described ends.
        """
        share = 0.95 if touching and len(episodes) >= FOLDS else 0.5
        longest = share * min(len(e.command) for e in episodes) * episodes[0].step
        segments = cut(episodes, min(HORIZON, longest), most=MOST_ROLLOUTS)
        blocks = -(-FOLDS // len(episodes))
        return cls(segments=segments, blocks=blocks, touching=touching, stopped=stopped)

    @cached_property
    def fold(self) -> Integers:
        """Each stretch's fold, shape (segments,)."""
        lengths = np.array([len(e.command) for e in self.segments.episodes])
        middle = self.segments.first + self.segments.steps // 2
        part = middle * self.blocks // lengths[self.segments.episode]
        return np.asarray(self.segments.episode * self.blocks + part)

    @property
    def folds(self) -> int:
        """How many folds there are."""
        return len(self.segments.episodes) * self.blocks

    def losses(
        self,
        hypothesis: Hypothesis,
        candidates: Sequence[Sequence[Array]],
        runs: Sequence[Observed],
    ) -> Array:
        """Return each stretch's error in rollouts, at the point fitted to the other folds.

        Half the logarithm of one plus the mean squared error over the noise's variance, summed
        over channels: the negative log likelihood of errors whose size is not known, so that bad
        stretches and channels count no more than good ones. Shape (candidates, segments).

        Args:
            hypothesis: What is simulated.
            candidates: For each of some candidates its point for the stretches of each fold.
            runs: Smoothed runs, along which rollouts start.
        """
        segments = self.segments
        read = self.rollouts(hypothesis, candidates, runs)
        error = np.where(segments.valid, segments.reading - read, 0.0)
        mean = (error**2).sum(axis=2) / segments.counts
        return np.asarray(0.5 * np.log1p(mean / segments.noise**2).sum(axis=2))

    def losses_of(
        self, about: LogPosterior, runs: Sequence[Observed], sets: Sequence[Sequence[int]]
    ) -> Array:
        """Return the losses with some sets of the effects of a quadratic, (sets, segments).

        Each is refitted without each fold, the other effects at neutral.
        """
        rest = [about.without_fold(fold) for fold in range(len(about.grams))]
        effects = about.hypothesis.effects_at(about.point)
        # Motors are off their joints in a whole batch or in none of it: such effects cannot idle.
        apart = {at for at, each in enumerate(effects) if isinstance(each, MotorSideEffect)}
        result = np.empty((len(sets), len(self.segments)))
        for gone in {frozenset(apart - set(kept)) for kept in sets}:
            same = [at for at, kept in enumerate(sets) if apart - set(kept) == gone]
            stays = [at for at in range(len(effects)) if at not in gone]
            fewer, entries = about.only(stays)
            points = [[each.idle(sets[at])[entries] for each in rest] for at in same]
            result[same] = self.losses(fewer, points, runs)
        return result

    def rollouts(
        self,
        hypothesis: Hypothesis,
        candidates: Sequence[Sequence[Array]],
        runs: Sequence[Observed],
    ) -> Array:
        """Return predicted readings, shape (candidates, segments, readings, channels).

        Args:
            hypothesis: What is simulated.
            candidates: For each of some candidates its point for the stretches of each fold.
            runs: Smoothed runs, along which rollouts start.
        """
        segments, count, folds = self.segments, len(candidates), len(candidates[0])
        model = functools.cache(functools.partial(_model, hypothesis))
        whole = [model(point.tobytes()) for points in candidates for point in points]
        possible = [variant for variant in whole if variant is not None]
        if not possible:
            return np.full((count, *segments.reading.shape), FAR_OFF)
        variants = [possible[0] if variant is None else variant for variant in whole]
        which = self.fold + folds * np.arange(count)[:, None]
        command = np.empty((count, len(segments), segments.steps, len(hypothesis.robot.actuators)))
        for at, variant in enumerate(variants):
            effects, robot, step = variant.effects, hypothesis.robot, segments.step
            sent = [all_received(effects, robot, e.command, step) for e in segments.episodes]
            inside = which[at // folds] == at
            command[at // folds, inside] = segments.command(sent)[inside]
        begin = list(zip(segments.episode, segments.first, strict=True))
        position = np.stack([runs[e].about.position[first] for e, first in begin])
        velocity = np.stack([runs[e].about.velocity[first] for e, first in begin])
        result, _ = rollout(
            variants,
            which.reshape(-1),
            np.tile(position, (count, 1)),
            np.tile(velocity, (count, 1)),
            command.reshape(which.size, *command.shape[2:]),
            states=recalled(hypothesis, segments, variants, which),
        )
        result = result.reshape(*which.shape, *result.shape[1:])
        read = np.empty((count, *segments.reading.shape))
        for at, variant in enumerate(variants):
            candidate, inside = at // folds, which[at // folds] == at
            moved = result[candidate, inside]
            read[candidate, inside] = shown(variant.effects, segments, moved, inside)
            read[candidate, inside] = FAR_OFF if whole[at] is None else read[candidate, inside]
        return np.nan_to_num(read, nan=FAR_OFF, posinf=FAR_OFF, neginf=-FAR_OFF)

    def sure(self, before: Array, after: Array) -> bool:
        """Return whether losses fall materially, surely, and not in some folds alone.

        Stretches of one run err together: what helps in one fold and harms in the next is an
        accident of a run.

        Args:
            before: Loss of each stretch, shape (segments,).
            after: The same with something added.
        """
        gain = before - after
        by_fold = np.array([gain[self.fold == fold].mean() for fold in np.unique(self.fold)])
        harm = float(-np.minimum(by_fold, 0.0).sum())
        consistent = harm < HARM * float(np.maximum(by_fold, 0.0).sum())
        return gain.mean() > MATERIAL and consistent and _sureness(before, after) > STANDARD_ERRORS

    def idle(self, effect: Effect) -> bool:
        """Return whether an effect does nothing, or is a time far below the period of readings."""
        if effect == effect.neutral():
            return True
        times = [p for p in effect.parameters() if p.unit == "s" and p.neutral is not None]
        periods = [
            float(np.median(np.diff(channel.time)))
            for episode in self.segments.episodes
            for name, channel in episode.recording.channels.items()
            if name in self.segments.measurement.needed
        ]
        least = BRIEF * float(np.median(periods))
        return bool(times) and all(
            abs(getattr(effect, p.name) - (p.neutral or 0.0)) < least for p in times
        )

    def worse(self, before: Array, after: Array) -> bool:
        """Return whether losses rise materially and surely, whatever single folds say."""
        return (
            float((after - before).mean()) > MATERIAL and _sureness(after, before) > STANDARD_ERRORS
        )


def _model(hypothesis: Hypothesis, held: bytes) -> Variant | None:
    """Return a model at a point; none where contact is too stiff for a step."""
    try:
        return trapezoidal(hypothesis.at(np.frombuffer(held)))
    except EffectError:
        return None


def needed(
    about: LogPosterior, validation: Validation, runs: Sequence[Observed]
) -> tuple[list[int], Array]:
    """Return which effects lower the error of rollouts, and the losses with these alone.

    Backward elimination: the least sure effect goes until all that are left are sure, or certain
    by their evidence where runs are explained to their noise. Accidents of the clock go first.

    Args:
        about: The quadratic of their refit, by folds.
        validation: Stretches and folds.
        runs: Smoothed by the refit.
    """
    effects = about.hypothesis.effects_at(about.point)
    kept = [at for at, each in enumerate(effects) if not validation.idle(each)]
    (whole,) = validation.losses_of(about, runs, [kept])
    while kept:
        rest = [[at for at in kept if at != gone] for gone in kept]
        fewer = dict(zip(kept, validation.losses_of(about, runs, rest), strict=True))
        idle = [at for at in kept if not validation.sure(fewer[at], whole)]
        now = about.evidence(kept) if idle else 0.0
        idle = [
            at
            for at in idle
            if not certain(
                now - about.evidence([each for each in kept if each != at]),
                runs,
                event=effects[at].passing,
            )
            or validation.worse(fewer[at], whole)
        ]
        if not idle:
            break
        gone = min(idle, key=lambda at: _sureness(fewer[at], whole))
        kept.remove(gone)
        whole = fewer[gone]
    return kept, whole


def _sureness(before: Array, after: Array) -> float:
    """Return the mean gain over its standard error."""
    gain = before - after
    return float(gain.mean() / (gain.std(ddof=1) / np.sqrt(len(gain)) + 1e-12))
