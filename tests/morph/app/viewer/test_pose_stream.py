"""Poses are sent as viser's own handles send them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
from viser._scene_handles import _set_pose_vector

from morph.app.viewer.pose_stream import mover


class Queue:
    """A scene of which only the way of messages is left."""

    def __init__(self) -> None:
        self.sent: list[Any] = []

    def _queue_scene_message(self, message: Any) -> None:
        self.sent.append(message)


def test_the_messages_are_those_of_a_handle_of_viser() -> None:
    from viser._messages import SetOrientationMessage, SetPositionMessage

    scene, theirs = Queue(), Queue()
    position, turn = np.array([1.0, 2.0, 3.0]), np.array([0.5, -0.5, 0.5, 0.5])
    mover(scene)(SimpleNamespace(name="/world/0"), position, turn)
    for value, message in ((position, SetPositionMessage), (turn, SetOrientationMessage)):
        _set_pose_vector(
            np.zeros(len(value)),
            value,
            len(value),
            theirs._queue_scene_message,
            lambda told, message=message: message("/world/0", told),
        )
    assert scene.sent == theirs.sent


def test_what_stays_is_not_sent() -> None:
    scene = Queue()
    mover(scene)(SimpleNamespace(name="/world/0"), None, None)
    assert scene.sent == []


def test_without_viser_s_private_parts_its_handles_are_used() -> None:
    node = SimpleNamespace()
    mover(SimpleNamespace())(node, np.ones(3), np.ones(4))
    assert np.array_equal(node.position, np.ones(3))
    assert np.array_equal(node.wxyz, np.ones(4))
