"""Where, when and how much a description and recordings part; nothing is fitted, nothing named."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import ClassVar

import numpy as np

from morph.arrays import JSON, Array
from morph.body.robot import Robot
from morph.files import write_whole
from morph.model.conventions import check_units
from morph.model.derived_channels import by_effort, told_zero
from morph.model.episodes import Episode, step_for
from morph.model.hypothesis import Hypothesis
from morph.model.leg_odometry import with_base
from morph.model.measurement import Measurement
from morph.model.motion import needed
from morph.model.pieces import all_pieces
from morph.model.score import rmse, rollouts
from morph.model.segments import Segments, scored_segments, smoothed_noise
from morph.model.tracked_links import with_tracked_links
from morph.model.validate_recordings import check_channels, check_recordings
from morph.physics.effect import Effect
from morph.record.recording import Recording
from morph.tabular import Tabular

SCHEMA = "morph.comparison/1"

PARTED, LITTLE = 2.0, 0.01
"""Error over a channel's noise and over what errors of starts make, and over its motion, above all
of which description and recordings part: rollouts start from smoothed states."""


@dataclass(frozen=True, kw_only=True)
class WorstRollout:
    """A rollout of one recording."""

    recording: str
    """The recording's name."""
    start: float
    """From, s since the recording began."""
    end: float
    """To, s."""
    error: float
    """Root mean square error of a channel in it."""


@dataclass(frozen=True, kw_only=True)
class ChannelError:
    """How far rollouts of a description are from one channel."""

    channel: str
    """Its name."""
    unit: str
    """Of its values, rad or m."""
    error: float
    """Root mean square error over all rollouts."""
    noise: float
    """Standard deviation of the readings' noise."""
    motion: float
    """Root mean square of how far it moves from where rollouts start."""
    by_starts: float
    """Root mean square of how far errors of the smoothed starts alone move rollouts: they grow in
    an arm that stands upright, and in contact."""
    missing: float
    """Root mean square of the generalized force that the motion needs beside the model's, N m or N;
    motion is looked at 40 times a second and smoothed."""
    worst: WorstRollout
    """Where the error is greatest."""

    @property
    def parts(self) -> bool:
        """Whether the error is more than noise and smoothed starts make."""
        chance = max(self.noise, self.by_starts)
        return self.error > max(PARTED * chance, LITTLE * self.motion)


@dataclass(frozen=True, kw_only=True, repr=False)
class RolloutComparison(Tabular):
    """A description held against recordings."""

    axes: ClassVar[tuple[str, ...]] = ("channel", "error", "noise")

    robot: str
    """The robot's name."""
    sha256: str
    """Of its description and card."""
    recordings: tuple[str, ...]
    """Their names."""
    seconds: float
    """How long they last together."""
    rollouts: int
    """How many rollouts were compared."""
    horizon: float | None
    """Seconds of each, from states as recorded; None of whole recordings."""
    channels: tuple[ChannelError, ...]
    """Each channel, the farthest off in units of its noise first."""
    notes: tuple[str, ...]
    """What was dropped, repaired or put in, in words."""

    def __repr__(self) -> str:
        parting = sum(each.parts for each in self.channels)
        return f"RolloutComparison({self.robot}: {parting} of {len(self.channels)} channels part)"

    def rows(self) -> list[JSON]:
        """Return one row a channel, the farthest off first; errors in its unit."""
        names = ("channel", "unit", "error", "noise", "motion", "missing", "parts")
        return [{name: getattr(each, name) for name in names} for each in self.channels]

    def save(self, path: str | Path) -> None:
        """Write it as JSON, by the schema morph.comparison/1.

        Raises:
            OutputError: The file cannot be written.
        """
        write_whole(Path(path), json.dumps(self.as_json(), indent=2) + "\n")

    def as_json(self) -> JSON:
        """Return it by the schema morph.comparison/1."""
        channels = [{**asdict(each), "parts": each.parts} for each in self.channels]
        return {"schema": SCHEMA, **asdict(self), "channels": channels}


def compare(
    robot: Robot,
    recordings: Sequence[Recording],
    *,
    effects: Sequence[Effect] = (),
    horizon: float | None = 1.0,
) -> RolloutComparison:
    """Return where, when and how much a description and recordings part.

    Args:
        robot: The description.
        recordings: What the robot did, at least one: every joint's position and the pose of each
            link that moves freely. Of actuators without a command, efforts measured at the joints
            of motors stand for it; others are told zero.
        effects: What acts on it beside the description, such as water.
        horizon: Seconds of the rollouts, at least 0.1; None for whole recordings, as where
            none is as long.

    Raises:
        RecordingError: A channel is missing or holds what cannot be.
        DiagnosisError: A recording is shorter than half a second, too few readings were taken, or
            angles are in degrees.
    """
    recordings = [
        with_tracked_links(with_base(told_zero(by_effort(each, robot), robot), robot), robot)
        for each in recordings
    ]
    check_recordings(recordings, ())
    for recording in recordings:
        check_channels(recording, robot, Measurement.of(robot).needed)
    step = step_for(recordings, robot)
    laid = all_pieces(recordings, robot, step)
    if all(joint.kind in ("hinge", "slide") for joint in robot.joints) and not robot.loops:
        # Of what floor and loops do the forces are not known before a simulation.
        check_units(laid, robot)
    if horizon is not None and max(len(each.command) for each in laid) * step < horizon:
        horizon = None
    segments = scored_segments(laid, horizon)
    used = {segments.episodes[at].recording.name for at in segments.episode.tolist()}
    short = [each.name for each in recordings if each.name not in used]
    model = Hypothesis(robot=robot, step=step, knobs=(), effects=tuple(effects))
    shaken = _noisy_starts(segments)
    both = dict.fromkeys(("described", "shaken"), (model, model.start))
    predicted, other = rollouts(both, segments, {"shaken": shaken}).values()
    missing = np.concatenate(
        [needed(model, model.start, each, suspects=False).missing for each in laid]
    )
    errors = rmse(segments, predicted)
    by_starts = rmse(replace(segments, reading=predicted), other)
    squared = np.where(segments.valid, (segments.reading - predicted) ** 2, 0.0)
    space, count = segments.measurement.coordinates, segments.reading.shape[1]
    rested = np.repeat(segments.start[:, None, : space.positions], count, axis=1)
    motions = rmse(segments, segments.measurement.read(rested, segments.attitude))
    by_rollout = np.sqrt(squared.sum(axis=1) / segments.counts)
    channels = []
    for at, channel in enumerate(segments.measurement.channels):
        row = int(np.argmax(by_rollout[:, at]))
        channels.append(
            ChannelError(
                channel=channel,
                unit=segments.measurement.units[at],
                error=float(errors[at]),
                noise=float(segments.noise[at]),
                motion=float(motions[at]),
                by_starts=float(by_starts[at]),
                missing=float(np.sqrt(np.mean(missing[:, at] ** 2))),
                worst=_moment(segments, row, float(by_rollout[row, at])),
            )
        )
    return RolloutComparison(
        robot=robot.name,
        sha256=robot.sha256,
        recordings=tuple(recording.name for recording in recordings),
        seconds=sum(_lasted(each) for each in laid),
        rollouts=len(segments),
        horizon=horizon,
        channels=tuple(sorted(channels, key=lambda each: -each.error / each.noise)),
        notes=(
            *(f"{n.where}: {n.what}" for recording in recordings for n in recording.notes),
            *(f"recording {name}: too short for a rollout, left out" for name in short),
            *(["missing forces hold those of the closed chains"] if robot.loops else ()),
        ),
    )


def _noisy_starts(segments: Segments) -> Array:
    """Return starts with as much noise more as smoothing has let through, (segments, nq + nv)."""
    place = smoothed_noise(segments.episodes[0], segments.noise) + segments.guess
    # White below the cutoff: its derivative's variance is (2 pi f)^2 / 3 of its own.
    rate = 2.0 * np.pi / math.sqrt(3.0) * segments.episodes[0].state_cutoff * place
    chance = np.random.default_rng(0).standard_normal((len(segments), 2 * len(place)))
    return segments.moved(segments.start, chance * np.concatenate([place, rate]))


def _moment(segments: Segments, row: int, error: float) -> WorstRollout:
    whole = segments.episodes[int(segments.episode[row])]
    zero = whole.begin
    start, end = segments.seconds(row)
    name = whole.recording.name
    return WorstRollout(recording=name, start=zero + start, end=zero + end, error=error)


def _lasted(each: Episode) -> float:
    return float(each.time[-1])
