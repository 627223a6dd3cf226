"""Whether a PNG picture unpacks to no more than its size says, before MuJoCo unpacks it.

Source: W3C Portable Network Graphics Specification, second edition, sections 5, 7.2 and 11.2.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator

SIGNATURE = b"\x89PNG\r\n\x1a\n"
"""How a PNG begins."""

CHANNELS = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}
"""Numbers of a point by the colour type: grey, colour, palette, and the first two with alpha."""

TEXTS = (b"zTXt", b"iTXt", b"iCCP")
"""Parts that may be packed and that nobody here needs."""

MOST_TEXT = 2**16
"""Most bytes of these, packed: deflate makes no more than 66 MB of them."""

SLACK = 4096
"""Bytes that the passes of an interlaced picture may take beyond the points."""


def why_not_png(content: bytes, most: int) -> str:
    """Return why a picture is not to be read; empty if it is.

    Args:
        content: The file.
        most: Most points of the picture.
    """
    if not content.startswith(SIGNATURE) or len(content) < 33:
        return "is no PNG picture"
    width, height, depth, colour = struct.unpack(">IIBB", content[16:26])
    if not 0 < width * height <= most or colour not in CHANNELS:
        return f"is no PNG picture of a usual size: {width} x {height} points, {most} at most"
    # Each row has a byte of its own, and twice as many rows are in the passes of an interlace.
    left = 2 * height * (1 + (width * CHANNELS[colour] * depth + 7) // 8) + SLACK
    stream, texts = zlib.decompressobj(), 0
    for kind, data in _chunks(content):
        texts += len(data) if kind in TEXTS else 0
        while kind == b"IDAT" and data and left > 0 and not stream.eof:
            try:
                left -= len(stream.decompress(data, min(left, 1 << 20)))
            except zlib.error as error:
                return f"is a damaged PNG picture: {error}"
            data = stream.unconsumed_tail
    if left <= 0:
        return f"is a PNG that unpacks to more than its {width} x {height} points"
    return f"holds more than {MOST_TEXT} bytes of packed texts" if texts > MOST_TEXT else ""


def _chunks(content: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Give the kind and the data of each part that is whole."""
    at = len(SIGNATURE)
    while at + 12 <= len(content):
        (length,) = struct.unpack_from(">I", content, at)
        yield content[at + 4 : at + 8], content[at + 8 : at + 8 + length]
        at += 12 + length
