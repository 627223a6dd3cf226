"""Maps one after another: from the first body of a chain to its last."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar

import numpy as np

from morph.alignment.arrays import Array
from morph.alignment.errors import MapError
from morph.alignment.maps.affine_map import AffineMap
from morph.alignment.maps.body_map import BodyMap

MOST_LINKS = 64
"""Most maps of a chain that a file may hold."""

PART = re.compile(r"([0-9]{1,2})\.([a-z]+)\.([a-z_.0-9]+)")
"""How the weights of one link are named: its place, its kind, its number."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ChainMap(BodyMap):
    """The maps of a chain's hops, seen as one between its two ends.

    Composition asks that each map holds where the one after it leads; what errs in one hop is
    carried through the others. To learn anew at each body is the task of a relay, not of this.
    """

    kind: ClassVar[str] = "chain"

    links: tuple[BodyMap, ...]
    """One map for each hop, the source's first."""

    def __post_init__(self) -> None:
        """Check that there is a map."""
        if not 1 <= len(self.links) <= MOST_LINKS:
            raise MapError(
                f"it has {len(self.links)} maps",
                where="a chain of maps",
                fix=f"give 1 to {MOST_LINKS}, one for each hop",
            )

    def state(self, target: Array) -> Array:
        """Return the last body's states as the first one's."""
        return self._seen(target)[0]

    def state_back(self, source: Array) -> Array:
        """Return states of the last body that are these of the first."""
        for link in self.links:
            source = link.state_back(source)
        return source

    def action(self, target: Array, command: Array) -> Array:
        """Return what to tell the last body for a command of the first."""
        for link, there in zip(self.links, self._seen(target)[1:], strict=True):
            command = link.action(there, command)
        return command

    def action_back(self, target: Array, command: Array) -> Array:
        """Return what a command of the last body is to the first."""
        for link, there in zip(reversed(self.links), reversed(self._seen(target)[1:]), strict=True):
            command = link.action_back(there, command)
        return command

    def weights(self) -> Mapping[str, Array]:
        """Return the numbers of every link, named by its place and kind."""
        return {
            f"{place}.{link.kind}.{name}": value
            for place, link in enumerate(self.links)
            for name, value in link.weights().items()
        }

    @classmethod
    def of(cls, weights: Mapping[str, Array]) -> ChainMap:
        """Return the chain that these numbers make."""
        # The list of all maps names this one: it is asked for only now.
        from morph.alignment.maps.maps import kind_of

        parts: dict[tuple[int, str], dict[str, Array]] = {}
        for name, value in weights.items():
            match = PART.fullmatch(name)
            if match is None or match[2] == cls.kind:
                raise MapError(
                    f"{name!r} names no number of a map in a chain",
                    where="a chain of maps",
                    fix="name each by place, kind and number, such as 0.affine.state_law",
                )
            parts.setdefault((int(match[1]), match[2]), {})[match[3]] = value
        places = sorted(place for place, _ in parts)
        if places != list(range(len(places))):
            raise MapError(
                f"its maps stand at the places {places}",
                where="a chain of maps",
                fix="give each place from 0 on one map of one kind",
            )
        return cls(
            links=tuple(kind_of(kind).of(parts[place, kind]) for place, kind in sorted(parts))
        )

    def _seen(self, target: Array) -> list[Array]:
        """Return the state at each body, the first body's first."""
        seen = [np.asarray(target)]
        for link in reversed(self.links):
            seen.append(link.state(seen[-1]))
        return seen[::-1]


def composed(links: Sequence[BodyMap]) -> BodyMap:
    """Return the map of a whole chain: one affine map if all are affine, else a `ChainMap`.

    Args:
        links: One map for each hop, the source's first.

    Raises:
        MapError: There is none, or two that follow each other do not share a body.
    """
    affine = [link for link in links if isinstance(link, AffineMap)]
    for first, second in pairwise(affine if len(affine) == len(links) else ()):
        ours = (len(first.lift_shift), len(first.action_shift))
        theirs = (len(second.state_shift), len(second.read_shift))
        if ours != theirs:
            raise MapError(
                f"one ends at a body with {ours} states and commands, the next begins at {theirs}",
                where="a chain of maps",
                fix="give the maps in the order of the bodies, the source's first",
            )
    if not affine or len(affine) < len(links):
        return ChainMap(links=tuple(links))
    whole = affine[0]
    for link in affine[1:]:
        whole = _joined(whole, link)
    return whole


def _joined(first: AffineMap, second: AffineMap) -> AffineMap:
    """Return `first` after `second`, written out."""
    return AffineMap(
        state_law=first.state_law @ second.state_law,
        state_shift=first.state_law @ second.state_shift + first.state_shift,
        lift_law=second.lift_law @ first.lift_law,
        lift_shift=second.lift_law @ first.lift_shift + second.lift_shift,
        action_law=second.action_law @ first.action_law,
        action_state=second.action_law @ first.action_state @ second.state_law
        + second.action_state,
        action_shift=second.action_law
        @ (first.action_state @ second.state_shift + first.action_shift)
        + second.action_shift,
        read_law=first.read_law @ second.read_law,
        read_state=first.read_law @ second.read_state + first.read_state @ second.state_law,
        read_shift=first.read_law @ second.read_shift
        + first.read_state @ second.state_shift
        + first.read_shift,
    )
