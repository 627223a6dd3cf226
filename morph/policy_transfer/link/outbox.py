"""Outbox of one end of an intermittent link: at-least-once delivery, duplicates removed."""

from __future__ import annotations

import secrets
import time
from collections.abc import Callable
from pathlib import Path

from morph.arrays import JSON
from morph.errors import LinkDropped, TransferError
from morph.policy_transfer.link.journal import Journal
from morph.policy_transfer.link.link import MessageLink
from morph.policy_transfer.link.message import Message, packed, unpacked

RECEIVED = "received"
"""Kind of the message that acknowledges another."""

MOST_ENTRIES = 1000
"""Entries of a journal that are done with before it is written anew without them."""


class Post:
    """Messages of one side, kept on the disk until the other side has them.

    What is put is on the disk before `put` returns, and is sent again and again until it is
    acknowledged. What arrives is on the disk before it is acknowledged, and what arrives again
    is acknowledged again and else forgotten. So every message comes to `waiting` exactly once,
    whatever the link does and whenever either side is killed; one that was being handled when
    its side was killed is there again.

    Args:
        link: The way to the other side.
        folder: Where messages are kept; one process at a time uses it.
        name: Who sends them; the other side sees it with a token of this folder.
        again: How long to wait for an acknowledgement before a message is sent again, s.
        clock: A monotonic clock, s.

    Raises:
        TransferError: The folder cannot be used, or is spoilt.
    """

    def __init__(
        self,
        link: MessageLink,
        folder: Path,
        *,
        name: str,
        again: float = 5.0,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._link, self._again, self._clock = link, again, clock
        self._out = Journal(folder / "outbox.journal")
        try:
            self._in = Journal(folder / "inbox.journal")
        except TransferError:
            self._out.close()
            raise
        self._sent: dict[int, float] = {}
        self.spoilt = 0
        """Messages that arrived spoilt; they come again."""
        self.last = 0
        """The number of the last message that was put."""
        self._restore(name)

    def _restore(self, name: str) -> None:
        """Read what was left by whoever had the folder before."""
        if not self._out.entries:
            # A folder that was deleted must not send its numbers again under the same name.
            self._out.add({"sender": f"{name}-{secrets.token_hex(4)}"})
        self.sender = str(self._out.entries[0]["sender"])
        self.last = int(self._out.entries[0].get("last", 0))
        self._pending: dict[int, Message] = {}
        for entry in self._out.entries[1:]:
            if "put" in entry:
                message = Message(**entry["put"])
                self._pending[message.number], self.last = message, message.number
            else:
                self._pending.pop(entry["done"], None)
        self._seen: set[tuple[str, int]] = set()
        self._waiting: dict[tuple[str, int], Message] = {}
        for entry in self._in.entries:
            if "got" in entry:
                message = Message(**entry["got"])
                self._seen.add(message.identity)
                self._waiting[message.identity] = message
            else:
                identity = (entry["handled"][0], entry["handled"][1])
                self._seen.add(identity)
                self._waiting.pop(identity, None)

    def put(self, kind: str, content: JSON) -> int:
        """Return the number of a message that will be sent, now that it is on the disk.

        Raises:
            TransferError: It cannot be written, or is too large.
        """
        message = Message(sender=self.sender, number=self.last + 1, kind=kind, content=content)
        packed(message)
        self._out.add({"put": vars(message)})
        self.last = message.number
        self._pending[message.number] = message
        return message.number

    @property
    def pending(self) -> int:
        """How many messages the other side has not acknowledged."""
        return len(self._pending)

    def exchange(self) -> bool:
        """Send what is due and take what has arrived; return whether the link was up."""
        try:
            arrived = self._link.receive()
            for line in arrived:
                self._take(line)
            now = self._clock()
            for number, message in sorted(self._pending.items()):
                if now - self._sent.get(number, -float("inf")) >= self._again:
                    self._link.send(packed(message))
                    self._sent[number] = now
        except LinkDropped:
            return False
        return True

    def _take(self, line: bytes) -> None:
        message = unpacked(line)
        if message is None:
            self.spoilt += 1
            return
        if message.kind == RECEIVED:
            if message.content.get("of") == self.sender:
                self._done(message.content.get("number"))
            return
        if message.identity not in self._seen:
            self._in.add({"got": vars(message)})
            self._seen.add(message.identity)
            self._waiting[message.identity] = message
        content = {"of": message.sender, "number": message.number}
        self._acknowledge(Message(sender=self.sender, number=1, kind=RECEIVED, content=content))

    def _acknowledge(self, message: Message) -> None:
        try:
            self._link.send(packed(message))
        except LinkDropped:
            # The other side sends its message again, and is answered then.
            return

    def _done(self, number: object) -> None:
        if not isinstance(number, int) or number not in self._pending:
            return
        self._out.add({"done": number})
        del self._pending[number]
        self._sent.pop(number, None)
        if len(self._out.entries) > MOST_ENTRIES + 2 * len(self._pending):
            first = {"sender": self.sender, "last": self.last}
            left = [{"put": vars(each)} for _, each in sorted(self._pending.items())]
            self._out.rewrite([first, *left])

    def waiting(self) -> list[Message]:
        """Return what has arrived and is not handled, in the order in which it was sent."""
        return sorted(self._waiting.values(), key=lambda each: each.identity)

    def handled(self, message: Message) -> None:
        """Say that a message need not come to `waiting` again."""
        self._in.add({"handled": list(message.identity)})
        self._waiting.pop(message.identity, None)
        if len(self._in.entries) > MOST_ENTRIES + 2 * len(self._seen):
            done = [{"handled": list(each)} for each in sorted(self._seen - set(self._waiting))]
            self._in.rewrite([*done, *({"got": vars(each)} for each in self.waiting())])

    def close(self) -> None:
        """Let another process have the folder."""
        self._out.close()
        self._in.close()
