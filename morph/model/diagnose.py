"""From recordings to named, modelled, proven physics: the whole of a diagnosis."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence

from morph.body.robot import Robot
from morph.model.conclude import standings
from morph.model.diagnosis import Diagnosis
from morph.model.episodes import Episode, episode, moving_joints, step_for, stretches
from morph.model.evidence import Evidence
from morph.model.fit import fit, measure
from morph.model.hypothesis import Hypothesis
from morph.model.knobs import knobs
from morph.model.search import Contender, Progress, Search
from morph.model.segments import cut, scored_segments
from morph.model.shooting import predict
from morph.model.split import split
from morph.model.usable import check_channels, check_motion, check_recordings, check_settings
from morph.model.verdict import conclude
from morph.record.distinct import check_distinct
from morph.record.recording import Recording

FIT_HORIZON = 1.0
"""Seconds of the rollouts that are fitted: friction hides in shorter ones."""
MOST_SEGMENTS = 48
"""Training rollouts; of longer recordings an even spread is fitted."""
MOST_SCREENED = 80.0
"""Seconds of training motion that screening looks at; of more, an even spread."""


def diagnose(
    robot: Robot,
    recordings: Sequence[Recording],
    *,
    held_out: Sequence[Recording] = (),
    horizon: float | None = 1.0,
    vary: Mapping[str, float] | None = None,
    budget: float | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> Diagnosis:
    """Return where a description and recordings part, and what physics was left out.

    Args:
        robot: The nominal description.
        recordings: What the robot did: every joint's position, every actuator's command.
        held_out: Recordings to open only after the choice; empty sets a quarter aside.
        horizon: Seconds of the open-loop rollouts that are scored, at least 0.1; None
            for whole episodes.
        vary: Fractions by which the description may be wrong; see `knobs`.
        budget: Seconds; when they are spent the best answer so far is returned, marked.
        seed: Of every draw.
        progress: Told what is being done and the share of the work behind.

    Raises:
        DiagnosisError: Nothing to fit or to score, or a setting out of range.
        RecordingError: A channel is missing, or two recordings are the same.
    """
    started = time.monotonic()
    check_settings(horizon, budget, seed)
    _check(robot, recordings, held_out)
    say: Progress = progress or (lambda what, share: None)
    say("reading motion and noise", 0.02)
    parts = split(recordings, held_out)
    still = check_motion(parts.train, moving_joints(robot))
    step = step_for(parts.train, robot)
    train = [episode(recording, robot, step) for recording in parts.train]
    aside = [episode(recording, robot, step) for recording in parts.held_out]
    scored = scored_segments(aside, horizon)
    nominal = Hypothesis(robot=robot, step=step, knobs=knobs(robot, vary))
    fitted_horizon = min(FIT_HORIZON, 0.5 * min(len(e.command) for e in train) * step)
    search = Search(
        segments=cut(train, fitted_horizon, most=MOST_SEGMENTS),
        episodes=stretches(train, MOST_SCREENED),
        progress=say,
        deadline=math.inf if budget is None else started + 0.8 * budget,
    )
    say("refitting the description's own figures", 0.08)
    refitted = search.refit(nominal)
    best = search.run(refitted)
    best, stands = standings(search, best, seed)
    say("fitting the corrected model at the horizon that is scored", 0.9)
    longer = _at_horizon(search, train, horizon, refitted, best)
    say("opening the held-out runs", 0.95)
    return conclude(
        Evidence(
            robot=robot,
            nominal=nominal,
            searched=(refitted, best),
            refitted=longer[0],
            best=longer[1],
            stands=stands,
            search=search,
            train=train,
            aside=aside,
            scored=scored,
            split=parts,
            horizon=horizon,
            still=still,
            seed=seed,
            started=started,
        )
    )


def _check(robot: Robot, train: Sequence[Recording], held_out: Sequence[Recording]) -> None:
    """Refuse what cannot be diagnosed before any work is done."""
    check_recordings(train, held_out)
    joints = moving_joints(robot)
    for recording in (*train, *held_out):
        check_channels(recording, robot, joints)
    check_distinct((*train, *held_out))


def _at_horizon(
    search: Search,
    train: list[Episode],
    horizon: float | None,
    refitted: Contender,
    best: Contender,
) -> tuple[Contender, Contender]:
    """Return both models with their figures fitted to longer rollouts, if those are scored.

    Slow drifts show only there. Only figures move, never the choice of effects. Whole
    episodes may diverge, so rollouts are at most three times those of the search.
    """
    fitted = search.segments.steps * search.segments.step
    if search.out_of_time() or (horizon is not None and horizon <= 1.5 * fitted):
        return refitted, best
    wanted = 3.0 * fitted if horizon is None else min(horizon, 3.0 * fitted)
    longest = min(len(e.command) for e in train) * search.segments.step
    longer = cut(train, min(wanted, longest), most=MOST_SEGMENTS)
    moved = []
    for model in (refitted, best):
        found = model.fit
        read = predict(found.hypothesis, longer, [found.point], [longer.start])[0]
        again = fit(
            found.hypothesis, longer, *measure(longer, read), point=found.point, iterations=3
        )
        moved.append(Contender(fit=again, losses=model.losses))
    return moved[0], moved[1]
