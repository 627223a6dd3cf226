from __future__ import annotations

import struct
import tracemalloc
import zlib
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pyarrow
import pytest

from morph.errors import RecordingError
from morph.record.load import load_recordings

MAGIC = b"\x89MCAP0\r\n"
JOINTS = "sensor_msgs/msg/JointState"


def text(words: str) -> bytes:
    return struct.pack("<I", len(words)) + words.encode()


def record(kind: int, content: bytes, length: int | None = None) -> bytes:
    return struct.pack("<BQ", kind, len(content) if length is None else length) + content


def schema(number: int = 1, name: str = JOINTS) -> bytes:
    return record(3, struct.pack("<H", number) + text(name) + text("ros2msg") + text(""))


def channel(number: int = 1, topic: str = "/joint_states", encoding: str = "cdr") -> bytes:
    return record(4, struct.pack("<HH", number, 1) + text(topic) + text(encoding) + text(""))


def message(at: int, data: bytes, number: int = 1) -> bytes:
    return record(5, struct.pack("<HIQQ", number, 0, at, at) + data)


def chunk(body: bytes, codec: str = "", declared: int | None = None, crc: int = 0) -> bytes:
    packed = pyarrow.compress(body, codec=codec, asbytes=True) if codec else body
    size = len(body) if declared is None else declared
    head = struct.pack("<QQQI", 0, 0, size, crc) + text(codec) + struct.pack("<Q", len(packed))
    return record(6, head + packed)


def whole(*records: bytes) -> bytes:
    """A file by the specification, https://mcap.dev/spec, without indexes."""
    start, end = record(1, text("ros2") + text("")), record(15, struct.pack("<I", 0))
    return MAGIC + start + b"".join(records) + end + record(2, bytes(20)) + MAGIC


@pytest.fixture
def packed(ros: SimpleNamespace) -> list[bytes]:
    return [
        bytes(ros.store.serialize_cdr(ros.joints(at * 10**6, ["hip"], [at / 3]), JOINTS))
        for at in range(20)
    ]


@pytest.mark.parametrize("form", ["bare", "", "zstd", "lz4"])
def test_messages_are_read_from_chunks_and_without_them(
    tmp_path: Path, packed: list[bytes], form: str
) -> None:
    body = b"".join(message(at, data) for at, data in enumerate(packed))
    if form == "bare":
        data = whole(schema(), channel(), body)
    else:
        inner = schema() + channel() + body
        data = whole(chunk(inner, form, crc=zlib.crc32(inner)))
    # A record of a kind that is still to be invented is passed over, as the specification asks.
    data = data.replace(record(15, bytes(4)), record(0x7F, b"new") + record(15, bytes(4)))
    path = tmp_path / "run.mcap"
    path.write_bytes(data)
    (run,) = load_recordings(path)
    assert np.array_equal(run["hip.position"], np.arange(20) / 3)
    assert np.array_equal(run.channel("hip.position").time, np.arange(20) / 1e3)


def test_a_channel_of_another_encoding_is_no_topic_of_ours(
    tmp_path: Path, packed: list[bytes]
) -> None:
    path = tmp_path / "run.mcap"
    path.write_bytes(whole(schema(), channel(encoding="json"), message(1, b"{}")))
    with pytest.raises(RecordingError, match=r"topics are /joint_states \(sensor_msgs"):
        load_recordings(path)
    binding = tmp_path / "recording.toml"
    binding.write_text(
        '[[episode]]\nfile = "run.mcap"\n[columns]\n"hip.position" = '
        '{ column = "/joint_states:hip.position", unit = "rad" }\n'
    )
    with pytest.raises(RecordingError, match="packed as 'json', not 'cdr'") as caught:
        load_recordings(binding)
    assert caught.value.where.endswith("run.mcap, topic /joint_states")


HUGE = 2**62
START = schema() + channel()
SPOILT = {
    "no magic": (b"\x89MCAP1\r\n" + whole(START)[8:], "does not begin as MCAP", "byte 0"),
    "only the magic": (MAGIC, "ends without the record", "byte 8"),
    "huge record": (whole(record(9, b"", HUGE)), f"record of {HUGE} bytes is declared", "byte 29"),
    "huge chunk": (whole(chunk(b"a" * 99, "zstd", HUGE)), f"declares {HUGE} bytes", "byte 29"),
    "large chunk": (whole(chunk(b"a" * 99, "lz4", 2**27)), "134217728 in all so far", "byte 29"),
    "chunk too small": (whole(chunk(START, "zstd", 20)), "cannot be unpacked", "byte 29"),
    "other codec": (
        whole(record(6, bytes(28) + text("bz2") + bytes(8))),
        "cannot be unpacked .'bz2'.",
        "byte 29",
    ),
    "packed size": (
        whole(record(6, bytes(28) + text("") + struct.pack("<Q", 7))),
        "declares 7 bytes and has 0",
        "byte 29",
    ),
    "checksum": (whole(chunk(START, crc=1)), "checksum", "byte 29"),
    "chunk in a chunk": (whole(chunk(chunk(START))), "of record 6", "byte 29"),
    "record out of its chunk": (whole(chunk(record(5, b"a", 99))), "99 bytes of record 5", "29"),
    "message without channel": (whole(message(0, b"")), "channel 1, which is not there", "byte 29"),
    "short message": (whole(START, record(5, b"\1\0" + bytes(15))), "a message of 17 bytes", ""),
    "time beyond 2262": (whole(START, message(2**63, b"")), f"at {2**63} ns", ""),
    "two channels": (whole(START, channel(topic="/b")), "is '/joint_states' and '/b'", ""),
    "text too long": (whole(record(3, b"\1\0" + b"\xff" * 4)), "text of 4294967295 bytes", "29"),
    "no text": (whole(record(3, b"\1\0\1\0\0\0\xff")), "can't decode byte 0xff", "byte 29"),
    "empty chunk record": (whole(record(6, b"")), "does not hold what it should", "byte 29"),
    "no cdr": (
        whole(START, message(0, b"\xff" * 40)),
        "the message is damaged, or no",
        "message 1",
    ),
    "long list": (
        whole(START, message(0, b"\0\1\0\0" + bytes(8) + b"\1\0\0\0\0\0\0\0\xff\xff\xff\x7f")),
        "the message is damaged, or no",
        "message 1",
    ),
}


@pytest.mark.parametrize("name", SPOILT)
def test_a_spoilt_file_is_refused_at_its_byte_in_little_memory(
    tmp_path: Path, name: str, processor: Callable[[float], AbstractContextManager[None]]
) -> None:
    data, what, place = SPOILT[name]
    path = tmp_path / "run.mcap"
    path.write_bytes(data)
    tracemalloc.start()
    with processor(2.0), pytest.raises(RecordingError, match=what) as caught:
        load_recordings(path)
    taken = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert str(path) in caught.value.where
    assert caught.value.where.endswith(place)
    assert caught.value.fix
    # The declared sizes are up to 2^62 bytes; rosbags' definitions of messages take some 10^7.
    assert taken < 60e6


@pytest.mark.parametrize("cut", [0.2, 0.5, 0.9, 0.99])
def test_a_truncated_file_is_refused(tmp_path: Path, packed: list[bytes], cut: float) -> None:
    inner = START + b"".join(message(at, data) for at, data in enumerate(packed))
    data = whole(chunk(inner))
    path = tmp_path / "run.mcap"
    path.write_bytes(data)
    assert len(load_recordings(path)) == 1
    # What ends the data stands in the last 50 of about 2700 bytes: 99 % still cut within it.
    path.write_bytes(data[: int(cut * (len(data) - 50))])
    with pytest.raises(RecordingError, match="truncated, damaged or not MCAP") as caught:
        load_recordings(path)
    assert "mcap recover" in caught.value.fix


def test_a_bomb_of_zeros_is_never_unpacked(tmp_path: Path) -> None:
    # 32 chunks of 64 MiB of zeros, packed by zstd to about 2 KB each: 2 GiB from 70 KB.
    one = chunk(record(5, struct.pack("<HIQQ", 1, 0, 0, 0) + bytes(2**26)), "zstd")
    path = tmp_path / "run.mcap"
    path.write_bytes(whole(START, *([one] * 32)))
    assert path.stat().st_size < 500_000
    with pytest.raises(RecordingError, match=r"a chunk declares 671088\d\d bytes") as caught:
        load_recordings(path)
    assert caught.value.fix
