"""From recordings to named, modelled, proven physics: the whole of a diagnosis."""

from __future__ import annotations

import functools
import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import mujoco

from morph.body.robot import Robot
from morph.inference.changed import changed, confirmed, decided, in_whole
from morph.inference.contact import at_stops, touches
from morph.inference.rank import Progress, Ranking, ranked
from morph.inference.refit import refitted
from morph.inference.unmeasured import with_unmeasured
from morph.inference.verdict import DiagnosisRuns, conclude
from morph.model.chain_closure import with_chains
from morph.model.conventions import check_signs, check_units
from morph.model.derived_channels import by_effort, with_followers
from morph.model.diagnosis import Diagnosis
from morph.model.episodes import Episode, longest_step, step_for
from morph.model.finding import Change
from morph.model.hypothesis import Hypothesis
from morph.model.measurement import Measurement
from morph.model.nuisance_parameters import knobs
from morph.model.pieces import all_pieces, stretches
from morph.model.segments import scored_segments
from morph.model.split import Split, split
from morph.model.tracked_links import with_tracked_links
from morph.model.validate_recordings import (
    check_channels,
    check_falls,
    check_motion,
    check_recordings,
    check_settings,
    check_tree,
)
from morph.physics.effect import Effect
from morph.record.distinct import check_distinct, distinct
from morph.record.recording import Recording
from morph.sim.threads import one_thread

GUESSES = 2
"""Times that the motion of joints that were not read is guessed anew."""
IMPACT = 0.002
"""Seconds of the longest step through an impact."""
MOST_CHANGES = 2
"""Most changes that are looked for."""
MOST_SECONDS = 60.0
"""Seconds of training motion that are fitted; of longer recordings an even spread."""


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
    seed: int = 0,
    progress: Progress | None = None,
) -> Diagnosis:
    """Return where a description and recordings part, and what physics was left out.

    Args:
        robot: The nominal description.
        recordings: What the robot did: positions of joints, at least one, of which the others are
            estimated, or poses of links that tell them; the pose of each link that moves freely;
            every actuator's command, or of motors the effort measured at their joint.
        held_out: Recordings to open only after the choice; empty sets a quarter aside.
        horizon: Seconds of the open-loop rollouts that are scored, at least 0.1; None
            for whole episodes.
        vary: Fractions by which the description may be wrong; see `knobs`.
        known: Effects whose fixed parameters are known, such as the edge of a paddle.
        budget: Seconds; when they are spent the best answer so far is returned, marked.
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
        [_completed(by_effort(each, robot), robot) for each in some]
        for some in map(distinct, (recordings, held_out))
    )
    measured = Measurement.of(robot).needed
    for recording in (*recordings, *held_out):
        check_channels(recording, robot, measured)
    check_distinct((*recordings, *held_out))
    say: Progress = progress or (lambda what, share: None)
    deadline = math.inf if budget is None else started + 0.9 * budget
    whole = {recording.name: recording for recording in recordings}
    rank = functools.partial(
        _ranked, robot, held_out=held_out, whole=whole, vary=vary, known=known, deadline=deadline,
        say=say,
    )  # fmt: skip
    half = started + 0.5 * (deadline - started)
    (ready, ranking), changes = _since_changes(rank, recordings, held_out, known, half, say)
    scored = scored_segments(ready.aside, horizon)
    say("opening the held-out runs", 0.9)
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


def _since_changes(
    rank: Callable[[Sequence[Recording]], tuple[_Ready, Ranking]],
    recordings: Sequence[Recording],
    held_out: Sequence[Recording],
    known: Sequence[Effect],
    deadline: float,
    say: Progress,
) -> tuple[tuple[_Ready, Ranking], list[Change]]:
    """Return what explains recordings of one and the same robot, and changes of it.

    Args:
        rank: What explains some recordings.
        recordings: All but those that are held out.
        held_out: Those.
        known: Effects whose fixed parameters are known.
        deadline: Time of the monotonic clock after which no change is looked for: what comes after
            one takes as long as all before it.
        say: Told what is being done and the share of the work behind.
    """
    current, changes = rank(recordings), list[Change]()
    while len(changes) < MOST_CHANGES and not current[1].stopped and time.monotonic() < deadline:
        say("looking for changes", 0.88)
        ready, ranking = current
        aside = () if held_out else ready.aside
        change, kept, rest = changed(ranking, recordings, ready.train, aside, known)
        if change is None:
            # A push in a run that was set aside is fitted, and another run is set aside.
            return (current if kept is recordings else rank(kept)), changes
        if not (change.stays or rest):
            break
        side = rank(kept if change.stays else rest)
        alone = confirmed(change, side[1])
        if not alone and not decided(ranking, side[1]):
            break
        if not (alone and change.stays):
            if change.stays:
                # The law is too weak to be found in those: what else is said is of the others.
                change, kept = replace(change, since=not change.since), rest
            if not kept:
                break
            side = rank(kept)
            if not change.stays and confirmed(change, side[1]):
                # It acts there as well.
                break
        current, recordings = side, kept
        changes.append(change)
    return current, changes


def _ranked(
    robot: Robot,
    recordings: Sequence[Recording],
    *,
    held_out: Sequence[Recording],
    whole: Mapping[str, Recording],
    vary: Mapping[str, float] | None,
    known: Sequence[Effect],
    deadline: float,
    say: Progress,
) -> tuple[_Ready, Ranking]:
    """Return recordings laid on a grid, and what explains them.

    Args:
        robot: The nominal description.
        recordings: Some recordings or parts of them.
        held_out: Those to open only after the choice.
        whole: Recordings that were cut, by name.
        vary: Fractions by which the description may be wrong.
        known: Effects whose fixed parameters are known.
        deadline: Time of the monotonic clock after which no refit begins.
        say: Told what is being done and the share of the work behind.
    """
    ready = _prepared(robot, recordings, held_out, vary, deadline=deadline, say=say)
    ready = replace(ready, train=in_whole(ready.train, whole), aside=in_whole(ready.aside, whole))
    say("refitting the description's own figures", 0.05)
    episodes = stretches(ready.train, MOST_SECONDS)
    return ready, ranked(ready.nominal, episodes, known, progress=say, deadline=deadline)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Ready:
    """Recordings laid on a grid, and the description with its own figures."""

    parts: Split
    train: Sequence[Episode]
    aside: Sequence[Episode]
    nominal: Hypothesis
    still: Sequence[str]
    """Joints that no training run moves."""


def _prepared(
    robot: Robot,
    recordings: Sequence[Recording],
    held_out: Sequence[Recording],
    vary: Mapping[str, float] | None,
    *,
    deadline: float,
    say: Progress,
) -> _Ready:
    """Return recordings that were completed, split, checked and laid on a grid."""
    started, measured = time.monotonic(), Measurement.of(robot).needed
    say("reading motion and noise", 0.02)
    parts = split(recordings, held_out)
    still, every = check_motion(parts.train, measured), (*parts.train, *parts.held_out)
    step = step_for(parts.train, robot)
    train, aside = (all_pieces(part, robot, step) for part in (parts.train, parts.held_out))
    for _ in range(GUESSES if any(each.guess.any() for each in train) else 0):
        if time.monotonic() > started + 0.3 * (deadline - started):
            break
        # What was not read is guessed anew by figures that are refitted to the readings.
        say("estimating joints that were not read", 0.03)
        model = _refitted(Hypothesis(robot=robot, step=step, knobs=knobs(robot, vary)), train)
        parts = replace(
            parts,
            train=tuple(_completed(each, robot, model) for each in parts.train),
            held_out=tuple(_completed(each, robot, model) for each in parts.held_out),
        )
        train, aside = (all_pieces(part, robot, step) for part in (parts.train, parts.held_out))
    touching = touches(robot, train)
    longest = longest_step(robot, train)
    if touching or at_stops(robot, train):
        # What impacts do takes short steps, and is no force of inertia.
        longest = min(longest, IMPACT)
    if longest < step:
        step = step_for(parts.train, robot, longest=longest)
        train, aside = (all_pieces(part, robot, step) for part in (parts.train, parts.held_out))
    if not touching:
        check_falls(train, robot)
        check_units(train, robot)
        check_signs(train, robot)
    held = tuple(name for name in still if name in check_motion(every, measured))
    nominal = Hypothesis(robot=robot, step=step, knobs=knobs(robot, vary), held=held)
    return _Ready(parts=parts, train=train, aside=aside, nominal=nominal, still=still)


def _completed(
    recording: Recording, robot: Robot, model: mujoco.MjModel | None = None
) -> Recording:
    """Return a recording with the positions of joints that were not read.

    They are those of links that were tracked, those at which chains close, or guessed by a model.
    """
    tracked = with_tracked_links(recording, robot)
    if robot.loops:
        tracked = with_chains(tracked, robot)
    return with_followers(with_unmeasured(tracked, robot, model), robot)


def _refitted(nominal: Hypothesis, episodes: Sequence[Episode]) -> mujoco.MjModel:
    """Return a description with its own figures refitted to some runs."""
    result = refitted(nominal, nominal.start, stretches(episodes, MOST_SECONDS))
    return nominal.at(result.point).model
