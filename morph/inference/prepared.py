"""Recordings laid on a grid for a diagnosis, with the description's own parameters."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import mujoco

from morph.body.robot import Robot
from morph.inference.contact import at_stops, touches
from morph.inference.rank import Progress
from morph.inference.refit import refitted
from morph.inference.unmeasured import with_unmeasured
from morph.model.chain_closure import with_chains
from morph.model.conventions import check_signs, check_units
from morph.model.deadline import Deadline
from morph.model.derived_channels import with_followers
from morph.model.episodes import Episode, longest_step, step_for
from morph.model.hypothesis import Hypothesis
from morph.model.joint_rates import with_own_rates
from morph.model.leg_odometry import with_base
from morph.model.measurement import Measurement
from morph.model.nuisance_parameters import knobs
from morph.model.pieces import all_pieces, stretches
from morph.model.split import Split, split
from morph.model.tracked_links import with_tracked_links
from morph.model.validate_recordings import check_falls, check_motion
from morph.record.recording import Recording

GUESSES = 2
"""Times that the motion of joints that were not read is guessed anew."""
IMPACT = 0.002
"""Seconds of the longest step through an impact."""
MOST_SECONDS = 60.0
"""Seconds of training motion that are fitted; of longer recordings an even spread."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Prepared:
    """Recordings laid on a grid, and the description with its own parameters."""

    parts: Split
    """The recordings, and which of them were set aside."""
    train: Sequence[Episode]
    """Pieces of those that are fitted."""
    aside: Sequence[Episode]
    """Pieces of those that were set aside."""
    nominal: Hypothesis
    """The description with its figures that may be wrong, and no effect."""
    still: Sequence[str]
    """Joints that no training run moves."""


def prepared(
    robot: Robot,
    recordings: Sequence[Recording],
    held_out: Sequence[Recording],
    vary: Mapping[str, float] | None,
    *,
    deadline: Deadline,
    say: Progress,
    most: float = math.inf,
) -> Prepared:
    """Return recordings that were completed, split, checked and laid on a grid.

    Args:
        robot: The description.
        recordings: Some recordings or parts of them.
        held_out: Those kept for testing.
        vary: Fractions by which the description may be wrong.
        deadline: By which the diagnosis ends.
        say: Told what is being done and the share of the work behind.
        most: Longest step of the simulation, s.

    Raises:
        DiagnosisError: Nothing moves, or there is nothing to fit or to score.
        RecordingError: Angles are in degrees, signs are flipped, or poses cannot be.
    """
    started, measured = time.monotonic(), Measurement.of(robot).needed
    say("reading motion and noise", 0.02)
    parts = split(recordings, held_out)
    still, every = check_motion(parts.train, measured), (*parts.train, *parts.held_out)
    step = step_for(parts.train, robot)
    train, aside = (all_pieces(part, robot, step) for part in (parts.train, parts.held_out))
    for _ in range(GUESSES if any(each.guess.any() for each in train) else 0):
        if 0.7 * (time.monotonic() - started) > 0.3 * deadline.left:
            break
        # What was not read is guessed anew by figures that are refitted to the readings.
        say("estimating joints that were not read", 0.03)
        model = _refitted(Hypothesis(robot=robot, step=step, knobs=knobs(robot, vary)), train)
        parts = replace(
            parts,
            train=tuple(completed(each, robot, model) for each in parts.train),
            held_out=tuple(completed(each, robot, model) for each in parts.held_out),
        )
        train, aside = (all_pieces(part, robot, step) for part in (parts.train, parts.held_out))
    touching = touches(robot, train)
    longest = min(most, longest_step(robot, train))
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
    return Prepared(parts=parts, train=train, aside=aside, nominal=nominal, still=still)


def completed(recording: Recording, robot: Robot, model: mujoco.MjModel | None = None) -> Recording:
    """Return a recording with the positions of joints that were not read.

    They are those of links that were tracked, those at which chains close, or guessed by a model.
    An inertial sensor and feet tell where a free base is. Velocities stay that a sensor of their
    own read.
    """
    based = with_tracked_links(with_base(recording, robot), robot)
    tracked = with_own_rates(based, robot)
    if robot.loops:
        tracked = with_chains(tracked, robot)
    return with_followers(with_unmeasured(tracked, robot, model), robot)


def _refitted(nominal: Hypothesis, episodes: Sequence[Episode]) -> mujoco.MjModel:
    """Return a description with its own parameters refitted to some runs."""
    result = refitted(nominal, nominal.start, stretches(episodes, MOST_SECONDS))
    return nominal.at(result.point).model
