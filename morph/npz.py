"""Loading NPZ archives within bounds: every declared size is checked before memory is taken."""

from __future__ import annotations

import errno
import io
import math
import zipfile
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from morph.regular_file import open_regular

MOST_ARRAYS = 10_000
"""Most members of an archive; Python's list of them takes half a kilobyte each."""

ENTRY = b"PK\x01\x02"
"""How the entry of a member begins in the archive's list of members (APPNOTE.TXT 4.3.12)."""

PIECE = 1 << 20
"""Bytes of the archive that are looked through at once."""

MOST_HEADERS = 2 << 20
"""Most bytes of all headers together; numpy writes 118 for a plain array, and reads any number."""

HEADERS = {
    (1, 0): np.lib.format.read_array_header_1_0,
    (2, 0): np.lib.format.read_array_header_2_0,
}
"""Reads the header of an array, by the version of its format."""


def load_npz(source: Path | bytes | BinaryIO, most: int) -> dict[str, Any]:
    """Return the arrays of an NPZ archive by name; nothing is unpickled.

    Args:
        source: The file, its bytes, or the file open for reading.
        most: Most bytes that the arrays may take, a number counted with 8 bytes at least.

    Raises:
        ValueError: It is damaged or no NPZ, has more than 10,000 members, or holds something
            other than plain arrays.
        OSError: The file cannot be read, is no regular file, or holds more (`EFBIG`).
    """
    if isinstance(source, Path):
        with open_regular(source) as file:
            return load_npz(file, most)
    file = io.BytesIO(source) if isinstance(source, bytes) else source
    if _entries(file) > MOST_ARRAYS:
        raise ValueError(f"it has more than {MOST_ARRAYS} members")
    try:
        with zipfile.ZipFile(file) as archive:
            members = archive.infolist()
            total, room = 0, MOST_HEADERS
            for member in members:
                memory, header = _declared(archive, member, room)
                total, room = total + memory, room - header
                if total > most:
                    raise OSError(errno.EFBIG, f"its arrays take more than {most} bytes")
            return {_name(each): _array(archive, each) for each in members}
    except OSError as error:
        if error.errno == errno.EFBIG:
            raise
        raise ValueError(str(error)) from error
    # numpy and zipfile raise a dozen unrelated errors on damaged bytes.
    except Exception as error:
        raise ValueError(str(error) or type(error).__name__) from error


def _entries(file: BinaryIO) -> int:
    """Return how many members the archive may list, before Python lists them."""
    count, carried = 0, b""
    file.seek(0)
    while piece := file.read(PIECE):
        piece = carried + piece
        count += piece.count(ENTRY)
        # An entry may begin in one piece and end in the next; never counted twice, being shorter.
        carried = piece[-len(ENTRY) + 1 :]
    file.seek(0)
    return count


def _name(member: zipfile.ZipInfo) -> str:
    return member.filename.removesuffix(".npy")


def _declared(archive: zipfile.ZipFile, member: zipfile.ZipInfo, room: int) -> tuple[int, int]:
    """Return how many bytes an array will take and its header has, once they fit what is there."""
    name = _name(member)
    if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise ValueError(f"{name} is packed by method {member.compress_type}, no NPZ's")
    with archive.open(member) as file:
        version = np.lib.format.read_magic(file)
        if version not in HEADERS:
            raise ValueError(f"{name} has the format {version}")
        length = int.from_bytes(file.read(2 * version[0]), "little")
        if length > room:
            raise ValueError(f"with that of {name} the headers have more than {MOST_HEADERS} bytes")
        file.seek(-2 * version[0], io.SEEK_CUR)
        shape, _, dtype = HEADERS[version](file)
        if dtype.hasobject:
            raise ValueError(f"{name} holds objects, which are never read")
        declared, held = math.prod(shape) * dtype.itemsize, member.file_size - file.tell()
    if min(shape, default=0) < 0 or declared != held:
        raise ValueError(f"{name} declares {declared} bytes and has {held}")
    return math.prod(shape) * max(dtype.itemsize, 8), length


def _array(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> Any:
    with archive.open(member) as file:
        return np.lib.format.read_array(file, allow_pickle=False)
