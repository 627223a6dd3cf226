"""Joints that follow others: their motion is that of their leaders."""

from __future__ import annotations

from dataclasses import replace

from morph.body.follow import leaders
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.record.recording import Note, Recording


def with_followers(recording: Recording, robot: Robot) -> Recording:
    """Return a recording in which joints that follow others read what their leaders make of them.

    They add nothing to what the leaders' readings tell; readings of their own are noted. A leader
    without readings is left for others to refuse.
    """
    if all(joint.mimic is None for joint in robot.joints):
        return recording
    model, channels, notes = spec_of(robot).compile(), dict(recording.channels), []
    for joint, (leader, ratio, offset) in leaders(model).items():
        name, source = (f"{model.joint(each).name}.position" for each in (joint, leader))
        if source not in recording.channels:
            continue
        if name in channels:
            notes.append(
                Note(
                    what=f"{name} is not used: the joint follows {model.joint(leader).name}",
                    where=f"recording {recording.name}",
                )
            )
        read = recording.channels[source]
        channels[name] = replace(read, value=ratio * read.value + offset)
    return replace(recording, channels=channels, notes=(*recording.notes, *notes))
