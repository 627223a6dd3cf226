"""Refit of a description's own parameters and of effects to runs, by Gauss-Newton."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array, Integers
from morph.errors import RecordingError
from morph.inference.columns import acting
from morph.inference.disturbance import log_likelihood
from morph.inference.observed import Observed, missing, observed, settled
from morph.inference.quadratic import information, offset, quadratic
from morph.model.deadline import NEVER, Deadline
from morph.model.episodes import Episode
from morph.model.hypothesis import Hypothesis
from morph.physics.effect import Effect
from morph.sim.threads import each

NEARER = (0.3, 0.1)
"""Of the way from a smaller set's refit, from which a larger one is refitted again."""
TRIALS = ((0.0, 1.0), (0.03, 1.0), (0.0, 0.3), (1.0, 1.0), (0.0, 0.1))
"""Damping and share of a Gauss-Newton step, tried in turn until one gains. Damping turns it where
parameters multiply, a share shortens it where a law has an edge."""
ESTIMATES = 4
"""Most estimates of the disturbances."""
HOPELESS = 5.0
"""Missing force over the inertial force, RMS, above which a larger set gets one estimate alone."""
LITTLE, HIDING = 0.01, 0.005
"""Share of the missing force from which a refit begins again; and missing force over the inertial
force, RMS, from which it may hide what acts."""
SETTLED = 1.0
"""Nats: a refit ends with a step that gains less evidence."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Refit:
    """A hypothesis about some runs, linearised at a point."""

    hypothesis: Hypothesis
    """Its free own parameters and effects."""
    point: Array
    """Log factors of own parameters, then parameters of effects, shape (entries,)."""
    runs: Sequence[Observed]
    """The runs smoothed and linearised at the point."""
    evidence: float
    """Log evidence by Schwarz's criterion, nats, up to a constant; without prices of the search."""
    rank: int
    """Rank of the columns of all entries."""

    @property
    def effects(self) -> tuple[Effect, ...]:
        """The effects at the point."""
        return self.hypothesis.effects_at(self.point)

    def removal(self, gone: Collection[int]) -> tuple[Integers, Array]:
        """Return the entries of some effects' parameters, and what takes them to neutral.

        Args:
            gone: Indices of the effects.
        """
        effects = self.effects
        ends = len(self.hypothesis.knobs) + np.cumsum([len(each.free()) for each in effects])
        entries = np.concatenate(
            [np.arange(ends[at] - len(effects[at].free()), ends[at]) for at in sorted(gone)]
        )
        idle = tuple(e.neutral() if at in gone else e for at, e in enumerate(effects))
        neutral = replace(self.hypothesis, effects=idle).start[entries]
        return entries, neutral - self.point[entries]


def seen(
    hypothesis: Hypothesis,
    point: Array,
    episodes: Sequence[Episode],
    before: Sequence[Observed] | None = None,
) -> list[Observed]:
    """Return runs smoothed and linearised by a hypothesis at a point.

    Args:
        hypothesis: Own parameters and effects.
        point: Shape (entries,).
        episodes: The runs.
        before: The same runs by a similar hypothesis. Effects outside the model act along its
            motion; without it along that of the model alone.

    Raises:
        RecordingError: Without `before`: the model follows a run to no finite motion, as where
            angles are in degrees.
    """
    model, beside = acting(hypothesis, point)

    def one(at: int) -> Observed:
        known, run = before[at] if before else None, episodes[at]
        if beside and known is None:
            known = observed(model, hypothesis.robot, run, effects=beside)
        result = observed(model, hypothesis.robot, run, effects=beside, before=known)
        if before is None and not np.isfinite(result.about.velocity).all():
            raise RecordingError(
                "no finite motion of the described robot comes near its readings",
                where=f"recording {run.name}",
                fix="see that angles are in rad and do not jump by 2 pi, lengths in m and times in "
                "s, or list every column with its unit in recording.toml",
            )
        return result

    return each(one, range(len(episodes)))


def refitted(
    hypothesis: Hypothesis,
    point: Array,
    episodes: Sequence[Episode],
    *,
    origin: Refit | None = None,
    before: Sequence[Observed] | None = None,
    rounds: int = 2,
    deadline: Deadline = NEVER,
) -> Refit:
    """Return a hypothesis refitted to runs by Gauss-Newton steps, shortened if they gain nothing.

    Source: Bell 1994, SIAM Journal on Optimization 4(3), 626-636 (Gauss-Newton through a smoother).

    Args:
        hypothesis: Own parameters and effects.
        point: The first point, shape (entries,).
        episodes: The runs.
        origin: A refit of the same hypothesis less its last effects. Where what was found explains
            less than it, the search starts again from nearer to it.
        before: The runs smoothed by a similar hypothesis, where there is no such refit.
        rounds: Most steps before the disturbances are estimated anew.
        deadline: After which no step begins.
    """
    # Effects act along a motion: without one it is that of the model alone.
    bare = replace(hypothesis, effects=())
    runs = origin.runs if origin else before
    if runs is None:
        runs = seen(bare, point[: len(hypothesis.knobs)], episodes)
        runs = seen(hypothesis, point, episodes, runs) if hypothesis.effects else runs
    else:
        runs = seen(hypothesis, point, episodes, runs)
    most = math.inf if origin is None else HOPELESS
    first = _judged(hypothesis, point, runs, len(point))
    best = _converged(first, episodes, rounds, most, deadline)
    if origin is None:
        return best
    idle, price = _idle(hypothesis, origin), 0.5 * (len(point) - len(origin.point))
    for share in NEARER:
        enough = origin.evidence - price * math.log(readings(runs))
        if best.evidence >= enough or missing(best.runs) > HOPELESS or deadline.passed:
            break
        near = idle + share * (point - idle)
        first = _judged(hypothesis, near, seen(hypothesis, near, episodes, origin.runs), len(near))
        again = _converged(first, episodes, rounds, most, deadline)
        best = max(best, again, key=lambda each: each.evidence)
    return best


def _converged(
    best: Refit,
    episodes: Sequence[Episode],
    rounds: int,
    most: float,
    deadline: Deadline,
    *,
    cold: bool = False,
) -> Refit:
    """Return a refit after Gauss-Newton steps and estimates of the disturbances in turn.

    It ends where more force is missing than `most` of the inertial force. Once, not `cold`, it
    begins again from little missing force: a missing force that holds a joint where dry friction
    would, or that a limit takes away, hides these, and stays likely beside the motion it makes.
    """
    for _ in range(ESTIMATES):
        if deadline.passed:
            break
        best = _descended(best, episodes, rounds)
        # Explained errors leave less force missing, which weighs all readings anew.
        runs = each(settled, best.runs)
        anew = _judged(best.hypothesis, best.point, runs, best.rank)
        last, best = best, max(best, anew, key=lambda each: each.evidence)
        if best.evidence < last.evidence + SETTLED or missing(best.runs) > most:
            break
    if cold or not HIDING < missing(best.runs) <= most or deadline.passed:
        return best
    little = [
        replace(run, about=replace(run.about, disturbance=run.about.leaving(LITTLE)))
        for run in best.runs
    ]
    runs = each(settled, seen(best.hypothesis, best.point, episodes, little))
    again = _judged(best.hypothesis, best.point, runs, best.rank)
    if again.evidence < best.evidence + SETTLED:
        return best
    return _converged(again, episodes, rounds, most, deadline, cold=True)


def _descended(best: Refit, episodes: Sequence[Episode], rounds: int) -> Refit:
    """Return a refit after Gauss-Newton steps under the same disturbances."""
    hypothesis = best.hypothesis
    for _ in range(rounds):
        about = quadratic(hypothesis, best.point, best.runs)
        _, rank, promised = about.step()
        last = best = _judged(hypothesis, best.point, best.runs, rank)
        if promised < SETTLED:
            break
        for damping, share in TRIALS:
            step, _, _ = about.step(damping=damping)
            point = np.clip(best.point + share * step, hypothesis.low, hypothesis.high)
            result = _judged(hypothesis, point, seen(hypothesis, point, episodes, best.runs), rank)
            if result.evidence > best.evidence:
                best = result
                break
        if best is last or (
            (damping, share) == TRIALS[0] and best.evidence < last.evidence + SETTLED
        ):
            break
    return best


def under(refit: Refit, other: Refit) -> Refit:
    """Return a refit under the disturbances of another where the readings are likelier so.

    What is likeliest is searched from one start: another model may have found better.
    """
    runs = []
    for run, theirs in zip(refit.runs, other.runs, strict=True):
        jolt = run.about.disturbance.jolt
        disturbance = replace(theirs.about.disturbance, jolt=jolt)
        runs.append(replace(run, about=replace(run.about, disturbance=disturbance)))
    anew = _judged(refit.hypothesis, refit.point, runs, refit.rank)
    return max(refit, anew, key=lambda each: each.evidence)


def _idle(hypothesis: Hypothesis, origin: Refit) -> Array:
    """Return the point at which a hypothesis with further effects is that of `origin`."""
    count = len(origin.effects)
    neutral = (effect.neutral() for effect in hypothesis.effects[count:])
    point = replace(hypothesis, effects=(*hypothesis.effects[:count], *neutral)).start
    return np.concatenate([origin.point, point[len(origin.point) :]])


def _judged(hypothesis: Hypothesis, point: Array, runs: Sequence[Observed], rank: int) -> Refit:
    """Return a point with its evidence, given the rank of all columns."""
    at = offset(hypothesis, point)
    evidence = -0.5 * float(at @ (information(hypothesis) * at))
    evidence += sum(each(lambda run: log_likelihood(run.about, run.about.disturbance), runs))
    evidence -= 0.5 * max(0, rank - hypothesis.free_knobs) * math.log(readings(runs))
    return Refit(hypothesis=hypothesis, point=point, runs=runs, evidence=evidence, rank=rank)


def readings(runs: Sequence[Observed]) -> int:
    """Return how many readings some runs have."""
    return sum(int(run.about.tangent.valid.sum()) for run in runs)
