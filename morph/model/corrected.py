"""The corrected model, and what must be known to trust or repeat it."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import version
from typing import Any

import morph
from morph.arrays import JSON, Array
from morph.body.fulltext import fulltext
from morph.body.robot import Robot
from morph.model.episodes import SHORTEST, Episode, fills
from morph.model.hypothesis import Hypothesis
from morph.model.pieces import SHORTEST_PIECE, gaps
from morph.physics.apply import apply
from morph.physics.effect import Effect
from morph.record.recording import Recording
from morph.record.spikes import spikes

UNREAD = {"acceleration", "linear_velocity", "angular_velocity", "gyro", "accelerometer", "force"}
"""Quantities of a robot's motion that a diagnosis does not read."""


def corrected(hypothesis: Hypothesis, point: Array) -> tuple[tuple[Effect, ...], str]:
    """Return the effects that MuJoCo cannot hold, and the description with all others."""
    return split(hypothesis.spec_at(point), hypothesis.effects_at(point))


def split(spec: Any, effects: Sequence[Effect]) -> tuple[tuple[Effect, ...], str]:
    """Return the effects that MuJoCo cannot hold, and a description with all others.

    Args:
        spec: The description as a `mujoco.MjSpec`; it is edited.
        effects: What acts on it.
    """
    beside = tuple(effect for effect in effects if effect.outside and not effect.passing)
    apply(spec, (effect for effect in effects if not effect.outside))
    spec.compile()
    return beside, fulltext(spec)


def data(recordings: Sequence[Recording], *, fitted: int, scored: int) -> JSON:
    """Return what was read and what was dropped or repaired, counted.

    Args:
        recordings: All that were read.
        fitted: Rollouts by which models were chosen.
        scored: Held-out rollouts.
    """
    notes = [note for recording in recordings for note in recording.notes]
    return {
        "samples": sum(recording.samples for recording in recordings),
        "dropped": sum(note.dropped for note in notes),
        "repaired": sum(note.repaired for note in notes),
        # Two identical episodes are refused before any work, so none can be left here.
        "duplicates": [],
        "rollouts_fitted": fitted,
        "rollouts_scored": scored,
    }


def notes(
    recordings: Sequence[Recording], episodes: Sequence[Episode], still: Sequence[str]
) -> tuple[str, ...]:
    """Return what was dropped, repaired or looks odd, in words.

    Args:
        recordings: All that were read.
        episodes: Their pieces between gaps, those that are long enough.
        still: Joints that no training run moves.
    """
    noted: dict[str, list[str]] = {}
    for note in (note for each in recordings for note in each.notes):
        noted.setdefault(note.what, []).append(note.where)
    lines = [f"{', '.join(dict.fromkeys(where))}: {what}" for what, where in noted.items()]
    lines += [
        f"Joint {joint} does not move in any run that was fitted beyond its noise: it is held, or "
        "its encoder is stuck, and then forces at the other joints are wrong."
        for joint in still
    ]
    given = dict.fromkeys(name for each in recordings for name in each.channels)
    if rated := [name for name in given if name.endswith(".velocity")]:
        lines.append(f"Sensors of velocity are read too: {', '.join(rated)}.")
    if unread := [name for name in given if UNREAD & set(name.split("."))]:
        lines.append(f"Recorded, and not read by a diagnosis: {', '.join(unread)}.")
    # An episode may be of the whole recording of which another part was cut.
    used = {episode.recording.name for episode in episodes}
    for recording in recordings:
        if recording.name not in used:
            lines.append(
                f"{recording.name}: left out; an episode takes {SHORTEST:g} s, and a piece between "
                f"gaps {SHORTEST_PIECE:g} s"
            )
        positions = {n: c for n, c in recording.channels.items() if n.endswith(".position")}
        for name, channel in positions.items():
            if count := int(spikes(channel).sum()):
                lines.append(
                    f"{recording.name}: {count} of {len(channel.time)} readings of {name} jump out "
                    "of its motion and back; they are left out"
                )
        holes = {
            gap for channel in positions.values() for gap in gaps(channel.time - recording.start)
        }
        lines += [
            f"{recording.name}: no reading for {end - begin:.3g} s after {begin:.3g} s"
            for begin, end in sorted(holes)
        ]
    return (*lines, *(f"{e.name}: {what}" for e in episodes for what in fills(e)))


def provenance(robot: Robot, recordings: Sequence[Recording]) -> dict[str, Any]:
    """Return versions and hashes."""
    return {
        "morph": morph.__version__,
        "mujoco": version("mujoco"),
        "robot_sha256": robot.sha256,
        "recordings_sha256": {recording.name: recording.sha256 for recording in recordings},
    }
