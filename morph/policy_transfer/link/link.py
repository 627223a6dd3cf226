"""A way to a service that is often closed: what it may do, and what it may not."""

from __future__ import annotations

from abc import ABC, abstractmethod


class MessageLink(ABC):
    """Sends and receives messages, when it can.

    It may lose, delay, repeat, reorder and spoil messages: what is built on it numbers them,
    hashes them and sends them again until they are acknowledged.
    """

    @abstractmethod
    def send(self, message: bytes) -> None:
        """Hand a message over.

        Raises:
            LinkDropped: The link is down; the message may or may not arrive.
        """

    @abstractmethod
    def receive(self) -> list[bytes]:
        """Return what has arrived since it was last asked, without waiting.

        Raises:
            LinkDropped: The link is down.
        """
