"""What one message says: the names of its channels, and their values.

Joints go by the names in the message. A pose's body is the last word of its topic that is not
`pose`, because the message names only the frame that it is seen from. An IMU's part is its frame,
or else its topic.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

from morph.arrays import Array
from morph.errors import RecordingError
from morph.record.quantities import WXYZ, XYZ

JOINT_QUANTITIES = ("position", "velocity", "effort")
"""What a JointState may hold, in the order of its fields."""

Values = tuple[tuple[str, ...], Array]
"""The channels in one message, and the value of each."""


def plain(kind: str) -> str:
    """Return a type as it is written without ROS 2's middle word: `sensor_msgs/Imu`."""
    return kind.replace("/msg/", "/")


def _joint_state(message: Any, topic: str, place: str) -> Values:
    names = tuple(message.name)
    blocks = {quantity: getattr(message, quantity) for quantity in JOINT_QUANTITIES}
    present = tuple(quantity for quantity, block in blocks.items() if len(block))
    for quantity in present:
        if len(blocks[quantity]) != len(names):
            raise RecordingError(
                f"the message has {len(names)} names and {len(blocks[quantity])} of {quantity}",
                where=place,
                fix="correct what publishes this topic: each list is empty or as long as the names",
            )
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise RecordingError(
            f"the message names {twice!r} twice",
            where=place,
            fix="correct what publishes this topic: each joint stands in a message once",
        )
    values = [blocks[quantity] for quantity in present]
    return _joint_channels(names, present), np.concatenate(values) if values else np.empty(0)


@lru_cache(maxsize=64)
def _joint_channels(names: tuple[str, ...], quantities: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(f"{name}.{quantity}" for quantity in quantities for name in names)


def _imu(message: Any, topic: str, place: str) -> Values:
    part = message.header.frame_id.strip("/") or topic.strip("/")
    given = {
        "gyro": (message.angular_velocity, message.angular_velocity_covariance),
        "accelerometer": (message.linear_acceleration, message.linear_acceleration_covariance),
    }
    # A first covariance of -1 says that the quantity is not measured (sensor_msgs/Imu).
    results = {name: vector for name, (vector, spread) in given.items() if spread[0] != -1.0}
    names = tuple(f"{part}.{name}.{axis}" for name in results for axis in XYZ)
    return names, np.array([getattr(one, axis) for one in results.values() for axis in XYZ])


def _pose(message: Any, topic: str, place: str) -> Values:
    words = topic.strip("/").split("/")
    part = words[-2] if words[-1] == "pose" and len(words) > 1 else words[-1]
    given = (("position", XYZ), ("orientation", WXYZ))
    names = tuple(f"{part}.{quantity}.{axis}" for quantity, axes in given for axis in axes)
    pose = message.pose
    return names, np.array(
        [getattr(getattr(pose, quantity), axis) for quantity, axes in given for axis in axes]
    )


ARRAY = "std_msgs/Float64MultiArray"
"""The type whose numbers only a binding can name."""
POSE = "geometry_msgs/PoseStamped"
"""The type whose messages name the frame that a body is seen from."""
NAMED: dict[str, Callable[[Any, str, str], Values]] = {
    "sensor_msgs/JointState": _joint_state,
    "sensor_msgs/Imu": _imu,
    POSE: _pose,
}
"""The types whose messages say what they hold, each with how a message is read."""
