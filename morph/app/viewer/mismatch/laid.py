"""A recording laid out to be simulated: what it lacks is filled in, and told."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.record.recording import Channel, Recording

WINDOW = 20.0
"""Seconds of a long recording that are shown at one time."""
SPARE = 0.25
"""A last window shorter than this part of one is joined to the one before."""


def windows(seconds: float) -> tuple[tuple[float, float], ...]:
    """Return from and to of each window of a recording, s; together they are all of it."""
    count = max(1, int(np.ceil(seconds / WINDOW - SPARE)))
    edges = [WINDOW * number for number in range(count)] + [seconds]
    return tuple(itertools.pairwise(edges))


def with_commands(recording: Recording, robot: Robot) -> tuple[Recording, tuple[str, ...]]:
    """Return a recording that tells every actuator something, and what was put in for it.

    A motor that has no command but a measured effort at its joint is told that effort; all
    others are told 0, as `morph simulate` does where nothing is said.
    """
    channels, notes, idle = dict(recording.channels), [], []
    for actuator in robot.actuators:
        name, effort = f"{actuator.name}.command", f"{actuator.joint}.effort"
        if name in channels:
            continue
        if actuator.kind == "motor" and effort in channels:
            channels[name] = replace(channels[effort], hold=True)
            notes.append(
                f"{actuator.name} has no recorded command: its joint's measured effort is taken "
                "for it."
            )
        else:
            span: Array = np.array([recording.start, recording.end])
            channels[name] = Channel(time=span, value=np.zeros(2), hold=True)
            idle.append(actuator.name)
    if idle:
        notes.append(f"No command was recorded of {', '.join(idle)}: the simulation is told 0.")
    return replace(recording, channels=channels), tuple(notes)
