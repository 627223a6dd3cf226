"""One who opens the viewer without a browser: a socket that counts what it is sent."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from morph.errors import ViewError

QUIET = 1.0
"""s without anything drawn anew, after which a scene counts as sent."""

CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": (1.0, 0.0, 0.0, 0.0),
    "position": (3.0, 3.0, 3.0),
    "fov": 0.8,
    "near": 0.01,
    "far": 1000.0,
    "image_height": 760,
    "image_width": 890,
    "look_at": (0.0, 0.0, 0.0),
    "up_direction": (0.0, 0.0, 1.0),
}
"""What a page says of its camera."""


@dataclass(frozen=True, kw_only=True)
class Sent:
    """What came."""

    shapes: int
    """Meshes that were sent."""
    shape_bytes: int
    """Bytes of all that came until the last of them."""
    last: float
    """When the last of them had come, s of the epoch."""


@contextmanager
def entered(address: str) -> Iterator[Any]:
    """Open a socket as a page would, until the block ends.

    Args:
        address: Where the viewer is.
    """
    import msgspec.msgpack
    import viser
    from websockets.sync.client import connect

    host = re.sub(r"^http://([^/]+).*", r"\1", address)
    with connect(
        f"ws://{host}/",
        origin=f"http://{host}",  # type: ignore[arg-type]
        subprotocols=[f"viser-v{viser.__version__}"],  # type: ignore[list-item]
        max_size=None,
        compression=None,
    ) as socket:
        # A page counts as open when it has told where its camera is.
        socket.send(msgspec.msgpack.encode(CAMERA))
        yield socket


def listened(address: str, quiet: float = QUIET, patience: float = 60.0) -> Sent:
    """Return what a page is sent until nothing new is drawn.

    Args:
        address: Where the viewer is.
        quiet: How long nothing may come, s.
        patience: How long to wait for the first shape, s.

    Raises:
        ViewError: No shape came.
    """
    from zstandard import ZstdDecompressor

    shapes, volume, upto, began = 0, 0, 0, time.time()
    last = began
    with entered(address) as socket:
        while time.time() - (last if shapes else began) < (quiet if shapes else patience):
            try:
                frame = socket.recv(timeout=0.1)
            except TimeoutError:
                continue
            if isinstance(frame, str):
                continue
            volume += len(frame)
            packed = int.from_bytes(frame[8:16], "little")
            words = ZstdDecompressor().decompress(frame[16 : 16 + packed])
            # Only what creates a mesh; what moves or colours it has another name.
            if found := words.count(b"MeshMessage"):
                shapes, upto, last = shapes + found, volume, time.time()
    if not shapes:
        raise ViewError(
            f"nothing to draw was sent within {patience:.0f} s",
            where=address,
            fix="look at it in a browser",
        )
    return Sent(shapes=shapes, shape_bytes=upto, last=last)
