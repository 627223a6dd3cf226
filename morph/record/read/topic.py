"""Topics of a bag and their messages, still packed, within bounds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from morph.errors import RecordingError
from morph.record.limits import MOST_CHUNK, MOST_COLUMNS, too_much
from morph.record.read.unpack import unpack


@dataclass(frozen=True, kw_only=True)
class Topic:
    """One topic."""

    name: str
    """As it stands in the bag, for example `/joint_states`."""
    kind: str
    """The type of its messages, for example `sensor_msgs/msg/JointState`."""
    encoding: str
    """How they are packed; ROS 2 packs as `cdr`."""


Wants = Callable[[Topic], bool]
"""Whether a topic's messages are to be read."""


@dataclass(kw_only=True)
class Messages:
    """What is read of a bag, over all of its files."""

    wants: Wants
    """Whether a topic's messages are to be read."""
    most: int
    """Most bytes that they may take."""
    codec: str = ""
    """How each message is compressed by itself; empty if none is."""
    found: dict[Topic, list[tuple[int, bytes]]] = field(default_factory=dict)
    """Log time, ns, and contents of each message; none for a topic that is not wanted."""
    counts: dict[Topic, int] = field(default_factory=dict)
    """How many messages each topic has."""
    held: int = 0
    """Bytes held so far."""

    def meet(self, topic: Topic, path: Path) -> bool:
        """Take note of a topic; return whether its messages are to be read.

        Raises:
            RecordingError: The bag has absurdly many topics.
        """
        if topic not in self.found:
            if len(self.found) >= MOST_COLUMNS:
                raise RecordingError(
                    f"the bag has more than {MOST_COLUMNS} topics",
                    where=str(path),
                    fix="record the topics that are needed, or check what wrote the file",
                )
            self.found[topic] = []
            self.counts[topic] = 0
        return self.wants(topic)

    def add(self, topic: Topic, time: int, data: bytes, path: Path) -> None:
        """Keep one message of a topic that is wanted.

        Raises:
            RecordingError: The messages take more memory than any recording should,
                or cannot be unpacked.
        """
        if self.codec:
            data = self._unpacked(topic, data, path)
        # Python's own objects around a message take about as much as a small one.
        self.held += len(data) + 128
        if self.held > self.most:
            raise too_much(
                f"the messages on the topics to be read take more than {self.most} bytes",
                f"{path}, topic {topic.name}",
            )
        self.found[topic].append((time, data))

    def _unpacked(self, topic: Topic, data: bytes, path: Path) -> bytes:
        unpacked = unpack(data, self.codec, min(MOST_CHUNK, self.most))
        if unpacked is None:
            raise RecordingError(
                f"a message is damaged, has more than {min(MOST_CHUNK, self.most)} bytes, "
                f"or is not compressed by {self.codec}",
                where=f"{path}, topic {topic.name}, message {len(self.found[topic]) + 1}",
                fix="copy the bag again, or record it without compression",
            )
        return unpacked
