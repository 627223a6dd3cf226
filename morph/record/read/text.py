"""The text of a file, also gzipped, taken in piece by piece so that no bomb is unpacked."""

from __future__ import annotations

import codecs
import gzip
import io
import zlib
from pathlib import Path
from typing import BinaryIO

from morph.errors import RecordingError
from morph.record.limits import MOST_LINE, most_text, most_unpacked, too_much
from morph.record.read.file import opened

PIECE = 1 << 20
"""Bytes that are unpacked at once."""

MARK = codecs.BOM_UTF8
"""What some programs write before a text."""


def read_text(path: Path) -> bytes:
    r"""Return a file's text in UTF-8, its lines ended by `\n` and no blank ones at its end.

    Raises:
        RecordingError: The file is missing, empty, truncated or not text, or has, or unpacks to,
            more than is read.
    """
    with opened(path) as file:
        packed = file.read(2) == b"\x1f\x8b" or path.suffix == ".gz"
        file.seek(0)
        try:
            text = _taken_in(gzip.GzipFile(fileobj=file) if packed else file, file, path)
        except (EOFError, OSError, zlib.error) as error:
            raise RecordingError(
                f"the compressed file is truncated or damaged: {error}",
                where=str(path),
                fix="copy the file again; what is left of it is not read",
            ) from error
    text = text.removeprefix(MARK)
    if b"\r" in text:
        text = text.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    last = text.find(b"\n", len(text.rstrip()))
    return text if last < 0 else text[:last]


def _taken_in(source: BinaryIO | gzip.GzipFile, file: BinaryIO, path: Path) -> bytes:
    """Return all that a stream holds; `file` is what it is unpacked from, or the stream itself."""
    sink, decoder = io.BytesIO(), codecs.getincrementaldecoder("utf-8")()
    line = 0
    while piece := source.read(PIECE):
        _check_text(decoder, piece, sink.tell(), path)
        sink.write(piece)
        end = max(piece.rfind(b"\n"), piece.rfind(b"\r"))
        line = len(piece) - end - 1 + (line if end < 0 else 0)
        if line > MOST_LINE:
            raise RecordingError(
                f"a line has more than {MOST_LINE} bytes",
                where=str(path),
                fix="write a line for each sample",
            )
        if sink.tell() > most_text():
            raise too_much(f"the text has more than {most_text()} bytes", str(path))
        # By what was read of the file so far, so that a bomb is known before it is unpacked.
        if source is not file and sink.tell() > most_unpacked(file.tell()):
            raise too_much(
                f"the text unpacks to more than {sink.tell()} bytes from {file.tell()}", str(path)
            )
    _check_text(decoder, b"", sink.tell(), path)
    return sink.getvalue()


def _check_text(decoder: codecs.IncrementalDecoder, piece: bytes, before: int, path: Path) -> None:
    try:
        decoder.decode(piece, final=not piece)
    except UnicodeDecodeError as error:
        # The decoder holds back a letter that a piece cuts in two.
        at = before + len(piece) - len(error.object) + error.start
        raise RecordingError(
            f"the file is not text: byte {at} is {error.object[error.start]:#04x}",
            where=str(path),
            fix="give a CSV file in UTF-8, or name the file by what it holds",
        ) from error
