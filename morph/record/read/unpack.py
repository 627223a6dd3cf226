"""Unpacking compressed bytes into no more memory than was agreed."""

from __future__ import annotations

CODECS = ("zstd", "lz4")
"""How a bag may be compressed."""


def unpack(data: bytes, codec: str, most: int) -> bytes | None:
    """Return what compressed bytes hold, or None if that is damaged or more than `most` bytes.

    What would be more is never made: a bomb costs `most` bytes and one.

    Args:
        data: The compressed bytes.
        codec: One of `CODECS`.
        most: The most bytes that may come out.
    """
    import pyarrow

    if codec not in CODECS:
        return None
    parts, left = [], most + 1
    try:
        with pyarrow.CompressedInputStream(pyarrow.BufferReader(data), codec) as stream:
            while left and (part := stream.read(min(left, 1 << 22))):
                parts.append(part)
                left -= len(part)
    # Arrow's errors derive from several built-in ones, by the kind of damage.
    except Exception:
        return None
    return b"".join(parts) if left else None
