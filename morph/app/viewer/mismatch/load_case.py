"""From what was given to a case: recordings and a diagnosis, checked before they are shown."""

from __future__ import annotations

from pathlib import Path

from morph.app.viewer.mismatch.case import MismatchCase
from morph.app.viewer.mismatch.diagnosed import command_of, load_diagnosed
from morph.app.viewer.mismatch.poses import untold
from morph.app.viewer.view_request import ViewRequest
from morph.body.robot import Robot
from morph.errors import ViewError
from morph.physics.worlds import world
from morph.record.distinct import distinct
from morph.record.load import load_recordings
from morph.record.quantities import pose_channels
from morph.record.recording import Recording


def load_case(given: ViewRequest) -> MismatchCase:
    """Return what was given, checked.

    Raises:
        ViewError: There is no recording, or one that tells nothing of the robot, or the
            diagnosis is of another robot.
        MorphError: A recording or a diagnosis cannot be used.
    """
    robot = given.robots[0]
    if not given.recordings:
        raise _no_recordings(given.diagnosis)
    recordings = distinct(
        each
        for path in given.recordings
        for each in load_recordings(path, robot=robot, root=given.root)
    )
    _check(recordings, robot)
    diagnosed = None if given.diagnosis is None else load_diagnosed(given.diagnosis, robot)
    around = () if given.world is None else world(given.world, robot).effects
    return MismatchCase(robot, recordings, diagnosed, around)


def _check(recordings: tuple[Recording, ...], robot: Robot) -> None:
    names = [recording.name for recording in recordings]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ViewError(
            f"several recordings are called {', '.join(twice)}",
            where="--recording",
            fix="give each file or episode a name of its own",
        )
    for recording in recordings:
        wanted = [name for joint in robot.joints for name in pose_channels(joint)]
        if len(untold(recording, robot)) == len(robot.joints):
            raise ViewError(
                f"it tells of no joint of {robot.name} where it is; its channels are "
                f"{', '.join(sorted(recording.channels))}",
                where=", ".join(map(str, recording.sources)) or f"recording {recording.name}",
                fix=f"give a recording with {', '.join(wanted[:8]) or 'a joint that moves'}",
            )


def _no_recordings(diagnosis: Path | None) -> ViewError:
    command = "" if diagnosis is None else command_of(diagnosis)
    return ViewError(
        "a diagnosis does not hold the recordings that it was made of"
        + (f"; it was made by: {command}" if command else ""),
        where=str(diagnosis),
        fix="give them too, by --recording FILE (and --root DIR, if the diagnosis had one)",
    )
