"""Send poses to a scene, many a frame."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from morph.arrays import Array

Move = Callable[[Any, Array | None, Array | None], None]


def mover(scene: Any) -> Move:
    """Return what puts a node of a scene where it is to be.

    It takes the node's handle, its position, m, shape (3,), and its unit quaternion, w first,
    shape (4,); None for what stays. Both must be finite.

    A handle of viser 1.1 compares what it is given with what it has, by `np.allclose`: 25 of
    the 33 us that a pose takes. The stage has compared all links of a body in one step before,
    so the same messages are queued without. Where a later viser has them no more, its handles
    are used.
    """
    try:
        from viser._messages import SetOrientationMessage, SetPositionMessage

        queue = scene._queue_scene_message
    except (ImportError, AttributeError):
        return _by_handle

    def move(node: Any, position: Array | None, turn: Array | None) -> None:
        if position is not None:
            x, y, z = position.tolist()
            queue(SetPositionMessage(node.name, (x, y, z)))
        if turn is not None:
            w, x, y, z = turn.tolist()
            queue(SetOrientationMessage(node.name, (w, x, y, z)))

    return move


def _by_handle(node: Any, position: Array | None, turn: Array | None) -> None:
    if position is not None:
        node.position = position
    if turn is not None:
        node.wxyz = turn
