"""Taking a link off a body."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from morph.body.vary.keys import keeping_keys
from morph.body.vary.operation import Operation
from morph.body.vary.part import link, links
from morph.body.vary.unhook import JOINT, unhook


@dataclass(frozen=True, kw_only=True)
class Drop(Operation):
    """A body without a link and without all that hangs from it.

    Their joints go with them, and whatever refers to either: actuators,
    sensors, tendons, equalities. The links that stay keep every number.
    """

    name: ClassVar[str] = "drop"

    link: str
    """The link."""

    def apply(self, spec: Any) -> None:
        """Delete the link's subtree and all that refers to it."""
        body = link(spec, self.link)
        below = [body, *body.find_all("body")]
        if len(below) == len(links(spec)):
            raise self.refuse("no link would be left", "drop a link that does not carry all others")
        with keeping_keys(spec):
            for each in [joint for part in below for joint in part.joints]:
                unhook(spec, JOINT, each.name)
            spec.delete(body)
