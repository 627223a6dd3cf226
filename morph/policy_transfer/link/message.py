"""A message with an identity and a hash, as bytes that a link may spoil."""

from __future__ import annotations

import json
from dataclasses import dataclass

from morph.arrays import JSON
from morph.errors import TransferError
from morph.files import sha256

SCHEMA = "morph.link/1"
"""The schema of every message."""

MOST_BYTES = 2**26
"""Most bytes of a message."""

LONGEST = 100
"""Most characters of a kind, and of a sender's name."""


@dataclass(frozen=True, kw_only=True)
class Message:
    """What one side tells the other."""

    sender: str
    """Who sends it."""
    number: int
    """Which of its sender's messages it is, from 1 on."""
    kind: str
    """What it is: `experience`, `policy`, `verdict`, or `received` for an acknowledgement."""
    content: JSON
    """What it says."""

    @property
    def identity(self) -> tuple[str, int]:
        """What no other message has."""
        return self.sender, self.number


def packed(message: Message) -> bytes:
    """Return a message as one line.

    Raises:
        TransferError: It cannot be written as JSON, or is too large.
    """
    try:
        body = json.dumps(vars(message), allow_nan=False, sort_keys=True)
    except (TypeError, ValueError) as error:
        raise TransferError(
            f"its content cannot be written as JSON: {error}",
            where=f"message {message.kind} of {message.sender}",
            fix="give texts, finite numbers, lists and objects of them",
        ) from error
    line = json.dumps({"schema": SCHEMA, "sha256": sha256(body), "message": body}).encode()
    if len(line) > MOST_BYTES:
        raise TransferError(
            f"it has {len(line)} bytes, more than {MOST_BYTES}",
            where=f"message {message.kind} of {message.sender}",
            fix="send it in parts",
        )
    return line


def unpacked(line: bytes) -> Message | None:
    """Return the message that a line holds; None if it is spoilt, or none."""
    if len(line) > MOST_BYTES:
        return None
    try:
        document = json.loads(line)
        body = document["message"]
        if document["schema"] != SCHEMA or document["sha256"] != sha256(body):
            return None
        parts = json.loads(body)
        message = Message(**parts)
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return None
    right = (
        isinstance(message.sender, str)
        and isinstance(message.kind, str)
        and 0 < len(message.sender) <= LONGEST
        and 0 < len(message.kind) <= LONGEST
        and type(message.number) is int
        and message.number > 0
        and isinstance(message.content, dict)
    )
    return message if right else None
