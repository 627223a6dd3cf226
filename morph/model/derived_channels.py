"""Channels that the description implies: commands by effort, and mimic joints."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np

from morph.arrays import Array
from morph.body.follow import leaders
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.record.noise import FEWEST, noise
from morph.record.recording import Channel, Note, Recording


def by_effort(recording: Recording, robot: Robot) -> Recording:
    """Return a recording in which measured efforts stand for commands of motors that lack them.

    Args:
        recording: What was recorded; each stand-in is noted.
        robot: Its robot. An effort at a joint is a command times the motor's gear and gain; each
            is held from midway after the reading before to midway before the next. It says nothing
            of two motors at one joint.
    """
    channels, notes = dict(recording.channels), []
    motors = Counter(actuator.joint for actuator in robot.actuators)
    lacking = [
        (actuator, f"{actuator.name}.command", f"{actuator.joint}.effort")
        for actuator in robot.actuators
        if f"{actuator.name}.command" not in channels
        and actuator.kind == "motor"
        and actuator.joint
        and motors[actuator.joint] == 1
    ]
    lacking = [each for each in lacking if each[2] in channels]
    if not lacking:
        return recording
    model = spec_of(robot).compile()
    for actuator, command, effort in lacking:
        motor = model.actuator(actuator.name)
        measured = channels[effort]
        value = measured.value / float(motor.gear[0] * motor.gainprm[0])
        error = noise(measured.time, value) if len(value) >= FEWEST else None
        # A reading stands for the time about it: held until the next it would come half as late.
        since = np.concatenate([measured.time[:1], 0.5 * (measured.time[1:] + measured.time[:-1])])
        channels[command] = replace(measured, time=since, value=value, hold=True, noise=error)
        notes.append(
            Note(
                what=f"{actuator.name} has no recorded command: the effort measured at its joint "
                "is taken for it",
                where=f"recording {recording.name}",
            )
        )
    return replace(recording, channels=channels, notes=(*recording.notes, *notes))


def told_zero(recording: Recording, robot: Robot) -> Recording:
    """Return a recording in which actuators without a command are told zero.

    That is what `morph simulate` does where nothing is said; it is noted.
    """
    given = recording.channels
    names = [each.name for each in robot.actuators if f"{each.name}.command" not in given]
    if not names:
        return recording
    span: Array = np.array([recording.start, recording.end])
    zero = Channel(time=span, value=np.zeros(2), hold=True)
    note = Note(
        what=f"no command was recorded of {', '.join(names)}: the simulation is told 0",
        where=f"recording {recording.name}",
    )
    channels = {**given, **{f"{name}.command": zero for name in names}}
    return replace(recording, channels=channels, notes=(*recording.notes, note))


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
        if name in channels and channels[name].guess is None:
            notes.append(
                Note(
                    what=f"{name} is not used: the joint follows {model.joint(leader).name}",
                    where=f"recording {recording.name}",
                )
            )
        read = recording.channels[source]
        guess = abs(ratio) * (read.guess or 0.0)
        channels[name] = replace(read, value=ratio * read.value + offset, guess=guess)
    return replace(recording, channels=channels, notes=(*recording.notes, *notes))
