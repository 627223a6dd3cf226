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


def read_text(path: Path) -> bytes:
    r"""Return a file's text in UTF-8, each line ended by `\n`, with no blank lines at its end.

    Raises:
        RecordingError: The file is missing, empty, truncated or not text, or has, or unpacks to,
            more than is read.
    """
    with opened(path) as file:
        packed = file.read(2) == b"\x1f\x8b" or path.suffix == ".gz"
        file.seek(0)
        try:
            return _taken_in(gzip.GzipFile(fileobj=file) if packed else file, file, path)
        except (EOFError, OSError, zlib.error) as error:
            raise RecordingError(
                f"the compressed file is truncated or damaged: {error}",
                where=str(path),
                fix="copy the file again; what is left of it is not read",
            ) from error


def _taken_in(source: BinaryIO | gzip.GzipFile, file: BinaryIO, path: Path) -> bytes:
    """Return all that a stream holds; `file` is what it is unpacked from, or the stream itself."""
    # Passes over the mark that some programs write before a text, and takes `\r\n` and `\r` too.
    decoder = io.IncrementalNewlineDecoder(codecs.getincrementaldecoder("utf-8-sig")(), True)
    sink = io.BytesIO()
    taken = line = inked = 0
    while piece := source.read(PIECE):
        text = _decoded(decoder, piece, taken, path)
        taken += len(piece)
        if ink := len(text.rstrip()):
            inked = sink.tell() + ink
        sink.write(text)
        end = text.rfind(b"\n")
        line = len(text) - end - 1 + (line if end < 0 else 0)
        if line > MOST_LINE:
            raise RecordingError(
                f"a line has more than {MOST_LINE} bytes",
                where=str(path),
                fix="write a line for each sample",
            )
        if taken > most_text():
            raise too_much(f"the text has more than {most_text()} bytes", str(path))
        # By what was read of the file so far, so that a bomb is known before it is unpacked.
        if source is not file and taken > most_unpacked(file.tell()):
            raise too_much(
                f"the text unpacks to more than {taken} bytes from {file.tell()}", str(path)
            )
    _decoded(decoder, b"", taken, path)
    sink.seek(inked)
    if not sink.readline().endswith(b"\n"):
        sink.write(b"\n")
    sink.truncate()
    return sink.getvalue()


def _decoded(decoder: io.IncrementalNewlineDecoder, piece: bytes, before: int, path: Path) -> bytes:
    try:
        return decoder.decode(piece, final=not piece).encode()
    except UnicodeDecodeError as error:
        # The decoder holds back a letter that a piece cuts in two.
        at = before + len(piece) - len(error.object) + error.start
        raise RecordingError(
            f"the file is not text: byte {at} is {error.object[error.start]:#04x}",
            where=str(path),
            fix="give a CSV file in UTF-8, or name the file by what it holds",
        ) from error
