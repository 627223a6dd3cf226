"""What a file's size and hash are of: its content, apart from how it is packed or laid out."""

from __future__ import annotations

import gzip
import hashlib
import io
import zipfile
import zlib
from collections.abc import Callable
from typing import TYPE_CHECKING
from xml.etree.ElementTree import ParseError, canonicalize

from morph.errors import MorphError

if TYPE_CHECKING:
    from experiments.public.manifest import PublicFile


class DataError(MorphError):
    """A public file cannot be had, or is not what was used."""


def verify(public: PublicFile, data: bytes, where: str) -> None:
    """Check that a file as stored holds the content that was used.

    Args:
        public: What it must be.
        data: The file's bytes as they are stored in the set.
        where: The path or address to name in an error.

    Raises:
        DataError: It cannot be unpacked, or its size or hash differs.
    """
    size, digest = measure(data, public.form, where, most=public.size)
    fix = "fetch it again with python -m experiments.data"
    if size != public.size:
        raise DataError(f"holds {size} bytes instead of {public.size}", where=where, fix=fix)
    if digest != public.sha256:
        raise DataError(f"has sha256 {digest} instead of {public.sha256}", where=where, fix=fix)


def measure(data: bytes, form: str, where: str, *, most: int | None = None) -> tuple[int, str]:
    """Return size and SHA-256 of the content of a file.

    Args:
        data: The file's bytes.
        form: `raw`: the bytes. `gzip`: what they unpack to. `xml`: the canonical form
            (C14N 2.0) without comments and indentation, which whoever writes the same
            description reaches. `npz`: names and bytes of the arrays, in order of names,
            since how tightly they are packed depends on the version of zlib.
        where: The path or address to name in an error.
        most: Do not unpack more bytes than one above this.

    Raises:
        DataError: It cannot be unpacked.
    """
    try:
        content = FORMS[form](data, most)
    except (OSError, EOFError, ValueError, zlib.error, zipfile.BadZipFile, ParseError) as error:
        raise DataError(
            f"cannot be unpacked: {error}",
            where=where,
            fix="fetch it again with python -m experiments.data",
        ) from error
    return len(content), hashlib.sha256(content).hexdigest()


def _raw(data: bytes, most: int | None) -> bytes:
    return data


def _gzip(data: bytes, most: int | None) -> bytes:
    with gzip.open(io.BytesIO(data)) as file:
        return file.read() if most is None else file.read(most + 1)


def _xml(data: bytes, most: int | None) -> bytes:
    return canonicalize(data.decode(), strip_text=True).encode()


def _npz(data: bytes, most: int | None) -> bytes:
    content = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        for member in sorted(archive.namelist()):
            content.write(member.encode() + b"\0")
            with archive.open(member) as file:
                left = -1 if most is None else max(0, most + 1 - content.tell())
                content.write(file.read(left))
    return content.getvalue()


FORMS: dict[str, Callable[[bytes, int | None], bytes]] = {
    "raw": _raw,
    "gzip": _gzip,
    "xml": _xml,
    "npz": _npz,
}
