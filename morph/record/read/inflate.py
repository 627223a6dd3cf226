"""Whether the chunks of an HDF5 data set unpack to what they declare, before HDF5 unpacks them.

HDF5 unpacks a chunk whole, however much comes out of it.
"""

from __future__ import annotations

import math
import zlib
from typing import Any

from morph.record.limits import MOST_CHUNK

MOST_CHUNKS = 1_000_000
"""The most chunks of one data set."""
DEFLATE, SHUFFLE, FLETCHER32, LZF = 1, 2, 3, 32000
"""The filters that are undone, by their numbers in HDF5's registry."""
MOST_RATIO = {DEFLATE: 1032, LZF: 88}
"""The most bytes that one can unpack to: 258 of 2 bits (zlib's limit), 264 of 3 bytes (LZF's)."""
SLACK = 4096
"""Bytes that a chunk may take beyond its data, for checksums and what does not pack well."""


def chunk_bytes(dataset: Any) -> int:
    """Return how many bytes the stored chunks of a data set unpack to, as they declare.

    Args:
        dataset: An `h5py.Dataset`.
    """
    return dataset.id.get_num_chunks() * _nominal(dataset) if dataset.chunks else 0


def check_chunks(dataset: Any) -> str:
    """Return why a data set's chunks cannot be read, or nothing.

    Args:
        dataset: An `h5py.Dataset`.
    """
    if dataset.chunks is None:
        return ""
    nominal = _nominal(dataset)
    if nominal > MOST_CHUNK:
        return f"its chunks declare {nominal} bytes each; at most {MOST_CHUNK} are read"
    if dataset.id.get_num_chunks() > MOST_CHUNKS:
        return f"it has {dataset.id.get_num_chunks()} chunks; at most {MOST_CHUNKS} are read"
    settings = dataset.id.get_create_plist()
    filters = [settings.get_filter(at)[0] for at in range(settings.get_nfilters())]
    unknown = sorted(set(filters) - {DEFLATE, SHUFFLE, FLETCHER32, LZF})
    if unknown:
        return f"it is packed by filter {unknown[0]}; gzip and lzf are read"
    packers = [one for one in filters if one in MOST_RATIO]
    if len(packers) > 1:
        return "it is packed more than once"
    return _check_stored(dataset, nominal, packers[0]) if packers else ""


def _nominal(dataset: Any) -> int:
    """Return how many bytes a chunk declares."""
    nominal: int = math.prod(dataset.chunks) * dataset.dtype.itemsize
    return nominal


def _check_stored(dataset: Any, nominal: int, packer: int) -> str:
    stored: list[Any] = []
    dataset.id.chunk_iter(stored.append)
    for chunk in stored:
        if chunk.size > nominal + SLACK:
            return f"a chunk of {nominal} bytes takes {chunk.size} bytes packed"
        if chunk.size * MOST_RATIO[packer] <= MOST_CHUNK:
            continue
        # Only a large chunk can be a bomb: it is unpacked once, up to its size, to see.
        if packer == LZF:
            if chunk.size * MOST_RATIO[LZF] > 8 * MOST_CHUNK:
                return f"a chunk takes {chunk.size} bytes packed by lzf, more than is read"
        elif not _inflates(dataset.id.read_direct_chunk(chunk.chunk_offset)[1], nominal):
            return f"a chunk unpacks to more than the {nominal} bytes that it declares"
    return ""


def _inflates(data: bytes, nominal: int) -> bool:
    """Return whether packed bytes unpack to no more than is declared."""
    stream, left = zlib.decompressobj(), nominal + SLACK
    while data and left > 0 and not stream.eof:
        left -= len(stream.decompress(data, min(left, 1 << 22)))
        data = stream.unconsumed_tail
    return left > 0
