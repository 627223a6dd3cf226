from __future__ import annotations

import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from morph.errors import TransferError
from morph.files import sha256
from morph.policy_transfer.link.message import SCHEMA, Message, packed, unpacked

MESSAGE = Message(sender="robot", number=3, kind="experience", content={"loss": 0.1, "né": [1]})


def test_a_message_comes_out_as_it_went_in() -> None:
    assert unpacked(packed(MESSAGE)) == MESSAGE


@settings(max_examples=300, deadline=None)
@given(at=st.integers(0, len(packed(MESSAGE)) - 1), bit=st.integers(0, 7))
def test_a_message_with_one_bit_changed_is_that_message_or_none(at: int, bit: int) -> None:
    line = bytearray(packed(MESSAGE))
    line[at] ^= 1 << bit
    # White space between JSON's words may change without changing what is said.
    assert unpacked(bytes(line)) in (None, MESSAGE)


@settings(max_examples=100, deadline=None)
@given(upto=st.integers(0, len(packed(MESSAGE)) - 1))
def test_a_message_that_is_cut_off_is_none(upto: int) -> None:
    assert unpacked(packed(MESSAGE)[:upto]) is None


@settings(max_examples=200, deadline=None)
@given(line=st.binary(max_size=100))
def test_any_bytes_are_no_message(line: bytes) -> None:
    assert unpacked(line) is None


@pytest.mark.parametrize(
    "parts",
    [
        {"number": 0},
        {"number": True},
        {"number": 1.5},
        {"sender": ""},
        {"sender": "x" * 101},
        {"kind": 7},
        {"content": []},
        {"more": 1},
    ],
)
def test_a_whole_message_of_wrong_parts_is_none(parts: dict[str, object]) -> None:
    body = json.dumps({**vars(MESSAGE), **parts})
    line = json.dumps({"schema": SCHEMA, "sha256": sha256(body), "message": body})
    assert unpacked(line.encode()) is None


@pytest.mark.parametrize("content", [{"loss": float("nan")}, {"policy": b"x"}])
def test_what_is_no_json_is_refused_before_it_is_kept(content: dict[str, object]) -> None:
    with pytest.raises(TransferError, match=r"cannot be written as JSON"):
        packed(Message(sender="robot", number=1, kind="experience", content=content))
