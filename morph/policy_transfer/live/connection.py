"""How morph speaks with a live target, whatever it is made of."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from morph.arrays import JSON
from morph.policy_transfer.live.protocol import Hello


@dataclass(frozen=True, kw_only=True)
class Heard:
    """One message of a target, or what cannot be read as one."""

    at: float
    """When it came, s on the clock of `time.monotonic`."""
    said: JSON = field(default_factory=dict)
    """The message."""
    unreadable: str = ""
    """Why it is none, in words; empty if it is one."""
    ended: str = ""
    """Why no more will come, in words; empty if more may."""


class Connection(ABC):
    """A live target: it says who it is, begins when told, and answers with states.

    After `begin` it sends a first state as soon as it is ready, then one each control period:
    by its own clock, or one for each command, as its `Hello` says. Every message has the form
    that `morph.policy_transfer.live.protocol` describes, wherever it runs.
    """

    name: str
    """How messages call it."""

    @abstractmethod
    def open(self, seconds: float) -> Hello:
        """Return what it says of itself; a connection that is open says it again.

        Raises:
            TransferError: It cannot be started, or says nothing that can be used.
        """

    @abstractmethod
    def begin(self, message: Mapping[str, Any]) -> None:
        """Tell it to go to where trials begin, and to send states from there."""

    @abstractmethod
    def tell(self, command: Mapping[str, float]) -> None:
        """Tell it commands by actuator, held until the next."""

    @abstractmethod
    def hear(self, seconds: float) -> Heard | None:
        """Return its next message, waiting at most so long; None if none came."""

    @abstractmethod
    def stop(self, seconds: float) -> bool:
        """Tell it to stop and hold itself safe; return whether it said in time that it did."""

    @abstractmethod
    def close(self) -> None:
        """Let it go; it must hold itself safe when nobody speaks with it."""
