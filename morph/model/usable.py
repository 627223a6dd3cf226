"""What recordings and settings must be for a diagnosis to start; every refusal is here."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from morph.body.robot import Robot
from morph.errors import DiagnosisError, RecordingError
from morph.record.recording import Channel, Recording

FARTHEST = 1e4
"""rad or m: positions beyond this are no robot's."""
STRONGEST = 1e6
"""Commands beyond this are no actuator's."""
SLOWEST = 0.2
"""Seconds between readings, of which one in a few tells of friction."""
LONGEST_GAP = 60.0
"""Seconds without a reading after which a clock has jumped."""


def check_settings(horizon: float | None, budget: float | None, seed: int) -> None:
    """Refuse settings out of range.

    Raises:
        DiagnosisError: The horizon, the budget or the seed cannot be used.
    """
    if horizon is not None and not (math.isfinite(horizon) and horizon >= 0.1):
        raise DiagnosisError(
            f"a horizon of {horizon} s is out of range",
            where="--horizon",
            fix="give at least 0.1 s, or `full`",
        )
    if budget is not None and not budget > 0.0:
        raise DiagnosisError(
            f"the budget is {budget:g} s", where="--budget", fix="give seconds above zero"
        )
    if seed < 0:
        raise DiagnosisError(f"a seed of {seed} is below 0", where="--seed", fix="give 0 or more")


def check_recordings(train: Sequence[Recording], held_out: Sequence[Recording]) -> None:
    """Refuse recordings that are none, or that cannot be told apart by name.

    Raises:
        DiagnosisError: There is nothing to fit, or two recordings share a name.
    """
    if not train:
        raise DiagnosisError(
            "every recording is held out, none is left to fit"
            if held_out
            else "there is no recording to fit",
            where="morph diagnose",
            fix="give at least one recording of the robot in motion to fit",
        )
    names = [recording.name for recording in (*train, *held_out)]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise DiagnosisError(
            f"several recordings are called {', '.join(twice)}",
            where="morph diagnose",
            fix="give each file or episode a name of its own",
        )


def check_channels(recording: Recording, robot: Robot, joints: Sequence[str]) -> None:
    """Refuse readings and commands that no robot gives, and clocks that jump.

    Raises:
        RecordingError: A channel is missing, or holds what cannot be.
    """
    for joint in joints:
        channel = recording.channel(f"{joint}.position")
        _within(recording, f"{joint}.position", channel, FARTHEST)
        gap = np.diff(channel.time)
        if len(gap) and np.median(gap) > SLOWEST:
            raise RecordingError(
                f"readings come {np.median(gap):.3g} s apart",
                where=f"recording {recording.name}, {joint}.position",
                fix='say the unit of times in recording.toml, as time = { column = "time", unit = '
                f'"ms" }}, or record every {SLOWEST} s or faster',
            )
        if len(gap) and gap.max() > LONGEST_GAP:
            raise RecordingError(
                f"the clock jumps by {gap.max():.3g} s after sample {int(gap.argmax())}",
                where=f"recording {recording.name}, {joint}.position",
                fix="cut the recording there and give the pieces as episodes",
            )
    for actuator in robot.actuators:
        name = f"{actuator.name}.command"
        if name not in recording.channels:
            raise RecordingError(
                f"there is no channel {name!r}; there are {', '.join(sorted(recording.channels))}",
                where=f"recording {recording.name}",
                fix="bind it in recording.toml; for an actuator that was off, add a column of "
                "zeros, or take the actuator out of the description or its card",
            )
        _within(recording, name, recording.channel(name), STRONGEST)


def check_motion(recordings: Sequence[Recording], joints: Sequence[str]) -> tuple[str, ...]:
    """Return the joints that no recording moves.

    Raises:
        DiagnosisError: Nothing moves at all.
    """
    still = tuple(
        joint
        for joint in joints
        if not any(np.ptp(recording[f"{joint}.position"]) > 0.0 for recording in recordings)
    )
    if len(still) == len(joints):
        raise DiagnosisError(
            "no joint moves in any recording that is to be fitted",
            where=", ".join(recording.name for recording in recordings),
            fix="record the robot in motion, every joint at least some of the time",
        )
    return still


def _within(recording: Recording, name: str, channel: Channel, most: float) -> None:
    if not np.isfinite(channel.value).all() or not np.isfinite(channel.time).all():
        raise RecordingError(
            "it holds NaN or infinity",
            where=f"recording {recording.name}, {name}",
            fix="read it with morph.record.load, which counts and drops single bad samples",
        )
    worst = int(np.argmax(np.abs(channel.value)))
    if abs(channel.value[worst]) > most:
        raise RecordingError(
            f"sample {worst} reads {channel.value[worst]:.3g}, beyond {most:g}",
            where=f"recording {recording.name}, {name}",
            fix="check the unit and the scale of this column",
        )
