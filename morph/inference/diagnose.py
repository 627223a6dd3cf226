"""From recordings to named, modelled, proven physics: the whole of a diagnosis."""

from __future__ import annotations

import functools
import math
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from morph.body.robot import Robot
from morph.errors import DiagnosisError
from morph.inference.changed import (
    changed,
    confirmed,
    decided,
    differs,
    explained,
    in_whole,
    renamed,
)
from morph.inference.prepared import MOST_SECONDS, Prepared, completed, prepared
from morph.inference.rank import Progress, Ranking, ranked
from morph.inference.remains import by_step
from morph.inference.verdict import DiagnosisRuns, conclude
from morph.model.deadline import Deadline
from morph.model.derived_channels import by_effort
from morph.model.diagnosis import Diagnosis
from morph.model.finding import Change
from morph.model.measurement import Measurement
from morph.model.pieces import stretches
from morph.model.segments import scored_segments
from morph.model.validate_recordings import (
    check_channels,
    check_recordings,
    check_settings,
    check_tree,
)
from morph.physics.effect import Effect
from morph.record.distinct import check_distinct, distinct
from morph.record.recording import Recording
from morph.sim.threads import one_thread

MOST_CHANGES = 2
"""Most changes that are looked for."""
ONE_SIDE, OTHER_SIDE = "on one side of a likely change, ", "on its other side, "
"""Of which runs progress is told."""
LEAST_SIDE = 60.0
"""Seconds that the runs on one side of a change may always take; they may take as long as all that
went before."""


@one_thread()
def diagnose(
    robot: Robot,
    recordings: Sequence[Recording],
    *,
    held_out: Sequence[Recording] = (),
    horizon: float | None = 1.0,
    vary: Mapping[str, float] | None = None,
    known: Sequence[Effect] = (),
    budget: float | None = None,
    interrupt: threading.Event | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> Diagnosis:
    """Return where a description and recordings part, and what physics was left out.

    Args:
        robot: The nominal description.
        recordings: What the robot did: positions of joints, at least one, of which the others are
            estimated, or poses of links that tell them; the pose of each link that moves freely;
            every actuator's command, or of motors the effort measured at their joint.
        held_out: Recordings kept for testing, scored once after the model was chosen; by default
            the last quarter.
        horizon: Seconds of the open-loop rollouts that are scored, at least 0.1; None
            for whole episodes.
        vary: Fractions by which the description may be wrong: of all `mass`, `com`, `inertia`,
            `gain` and `joint`, or of one part, as `mass:forearm`; by default 0.1, of gains 0.05.
        known: Effects whose fixed parameters are known, such as the edge of a paddle.
        budget: Seconds; when they are spent the best answer so far is returned, marked.
        interrupt: Set to have that answer at once.
        seed: Random seed.
        progress: Told what is being done and the share of the work behind.

    Raises:
        DiagnosisError: Nothing to fit or to score, a setting out of range, or a robot with a
            closed chain that is welded.
        RecordingError: A channel is missing or holds what cannot be, such as angles in degrees or
            poses of another link; or two recordings are the same.
        KernelError: There is no C compiler for the Kalman filter.
    """
    started = time.monotonic()
    check_settings(horizon, budget, seed)
    check_recordings(recordings, held_out)
    check_tree(robot)
    recordings, held_out = (
        [completed(by_effort(each, robot), robot) for each in some]
        for some in map(distinct, (recordings, held_out))
    )
    measured = Measurement.of(robot).needed
    for recording in (*recordings, *held_out):
        check_channels(recording, robot, measured)
    check_distinct((*recordings, *held_out))
    say = _onward(progress or (lambda what, share: None))
    deadline = Deadline(
        time=started + 0.9 * (budget or math.inf), interrupt=interrupt or threading.Event()
    )
    whole = {recording.name: recording for recording in recordings}
    rank = functools.partial(
        _ranked, robot, held_out=held_out, whole=whole, vary=vary, known=known, deadline=deadline,
        say=say,
    )  # fmt: skip
    (ready, ranking), changes = _since_changes(
        rank, recordings, held_out, known, started, deadline, say
    )
    scored = scored_segments(ready.aside, horizon)
    say("scoring the held-out runs", 0.9)
    return conclude(
        ready.nominal,
        ranking,
        DiagnosisRuns(
            train=ready.train,
            aside=ready.aside,
            scored=scored,
            split=ready.parts,
            horizon=horizon,
            still=ready.still,
            changes=tuple(changes),
            seed=seed,
            started=started,
        ),
    )


def _onward(progress: Progress) -> Progress:
    """Return what tells of progress, of which the share never falls."""
    most = 0.0

    def told(what: str, share: float) -> None:
        nonlocal most
        most = max(most, share)
        progress(what, most)

    return told


def _since_changes(
    rank: Callable[..., tuple[Prepared, Ranking]],
    recordings: Sequence[Recording],
    held_out: Sequence[Recording],
    known: Sequence[Effect],
    started: float,
    deadline: Deadline,
    say: Progress,
) -> tuple[tuple[Prepared, Ranking], list[Change]]:
    """Return what explains recordings of one and the same robot, and changes of it.

    Args:
        rank: What explains some recordings, as `_ranked`.
        recordings: All but those that are held out.
        held_out: Those.
        known: Effects whose fixed parameters are known.
        started: When the diagnosis began, by the monotonic clock, s.
        deadline: By which all is done; no change is looked for after half of the time until then,
            as what comes after one takes as long as all before it.
        say: Told what is being done and the share of the work behind.
    """
    current, changes, half = rank(recordings), list[Change](), deadline.halfway(started)
    while len(changes) < MOST_CHANGES and not current[1].stopped and not half.passed:
        say("looking for changes", 0.88)
        ready, ranking = current
        aside = () if held_out else ready.aside
        change, kept, rest = changed(ranking, recordings, ready.train, aside, known)
        if change is None:
            # A push in a run that was set aside is fitted, and another run is set aside.
            again = kept is not recordings
            return (rank(kept, of="with a push, ") if again else current), changes
        most = max(LEAST_SIDE, time.monotonic() - started)
        side = functools.partial(rank, deadline=deadline.within(most))
        try:
            proven = _proven(change, kept, rest, ranking, side)
        except DiagnosisError:
            # One side alone moves too little, or too short a time, to be diagnosed.
            break
        if proven is None:
            break
        change, recordings, (ready, ranking) = proven
        current = ready, replace(ranking, stopped=deadline.passed)
        changes.append(change)
    return current, changes


def _proven(
    change: Change,
    kept: Sequence[Recording],
    rest: Sequence[Recording],
    whole: Ranking,
    rank: Callable[..., tuple[Prepared, Ranking]],
) -> tuple[Change, Sequence[Recording], tuple[Prepared, Ranking]] | None:
    """Return a change that both sides of it speak for, recordings of one side, and their ranking.

    Args:
        change: A likely change.
        kept: Recordings of the side of which all else is said.
        rest: The others, none where they are too short.
        whole: What explains both.
        rank: What explains some recordings, as `_ranked`.
    """
    if not (change.stays or rest):
        return None
    side = rank(kept if change.stays else rest, of=ONE_SIDE)
    if change.alters:
        there = bool(rest) and differs(change, (side[1], rank(rest, of=OTHER_SIDE)[1]))
        return (change, kept, side) if there else None
    alone = confirmed(change, side[1])
    if alone and change.stays:
        return change, kept, side
    if not (alone or decided(whole, side[1])):
        if not (kept and rest and explained(side[1])):
            return None
        other = rank(rest if change.stays else kept, of=OTHER_SIDE)
        new = renamed(change, side[1], other[1])
        return None if new is None else (new, kept, side if change.stays else other)
    if change.stays:
        # The law is too weak to be found in those: what else is said is of the others.
        change, kept = replace(change, since=not change.since), rest
    if not kept:
        return None
    side = rank(kept, of=OTHER_SIDE)
    # A law that acts there as well has not changed.
    return None if confirmed(change, side[1]) else (change, kept, side)


def _ranked(
    robot: Robot,
    recordings: Sequence[Recording],
    *,
    held_out: Sequence[Recording],
    whole: Mapping[str, Recording],
    vary: Mapping[str, float] | None,
    known: Sequence[Effect],
    deadline: Deadline,
    say: Progress,
    of: str = "",
) -> tuple[Prepared, Ranking]:
    """Return recordings laid on a grid, and what explains them.

    Args:
        robot: The nominal description.
        recordings: Some recordings or parts of them.
        held_out: Those kept for testing.
        whole: Recordings that were cut, by name.
        vary: Fractions by which the description may be wrong.
        known: Effects whose fixed parameters are known.
        deadline: After which no refit begins.
        say: Told what is being done and the share of the work behind.
        of: What these recordings are, before all that is told.
    """
    first: tuple[Prepared, Ranking] | None = None
    most, when = math.inf, of

    def told(what: str, share: float) -> None:
        say(f"{when}{what}", share)

    while True:
        ready = prepared(robot, recordings, held_out, vary, deadline=deadline, say=told, most=most)
        ready = replace(
            ready, train=in_whole(ready.train, whole), aside=in_whole(ready.aside, whole)
        )
        coarse = functools.partial(by_step, ready.nominal, ready.train)
        told("refitting the description's own parameters", 0.05)
        result = ranked(
            ready.nominal,
            stretches(ready.train, MOST_SECONDS),
            known,
            start=first[1].best if first else None,
            coarse=(lambda runs: False) if first else coarse,
            progress=told,
            deadline=deadline,
        )
        if first and result.stopped:
            # What the budget ended may have found less than the search that went before it.
            return first[0], replace(first[1], stopped=True)
        if first or result.stopped or not coarse(result.best.refit.runs):
            return ready, result
        first, most = (ready, result), 0.5 * ready.nominal.step
        when = f"{of}at half the step, "
