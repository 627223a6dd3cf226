"""What bombs are made of: archives, packed streams and arrays that share or repeat their bytes.

Source: D. Fifield, "A better zip bomb", USENIX WOOT 2019 (members that share their bytes).
"""

from __future__ import annotations

import struct
import zipfile
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

MIB = 2**20


@dataclass(frozen=True, kw_only=True)
class Bomb:
    """A trick."""

    name: str
    """The file's name; its ending says how it is read."""
    reader: str
    """Who reads it: a key of `READERS` of `experiments.bomb_readers`."""
    make: Callable[[Path], object]
    """Writes it."""
    read: bool = False
    """Whether it is read all the same, as what would cost is passed over."""


def npy(shape: str, data: bytes = b"", kind: str = "<f8") -> bytes:
    """Return an array in NumPy's format whose header says what one likes."""
    text = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}".encode()
    head = text.ljust(117) + b"\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head + data


def archive(path: Path, members: dict[str, bytes], *, times: int = 1) -> None:
    """Write an archive; each member is listed so many times, its bytes stand there once."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as packed:
        for name, data in members.items():
            packed.writestr(name, data)
        packed.filelist *= times


def deflated(piece: bytes, times: int, head: bytes = b"") -> bytes:
    """Return a raw stream of a piece over and over, which is packed once.

    After a full flush nothing refers to what came before (RFC 1951, and zlib's manual).
    """
    packer = zlib.compressobj(6, wbits=-zlib.MAX_WBITS)
    first = packer.compress(head) + packer.flush(zlib.Z_FULL_FLUSH)
    block = packer.compress(piece) + packer.flush(zlib.Z_FULL_FLUSH)
    return first + block * times + packer.flush()


def gz(path: Path, piece: bytes, times: int, head: bytes = b"") -> None:
    """Write a packed file of one piece over and over."""
    check, size = zlib.crc32(head), len(head) + times * len(piece)
    for _ in range(times):
        check = zlib.crc32(piece, check)
    began = b"\x1f\x8b\x08" + bytes(6) + b"\xff"
    path.write_bytes(began + deflated(piece, times, head) + struct.pack("<II", check, size))
