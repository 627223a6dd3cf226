"""From whatever a user names as a recording to recordings that are fit to use."""

from __future__ import annotations

from pathlib import Path

from morph.body.robot import Robot
from morph.errors import RecordingError
from morph.record.bind import bind
from morph.record.binding import Binding, load_binding
from morph.record.canonical import read_canonical
from morph.record.distinct import check_distinct as check_distinct
from morph.record.distinct import distinct
from morph.record.quantities import check_part, parse_channel
from morph.record.read.any import ENDINGS, readable
from morph.record.read.rosbag import is_bag_folder
from morph.record.recording import Recording

BINDING = "recording.toml"
"""The binding that is looked for in a folder."""


def load_recordings(
    path: str | Path, *, robot: Robot | None = None, root: Path | None = None
) -> tuple[Recording, ...]:
    """Return every recording that a path stands for, less copies, of which there are notes.

    Args:
        path: A file or ROS 2 bag with canonical names, a binding (`.toml`), a folder
            with a `recording.toml`, or a folder of canonical files and bags, taken
            in order of name.
        robot: Whose parts every channel must name; None leaves them unchecked.
        root: Where a binding's files lie; overrides the binding's own `root`.

    Raises:
        RecordingError: A file, a column or a sample of it cannot be used.
    """
    path = Path(path)
    try:
        recordings = _recordings(path, root, robot)
        if robot is not None:
            for recording in recordings:
                _check_parts(recording, robot)
    except RecordingError as error:
        if path.is_file() and path.suffix != ".toml" and (path.parent / BINDING).is_file():
            what = f"give {path.parent} in its place: the {BINDING} there says what columns are"
            raise RecordingError(error.what, where=error.where, fix=what) from error
        raise
    except OSError as error:
        raise RecordingError(
            f"the recording cannot be read: {error.strerror or error}",
            where=str(path),
            fix="check the path and that it may be read",
        ) from error
    return distinct(recordings)


def _recordings(path: Path, root: Path | None, robot: Robot | None) -> tuple[Recording, ...]:
    if path.is_dir() and (path / BINDING).is_file():
        path = path / BINDING
    if path.suffix == ".toml":
        binding = load_binding(path, root=root)
        if robot is not None:
            _check_units(binding, robot)
        return tuple(bind(episode, binding) for episode in binding.episodes)
    if not path.is_dir() or is_bag_folder(path):
        return read_canonical(path)
    files = sorted(
        one for one in path.iterdir() if not one.name.startswith(".") and _is_recording(one)
    )
    if not files:
        raise RecordingError(
            f"the folder has no {BINDING}, no bag, and no file that ends in {', '.join(ENDINGS)}",
            where=str(path),
            fix="name a folder with recordings, a recording, or a binding",
        )
    return tuple(recording for file in files for recording in read_canonical(file))


def _is_recording(path: Path) -> bool:
    return readable(path) and (path.is_file() or is_bag_folder(path))


def _check_units(binding: Binding, robot: Robot) -> None:
    """Refuse commands of joints' actuators in units of something else.

    Raises:
        RecordingError: A motor's command is a current, a servo's an effort or the like.
    """
    joints = {joint.name: joint for joint in robot.joints}
    for actuator in robot.actuators:
        column = binding.columns.get(f"{actuator.name}.command")
        if column is None or actuator.joint is None or column.dimension in {"", "1"}:
            continue
        servo = actuator.kind == "position"
        wanted = joints[actuator.joint].unit if servo else actuator.effort_unit
        if column.dimension != wanted:
            raise RecordingError(
                f"{actuator.name} is commanded in {wanted}, and this unit measures "
                f"{column.dimension}",
                where=column.where,
                fix=f'give unit = "{wanted}", with a scale that makes it so, such as torque '
                "constant times gear ratio; or describe a servo in the robot's card",
            )


def _check_parts(recording: Recording, robot: Robot) -> None:
    where = ", ".join(map(str, recording.sources)) or f"recording {recording.name}"
    for name in recording.channels:
        check_part(parse_channel(name, where=where), name, robot, where=where)
