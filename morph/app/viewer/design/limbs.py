"""Joints in groups that a person can find their way in."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from morph.body.posture import Handle
from morph.body.robot import Robot

FEW = 12
"""So many sliders are in sight at once."""


@dataclass(frozen=True, kw_only=True)
class JointChain:
    """Joints one after another."""

    title: str
    """What the group is called; empty if it needs no title."""
    handles: tuple[Handle, ...]
    """Its joints, from the base outward."""


def found(handles: Sequence[Handle], sought: str) -> tuple[Handle, ...]:
    """Return the joints whose name or link's name holds a text, whatever its case.

    Words apart all must be in it: `left knee` finds `left_leg_knee`.
    """
    words = sought.casefold().split()
    return tuple(
        handle
        for handle in handles
        if all(word in f"{handle.joint} {handle.link}".casefold() for word in words)
    )


def limbs(robot: Robot, handles: Sequence[Handle]) -> tuple[JointChain, ...]:
    """Return joints in groups of at most `FEW`.

    A group is a chain: it ends where the body branches. Chains of one joint that hang from one
    link are gathered, and a chain that is too long is cut.
    """
    if len(handles) <= FEW:
        return (JointChain(title="", handles=tuple(handles)),) if handles else ()
    chains = _chains(robot, handles)
    long = [chain for chain in chains if len(chain) > 1]
    alone = [chain[0] for chain in chains if len(chain) == 1]
    results = [
        JointChain(title=_title(part), handles=part) for chain in long for part in _pages(chain)
    ]
    rest = [JointChain(title=f"others ({len(part)})", handles=part) for part in _pages(alone)]
    return tuple(results + rest)


def _pages(chain: Sequence[Handle]) -> list[tuple[Handle, ...]]:
    """Return a chain cut into parts of at most `FEW`, as alike as can be."""
    if not chain:
        return []
    parts = -(-len(chain) // FEW)
    size = -(-len(chain) // parts)
    return [tuple(chain[start : start + size]) for start in range(0, len(chain), size)]


def _chains(robot: Robot, handles: Sequence[Handle]) -> list[list[Handle]]:
    parents = {link.name: link.parent for link in robot.links}
    moved: dict[str, list[Handle]] = {}
    for handle in handles:
        moved.setdefault(handle.link, []).append(handle)

    def above(link: str) -> str:
        link = parents.get(link, "world")
        while link in parents and link not in moved:
            link = parents[link]
        return link

    below: dict[str, list[str]] = {}
    for link in moved:
        below.setdefault(above(link), []).append(link)
    chains: list[list[Handle]] = []
    # Links are visited in the description's order; one that is alone below another goes on.
    inside: dict[str, list[Handle]] = {}
    for link in moved:
        over = above(link)
        chain = inside.get(over) if len(below[over]) == 1 else None
        if chain is None:
            chain = []
            chains.append(chain)
        chain += moved[link]
        inside[link] = chain
    return chains


def _title(chain: Sequence[Handle]) -> str:
    return f"{chain[0].joint} … {chain[-1].joint} ({len(chain)})"
