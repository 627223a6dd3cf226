"""In-process link that drops, delays, repeats and reorders messages, for tests."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.errors import LinkDropped
from morph.policy_transfer.link.link import MessageLink


@dataclass(frozen=True, kw_only=True)
class Weather:
    """How likely each fault is, for each message."""

    down: float = 0.0
    """That the link is down; half of what is sent then arrives all the same."""
    lost: float = 0.0
    """That it is lost without a word."""
    late: float = 0.0
    """That it is held back, and let go in any order."""
    twice: float = 0.0
    """That it arrives twice."""
    spoilt: float = 0.0
    """That some of its bytes change, or its end is cut off."""


class Rough(MessageLink):
    """Another link in bad weather.

    Args:
        link: The link.
        weather: How bad it is.
        rng: The chance.
    """

    def __init__(self, link: MessageLink, weather: Weather, rng: np.random.Generator) -> None:
        self._link, self._rng, self.weather = link, rng, weather
        self._held: list[bytes] = []

    def send(self, message: bytes) -> None:
        """Send a message, or something like it, or nothing."""
        chance, weather = self._rng.random(5), self.weather
        down = chance[0] < weather.down
        if not down or self._rng.random() < 0.5:
            for _ in range(2 if chance[3] < weather.twice else 1):
                if chance[1] >= weather.lost:
                    self._pass(message, spoilt=bool(chance[4] < weather.spoilt))
        if down:
            raise LinkDropped("is down", where="a rough link", fix="try again")

    def _pass(self, message: bytes, *, spoilt: bool) -> None:
        if spoilt:
            message = self._spoil(message)
        if self._rng.random() < self.weather.late:
            self._held.append(message)
        else:
            self._link.send(message)

    def _spoil(self, message: bytes) -> bytes:
        at = int(self._rng.integers(len(message)))
        if self._rng.random() < 0.5:
            return message[:at]
        return message[:at] + bytes([message[at] ^ 1]) + message[at + 1 :]

    def receive(self) -> list[bytes]:
        """Return what arrives, once some of what was held back is let go."""
        if self._rng.random() < self.weather.down:
            raise LinkDropped("is down", where="a rough link", fix="try again")
        held, self._held = self._held, []
        for at in self._rng.permutation(len(held)):
            if self._rng.random() < self.weather.late:
                self._held.append(held[at])
            else:
                self._link.send(held[at])
        arrived = self._link.receive()
        return [arrived[at] for at in self._rng.permutation(len(arrived))]


class InProcessLink(MessageLink):
    """One end of a link within a program; `pair` makes both."""

    def __init__(self, sends: list[bytes], receives: list[bytes]) -> None:
        self._sends, self._receives = sends, receives

    def send(self, message: bytes) -> None:
        """Hand a message over."""
        self._sends.append(message)

    def receive(self) -> list[bytes]:
        """Return what the other end handed over."""
        arrived = self._receives.copy()
        self._receives.clear()
        return arrived


def pair() -> tuple[InProcessLink, InProcessLink]:
    """Return the two ends of a link within a program."""
    there: list[bytes] = []
    back: list[bytes] = []
    return InProcessLink(there, back), InProcessLink(back, there)
