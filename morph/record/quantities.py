"""What a channel's name means: `<part>.<quantity>[.<axis>]`, and which part it concerns."""

from __future__ import annotations

from dataclasses import dataclass

from morph.body.robot import Joint, Robot
from morph.errors import RecordingError
from morph.nearest import nearest

XYZ = ("x", "y", "z")
WXYZ = ("w", "x", "y", "z")
TURNS = ("orientation", "angular_velocity")
"""Quantities of a link that a ball joint has too, relative to the link that carries it."""


@dataclass(frozen=True, kw_only=True)
class ChannelQuantity:
    """One thing that a channel can hold."""

    name: str
    """As it stands in a channel's name."""
    part: str
    """What it belongs to: `joint`, `actuator`, `link` or `site`."""
    dimensions: tuple[str, ...]
    """The dimensions that its unit may have; empty where it is the part's own."""
    axes: tuple[str, ...] = ()
    """The axes that a channel of it must name; empty for a scalar."""


QUANTITIES = (
    ChannelQuantity(name="position", part="joint", dimensions=("rad", "m")),
    ChannelQuantity(name="velocity", part="joint", dimensions=("rad/s", "m/s")),
    ChannelQuantity(name="acceleration", part="joint", dimensions=("rad/s2", "m/s2")),
    ChannelQuantity(name="effort", part="joint", dimensions=("N m", "N")),
    ChannelQuantity(name="command", part="actuator", dimensions=()),
    ChannelQuantity(name="current", part="actuator", dimensions=("A",)),
    ChannelQuantity(name="voltage", part="actuator", dimensions=("V",)),
    ChannelQuantity(name="temperature", part="actuator", dimensions=("degC",)),
    ChannelQuantity(name="position", part="link", dimensions=("m",), axes=XYZ),
    ChannelQuantity(name="orientation", part="link", dimensions=("1",), axes=WXYZ),
    ChannelQuantity(name="linear_velocity", part="link", dimensions=("m/s",), axes=XYZ),
    ChannelQuantity(name="angular_velocity", part="link", dimensions=("rad/s",), axes=XYZ),
    ChannelQuantity(name="gyro", part="site", dimensions=("rad/s",), axes=XYZ),
    ChannelQuantity(name="accelerometer", part="site", dimensions=("m/s2",), axes=XYZ),
    ChannelQuantity(name="force", part="site", dimensions=("N",), axes=XYZ),
)
"""Every quantity that a channel may hold, in SI (docs/recordings.md)."""


@dataclass(frozen=True, kw_only=True)
class ChannelName:
    """A channel's name taken apart."""

    part: str
    """The joint, actuator, link or site."""
    quantity: ChannelQuantity
    """What is measured."""
    axis: str = ""
    """Its axis; empty for a scalar, and for all axes together."""


def parse_channel(name: str, *, where: str, whole: bool = False) -> ChannelName:
    """Return a channel's name taken apart.

    Args:
        name: For example `shoulder.position`, `hull.orientation.w`.
        where: File and line, for the error.
        whole: Whether the name stands for all axes together, without one.

    Raises:
        RecordingError: The quantity or the axis is unknown, or there is no part.
    """
    words = name.split(".")
    for quantity in QUANTITIES:
        if not quantity.axes or whole:
            matches, part, axis = words[-1] == quantity.name, words[:-1], ""
            matches = matches and bool(quantity.axes) == whole
        else:
            matches = words[-1] in quantity.axes and words[-2:-1] == [quantity.name]
            part, axis = words[:-2], words[-1]
        if matches and ".".join(part):
            return ChannelName(part=".".join(part), quantity=quantity, axis=axis)
    known = sorted({_shown(quantity, whole) for quantity in QUANTITIES})
    tail = ".".join(words[1:]) or name
    raise RecordingError(
        f"{name!r} names no known quantity; a channel is <part>. followed by {', '.join(known)}",
        where=where,
        fix=f"the nearest are {nearest(tail, _endings())}; columns that are not needed are left "
        "out where a recording.toml binds the others",
    )


def pose_channels(joint: Joint) -> tuple[str, ...]:
    """Return the channels that tell where a joint is, in the order of MuJoCo's `qpos`.

    A free joint is told by the pose of its link in the world, a ball joint by the orientation of
    its link in the link that carries it.
    """
    if joint.kind in {"hinge", "slide"}:
        return (f"{joint.name}.position",)
    part = joint.link if joint.kind == "free" else joint.name
    places = tuple(f"{part}.position.{axis}" for axis in XYZ if joint.kind == "free")
    return places + tuple(f"{part}.orientation.{axis}" for axis in WXYZ)


def is_channel(name: str) -> bool:
    """Return whether a name is that of a channel."""
    try:
        parse_channel(name, where="")
    except RecordingError:
        return False
    return True


def check_part(channel: ChannelName, name: str, robot: Robot, *, where: str) -> None:
    """Refuse a channel whose part the robot does not have; sites are not checked.

    Orientations and angular velocities are those of links, or of ball joints.

    Raises:
        RecordingError: The robot has no such joint, actuator or link.
    """
    kind = channel.quantity.part
    parts = {
        "joint": tuple(part.name for part in robot.joints),
        "actuator": tuple(part.name for part in robot.actuators),
        "link": tuple(part.name for part in robot.links),
    }.get(kind)
    balls = {joint.name for joint in robot.joints if joint.kind == "ball"}
    turns = channel.quantity.name in TURNS and channel.part in balls
    if parts is None or channel.part in parts or turns:
        return
    raise RecordingError(
        f"the channel {name!r} names no {kind} of {robot.name}; "
        f"its {kind}s are {', '.join(parts) or 'none'}",
        where=where,
        fix=f"rename the channel; the nearest are {nearest(channel.part, parts)}",
    )


def _shown(quantity: ChannelQuantity, whole: bool) -> str:
    if not quantity.axes or whole:
        return quantity.name
    return f"{quantity.name}.{{{','.join(quantity.axes)}}}"


def _endings() -> tuple[str, ...]:
    scalars = tuple(one.name for one in QUANTITIES if not one.axes)
    return scalars + tuple(f"{one.name}.{axis}" for one in QUANTITIES for axis in one.axes)
