"""Reading the MCAP container: which topics it has, and their messages, still packed.

The layout is that of the MCAP specification, version 0 (https://mcap.dev/spec): a magic, then
records of one byte of kind and eight of length. The file is read once from its start, so that no
index in it is believed, and every size that it declares is checked before memory is taken.
"""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

from morph.errors import RecordingError
from morph.record.limits import MOST_CHUNK, most_unpacked, too_much
from morph.record.read.file import opened
from morph.record.read.topic import Messages, Topic
from morph.record.read.unpack import unpack

MAGIC = b"\x89MCAP0\r\n"
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, DATA_END = 0x01, 0x02, 0x03, 0x04, 0x05, 0x06, 0x0F


def scan_mcap(path: Path, messages: Messages) -> None:
    """Add what is wanted of an MCAP file to the messages of a bag.

    Raises:
        RecordingError: The file is missing, empty, truncated or damaged, or has
            records of absurd size.
    """
    with opened(path) as file:
        scan = _Scan(path=path, size=os.fstat(file.fileno()).st_size, messages=messages)
        scan.run(file)


@dataclass(kw_only=True)
class _Scan:
    """One pass through a file."""

    path: Path
    size: int
    messages: Messages
    at: int = 0
    unpacked: int = 0
    schemas: dict[int, str] = field(default_factory=dict)
    channels: dict[int, tuple[Topic, bool]] = field(default_factory=dict)

    def damaged(self, at: int, what: str) -> RecordingError:
        """Return the error for bytes that cannot be used."""
        return RecordingError(
            f"the file is truncated, damaged or not MCAP: {what}",
            where=f"{self.path}, byte {at}",
            fix="copy the file again; if its recorder was stopped short, `mcap recover` mends it",
        )

    def run(self, file: BinaryIO) -> None:
        """Read the file; what cannot be used is an error of ours."""
        try:
            self.file(file)
        except OSError as error:
            raise self.damaged(0, f"it cannot be read: {error.strerror or error}") from error
        except (struct.error, UnicodeDecodeError, IndexError) as error:
            raise self.damaged(
                self.at, f"a record does not hold what it should: {error}"
            ) from error

    def file(self, file: BinaryIO) -> None:
        """Read the records of the file up to the end of its data."""
        if file.read(len(MAGIC)) != MAGIC:
            raise self.damaged(0, "it does not begin as MCAP files do")
        while True:
            self.at = file.tell()
            head = file.read(9)
            if len(head) < 9:
                raise self.damaged(self.at, "it ends without the record that ends its data")
            kind, length = struct.unpack("<BQ", head)
            if length > self.size - file.tell():
                raise self.damaged(
                    self.at, f"a record of {length} bytes is declared, {self.size} are in the file"
                )
            if kind in (DATA_END, FOOTER):
                return
            if kind == CHUNK:
                self.chunk(file, length)
            elif kind in (SCHEMA, CHANNEL) or (kind == MESSAGE and self.is_wanted(file)):
                self.record(kind, self.bounded(file, length))
            else:
                file.seek(length, 1)

    def is_wanted(self, file: BinaryIO) -> bool:
        """Return whether the message ahead, outside of any chunk, is to be read, and count it."""
        here = file.tell()
        channel = file.read(2)
        file.seek(here)
        return len(channel) < 2 or self.wanted(struct.unpack("<H", channel)[0])

    def wanted(self, number: int) -> bool:
        """Return whether a channel's next message is to be read, and count it."""
        if number not in self.channels:
            raise self.damaged(
                self.at, f"a message belongs to channel {number}, which is not there"
            )
        topic, wanted = self.channels[number]
        self.messages.counts[topic] += 1
        return wanted

    def bounded(self, file: BinaryIO, length: int) -> bytes:
        """Return the bytes of a record that is not absurdly long."""
        if length > MOST_CHUNK:
            raise self.damaged(
                self.at, f"a record of {length} bytes; at most {MOST_CHUNK} are read"
            )
        return file.read(length)

    def chunk(self, file: BinaryIO, length: int) -> None:
        """Read the records in one chunk."""
        data = self.bounded(file, length)
        declared, crc = struct.unpack_from("<QI", data, 16)
        codec, after = _text(data, 28)
        (packed,) = struct.unpack_from("<Q", data, after)
        body = data[after + 8 :]
        self.unpacked += declared
        # By what was read of the file so far, so that a bomb is known before it is unpacked.
        most = most_unpacked(file.tell())
        if declared > MOST_CHUNK or self.unpacked > most:
            raise too_much(
                f"a chunk declares {declared} bytes, {self.unpacked} in all so far, of which "
                f"{min(most, MOST_CHUNK)} are read", f"{self.path}, byte {self.at}",
            )  # fmt: skip
        if packed != len(body):
            raise self.damaged(self.at, f"a chunk declares {packed} bytes and has {len(body)}")
        if codec:
            unpacked = unpack(body, codec, declared)
            if unpacked is None:
                raise self.damaged(self.at, f"a chunk cannot be unpacked ({codec!r})")
            body = unpacked
        if len(body) != declared or (crc and zlib.crc32(body) != crc):
            raise self.damaged(self.at, "a chunk's contents differ from its checksum or its size")
        for kind, content in self.inner(body):
            self.record(kind, content)

    def inner(self, body: bytes) -> Iterator[tuple[int, bytes]]:
        """Give the records in a chunk that are to be read."""
        at = 0
        while at < len(body):
            kind, length = struct.unpack_from("<BQ", body, at)
            at += 9
            if length > len(body) - at or kind not in (SCHEMA, CHANNEL, MESSAGE):
                raise self.damaged(self.at, f"a chunk holds {length} bytes of record {kind}")
            if kind != MESSAGE or self.wanted(struct.unpack_from("<H", body, at)[0]):
                yield kind, body[at : at + length]
            at += length

    def record(self, kind: int, data: bytes) -> None:
        """Take in one schema, channel, or message that is wanted."""
        if kind == SCHEMA:
            (number,) = struct.unpack_from("<H", data)
            self.schemas[number] = _text(data, 2)[0]
        elif kind == CHANNEL:
            number, schema = struct.unpack_from("<HH", data)
            name, after = _text(data, 4)
            topic = Topic(
                name=name, kind=self.schemas.get(schema, ""), encoding=_text(data, after)[0]
            )
            known = self.channels.get(number)
            if known is not None and known[0] != topic:
                raise self.damaged(self.at, f"channel {number} is {known[0].name!r} and {name!r}")
            self.channels[number] = (topic, self.messages.meet(topic, self.path))
        else:
            number, _, time = struct.unpack_from("<HIQ", data)
            if len(data) < 22 or time >= 1 << 63:
                raise self.damaged(self.at, f"a message of {len(data)} bytes at {time} ns")
            self.messages.add(self.channels[number][0], time, data[22:], self.path)


def _text(data: bytes, at: int) -> tuple[str, int]:
    """Return the text at a place, and the place after it."""
    (length,) = struct.unpack_from("<I", data, at)
    end = at + 4 + length
    if end > len(data):
        raise IndexError(f"a text of {length} bytes")
    return data[at + 4 : end].decode(), end
