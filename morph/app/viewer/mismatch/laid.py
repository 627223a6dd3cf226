"""A recording laid out to be simulated: what it lacks is filled in, and told."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np

from morph.arrays import Array
from morph.body.robot import Actuator, Robot
from morph.model.episodes import Episode
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


def part_of(episode: Episode, begin: float, end: float) -> Episode:
    """Return a window of an episode, its time from 0 on; the whole of it is left as it is."""
    last = float(episode.time[-1])
    if begin <= 0.0 and end >= last:
        return episode
    first, until = round(begin / episode.step), round(end / episode.step)
    zero = first * episode.step
    inside = (episode.time >= zero) & (episode.time <= end)
    return replace(
        episode,
        command=episode.command[first:until],
        time=episode.time[inside] - zero,
        reading=episode.reading[inside],
        state=episode.state[inside],
        position=episode.position[inside],
        velocity=episode.velocity[inside],
        acceleration=episode.acceleration[inside],
    )


def with_commands(recording: Recording, robot: Robot) -> tuple[Recording, tuple[str, ...]]:
    """Return a recording that tells every actuator something, and what was put in for it.

    A motor that has no command but a measured effort at its joint is told that effort; any
    other is told nothing, which is 0, or where the joint is, for a servo.
    """
    channels, notes = dict(recording.channels), []
    for actuator in robot.actuators:
        name = f"{actuator.name}.command"
        if name in channels:
            continue
        channel, why = _instead(recording, actuator)
        channels[name] = channel
        notes.append(f"{actuator.name} has no recorded command: {why}.")
    return replace(recording, channels=channels), tuple(notes)


def _instead(recording: Recording, actuator: Actuator) -> tuple[Channel, str]:
    of_joint = {
        "motor": (f"{actuator.joint}.effort", "its joint's measured effort is taken for it"),
        "position": (f"{actuator.joint}.position", "its joint's measured position is taken for it"),
    }
    name, why = of_joint.get(actuator.kind, ("", ""))
    if name in recording.channels:
        return replace(recording.channels[name], hold=True), why
    time: Array = np.array([recording.start, recording.end])
    return Channel(time=time, value=np.zeros(2), hold=True), "the simulation holds it at 0"
