"""Bags written by rosbags itself, from the definitions of ROS 2 Jazzy."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

Written = tuple[str, str, Sequence[tuple[int, Any]]]
"""A topic, its type, and log time, ns, and message for each."""


@pytest.fixture(scope="session")
def ros() -> SimpleNamespace:
    """Makers of the four messages, by field; `stamp` in ns, None for a header without one."""
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    kinds = {name.replace("/msg/", "/"): kind for name, kind in store.types.items()}

    def header(stamp: int | None, frame: str = "") -> Any:
        time = kinds["builtin_interfaces/Time"](
            sec=(stamp or 0) // 10**9, nanosec=(stamp or 0) % 10**9
        )
        return kinds["std_msgs/Header"](stamp=time, frame_id=frame)

    def joints(stamp: int | None, names: Sequence[str], *lists: Sequence[float]) -> Any:
        numbers = [np.array(one, dtype=np.float64) for one in lists]
        numbers += [np.empty(0)] * (3 - len(numbers))
        position, velocity, effort = numbers
        return kinds["sensor_msgs/JointState"](
            header=header(stamp),
            name=list(names),
            position=position,
            velocity=velocity,
            effort=effort,
        )

    def imu(
        stamp: int | None,
        frame: str,
        gyro: Sequence[float],
        push: Sequence[float],
        known: float = 0,
    ) -> Any:
        vector, quaternion = kinds["geometry_msgs/Vector3"], kinds["geometry_msgs/Quaternion"]
        return kinds["sensor_msgs/Imu"](
            header=header(stamp, frame),
            orientation=quaternion(x=0.0, y=0.0, z=0.0, w=1.0),
            orientation_covariance=np.zeros(9),
            angular_velocity=vector(**dict(zip("xyz", gyro, strict=True))),
            angular_velocity_covariance=np.zeros(9),
            linear_acceleration=vector(**dict(zip("xyz", push, strict=True))),
            linear_acceleration_covariance=np.array([known] + [0.0] * 8),
        )

    def pose(stamp: int | None, frame: str, place: Sequence[float], turn: Sequence[float]) -> Any:
        return kinds["geometry_msgs/PoseStamped"](
            header=header(stamp, frame),
            pose=kinds["geometry_msgs/Pose"](
                position=kinds["geometry_msgs/Point"](**dict(zip("xyz", place, strict=True))),
                orientation=kinds["geometry_msgs/Quaternion"](
                    **dict(zip("wxyz", turn, strict=True))
                ),
            ),
        )

    def array(numbers: Sequence[float]) -> Any:
        layout = kinds["std_msgs/MultiArrayLayout"](dim=[], data_offset=0)
        return kinds["std_msgs/Float64MultiArray"](
            layout=layout, data=np.array(numbers, dtype=np.float64)
        )

    def text(words: str) -> Any:
        return kinds["std_msgs/String"](data=words)

    return SimpleNamespace(store=store, joints=joints, imu=imu, pose=pose, array=array, text=text)


@pytest.fixture(scope="session")
def write_bag(ros: SimpleNamespace) -> Callable[..., Path]:
    """Write topics as a bag's folder by rosbags: `write_bag(folder, topics, storage="mcap")`."""
    from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

    def write(
        folder: Path, topics: Sequence[Written], *, storage: str = "mcap", pack: str = ""
    ) -> Path:
        plugin = StoragePlugin.MCAP if storage == "mcap" else StoragePlugin.SQLITE3
        writer = Writer(folder, version=9, storage_plugin=plugin)
        if pack:
            writer.set_compression(CompressionMode[pack.upper()], CompressionFormat.ZSTD)
        with writer:
            packed = []
            for topic, kind, messages in topics:
                full = kind.replace("/", "/msg/")
                connection = writer.add_connection(topic, full, typestore=ros.store)
                packed += [
                    (time, connection, ros.store.serialize_cdr(message, full))
                    for time, message in messages
                ]
            for time, connection, data in sorted(packed, key=lambda one: one[0]):
                writer.write(connection, time, data)
        return folder

    return write
