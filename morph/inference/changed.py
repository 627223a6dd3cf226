"""Runs cut where the robot changed, so that all that is diagnosed together is one robot's."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from morph.inference.changes import likeliest_change
from morph.inference.explained import at_noise
from morph.inference.finalist import labels
from morph.inference.findings import on_slide
from morph.inference.intervals import estimates
from morph.inference.observed import Observed, missing, settled
from morph.inference.rank import Ranking
from morph.inference.refit import Refit, refitted, seen
from morph.inference.whitened import whitened_blocks
from morph.model.episodes import Episode
from morph.model.finding import Change
from morph.model.measurement import Measurement
from morph.model.pieces import SHORTEST_PIECE, pieces, stretches
from morph.model.split import between
from morph.physics.effect import Effect
from morph.record.recording import Recording
from morph.sim.threads import each

ENOUGH, SOME = 6.0, 3.0
"""Seconds since a change that are diagnosed alone, also where more came before; and the least that
are left by one that is told, and that confirm one."""
ROUGHLY, LIKELY, BELIEVED, DECIDES, LITTLE = 0.3, 0.1, 0.03, 0.004, 0.002
"""Missing force over the inertial force, RMS: up to the first changes are looked for, as a change
leaves much of it; up to the second a side of a change on which its law acts, refitted, is searched
for what else acts; up to the third it counts as explained; up to the fourth, in all runs, evidence
decides; below the last nothing changed where nothing was found."""
FALLEN = 0.5
"""Most of the missing force of all runs that is left on that side, where it is not explained: what
is missing in both has another cause."""
LOUD = 3.0
"""Mean square of a second's innovations, in their own variance, from which on something happened: a
disturbance is that of the middle of a run. Clean runs have 2.2 at most."""
MOST_SECONDS = 60.0
"""Seconds of all runs in which changes are looked for; of longer ones an even spread."""


def changed(
    ranking: Ranking,
    recordings: Sequence[Recording],
    train: Sequence[Episode],
    aside: Sequence[Episode],
    known: Sequence[Effect],
) -> tuple[Change | None, Sequence[Recording], Sequence[Recording]]:
    """Return a change of the robot, or none, the recordings since then, or until it, and the rest.

    The rest is empty where it is too short to be diagnosed alone.

    Where a push in a run that was set aside is likelier, the recordings with that run first, so
    that it is fitted and another is set aside.

    Args:
        ranking: Sets of effects that explain the training runs.
        recordings: All, in the order in which they were recorded.
        train: What was fitted.
        aside: What was set aside for want of named runs: a change is often the last thing that
            happened.
        known: Effects whose fixed parameters are known.
    """
    best, robot = ranking.best.refit, ranking.best.refit.hypothesis.robot
    if ranking.validation.constrained or missing(best.runs) > ROUGHLY:
        return None, recordings, ()
    episodes = stretches([*train, *aside], MOST_SECONDS)
    runs = each(settled, seen(best.hypothesis, best.point, episodes))
    if not best.effects and missing(runs) < LITTLE and _loudest(runs) < LOUD:
        return None, recordings, ()
    result = likeliest_change(replace(best, runs=runs), known, ranking.search.prior)
    if result is None:
        return None, recordings, ()
    episode = episodes[result.run]
    at = [recording.name for recording in recordings].index(episode.recording.name)
    if not result.lasts:
        unseen = episode.recording.name not in {each.recording.name for each in train}
        turned = [recordings[at], *recordings[:at], *recordings[at + 1 :]]
        return None, turned if unseen else recordings, ()
    whole, channels = recordings[at], Measurement.of(robot).needed
    start, first = (
        max(float(some.channel(name).time[0]) for name in channels)
        for some in (whole, episode.recording)
    )
    when = first + episode.begin + result.time
    earlier = [*recordings[:at], between(whole, whole.start, when)]
    later = [between(whole, when, whole.end), *recordings[at + 1 :]]
    before, after = (
        [run for run in some if run.seconds >= SHORTEST_PIECE] for some in (earlier, later)
    )
    lasts = [sum(run.seconds for run in some) for some in (before, after)]
    since = lasts[1] >= min(ENOUGH, lasts[0])
    if max(lasts) < ENOUGH:
        return None, recordings, ()
    change = Change(
        before=result.before,
        after=result.after,
        episode=episode.recording.name,
        time=when - start,
        gain=result.gain,
        since=since,
        slide=on_slide(robot, result.after),
    )
    acting = before if change.ceases else after
    if sum(run.seconds for run in acting) >= SOME and not _explains(change, best, acting):
        return None, recordings, ()
    kept, rest = (after, before) if since else (before, after)
    return change, kept, rest if min(lasts) >= SOME else ()


def _explains(change: Change, whole: Refit, recordings: Sequence[Recording]) -> bool:
    """Return whether a law that changed leaves little of the recordings in which it acts.

    A refit tells in seconds what a search among all laws would in a minute.

    Args:
        change: A likely change.
        whole: The laws that were found in all recordings, refitted.
        recordings: Those in which the law acts.
    """
    hypothesis = whole.hypothesis
    most = max(BELIEVED, min(LIKELY, FALLEN * missing(whole.runs)))
    law = change.before if change.ceases else change.after
    step, robot = hypothesis.step, hypothesis.robot
    laid = [piece for recording in recordings for piece in pieces(recording, robot, step)]
    if not laid:
        return False
    episodes = stretches(laid, MOST_SECONDS)
    alone = refitted(hypothesis, whole.point, episodes)
    if law.label in labels(whole.effects):
        return missing(alone.runs) <= most
    beside = replace(hypothesis, effects=(*whole.effects, law))
    start = np.append(alone.point, beside.start[len(alone.point) :])
    refit = refitted(beside, start, episodes, origin=alone)
    return min(missing(each.runs) for each in (alone, refit)) <= most


def confirmed(change: Change, ranking: Ranking) -> bool:
    """Return whether a law that changed, or a twin of it, is found where it acts, and explains it.

    Stretches in which other physics is missing may look like a change of any law.

    Args:
        change: A change.
        ranking: Of the recordings since then alone, or until it.
    """
    law = change.before if change.ceases else change.after
    names = {f"{name}@{law.where}" for name in (law.name, *law.twins)}
    return bool(names & labels(ranking.best.effects)) and explained(ranking)


def explained(side: Ranking) -> bool:
    """Return whether little force is missing beside what was found on one side of a change."""
    return missing(side.best.refit.runs) <= BELIEVED


def renamed(change: Change, acting: Ranking, idle: Ranking) -> Change | None:
    """Return a change of the one law that is found on one side alone, or none.

    In a few seconds another law may explain what was told as the likeliest change, such as a spring
    a load on the only joint that moves.

    Args:
        change: A change that begins or ceases, whose law is not found.
        acting: Of the recordings in which it acts.
        idle: Of the others.
    """
    effects = {effect.label: effect for effect in acting.best.effects}
    others = labels(idle.best.effects)
    new = [effect for label, effect in effects.items() if label not in others]
    if others - effects.keys() or len(new) != 1 or not (explained(acting) and explained(idle)):
        return None
    (law,) = new
    before, after = (law, law.neutral()) if change.ceases else (law.neutral(), law)
    return None if law.passing else replace(change, before=before, after=after)


def decided(whole: Ranking, side: Ranking) -> bool:
    """Return whether evidence alone tells of a change: what else acts is explained to the noise.

    A law that is weak may show in all runs together and not in those in which it acts alone, of
    which own parameters are known less well.

    Args:
        whole: Of all recordings.
        side: Of those since the change alone, or until it.
    """
    little = at_noise(whole.best.refit.runs, DECIDES)
    return little and explained(side)


def differs(change: Change, sides: Sequence[Ranking]) -> bool:
    """Return whether a law that alters has disjoint 90 % intervals on both sides of a change.

    The same laws are found there: beside others its parameters would make up for them.

    Args:
        change: A change.
        sides: Of the recordings until then, and since then.
    """
    label, sets = change.after.label, [labels(side.best.effects) for side in sides]
    if label not in sets[0] or sets[0] != sets[1]:
        return False
    intervals = []
    for best in (side.best for side in sides):
        at = [effect.label for effect in best.effects].index(label)
        known, _ = estimates(best.about)
        intervals.append([known[entry] for entry in best.refit.removal([at])[0]])
    return any(
        max(one.low90, other.low90) > min(one.high90, other.high90)
        for one, other in zip(*intervals, strict=True)
    )


def _loudest(runs: Sequence[Observed]) -> float:
    """Return the mean square of the innovations in the second of some runs where it is largest."""

    def one(run: Observed) -> float:
        about = run.about
        blocks = whitened_blocks(
            about.tangent,
            about.disturbance,
            about.error[:, :, None],
            -about.acceleration[:, :, None],
            blocks=max(1, round(float(run.motion.time[-1]))),
        )
        return max(float(block.gram[0, 0]) / max(1, block.readings) for block in blocks)

    return max(each(one, runs))


def in_whole(episodes: Sequence[Episode], whole: Mapping[str, Recording]) -> list[Episode]:
    """Return episodes of recordings that were cut at a change as pieces of the whole ones."""
    results = []
    for episode in episodes:
        cut = episode.recording
        other = whole.get(cut.name, cut)
        first, start = (
            max(float(some.channel(name).time[0]) for name in episode.measurement.needed)
            for some in (cut, other)
        )
        begin = episode.begin + first - start
        later = replace(episode, recording=other, begin=begin, whole=False)
        results.append(later if first > start else episode)
    return results
