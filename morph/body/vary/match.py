"""Which links, joints and actuators of two bodies are each other's counterparts."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from morph.body.vary.part import link, links
from morph.errors import RobotError

WORLD = "world"
"""MuJoCo's name for what carries the roots."""


@dataclass(frozen=True, kw_only=True)
class Match:
    """For the second body, the name that each part bears beside the first body."""

    links: dict[str, str]
    """By the second body's name: its counterpart's in the first, or one that is free there."""
    joints: dict[str, str]
    """The same of joints."""
    actuators: dict[str, str]
    """The same of actuators."""


def match(first: Any, second: Any, mapping: Mapping[str, str] | None) -> Match:
    """Return the counterparts of two specs' parts.

    Links are those of the mapping. Without one they are those of equal names,
    and then, below every pair, the children whose joints are of equal kinds,
    those first whose subtrees are most alike in size; not if pairs below them
    would then cross. A pair's joints are matched by kind, in order, and a
    joint's actuators in order.

    Raises:
        RobotError: The mapping names a link that is not there, or one twice.
    """
    pairs = _given(first, second, mapping) if mapping is not None else _found(first, second)
    joints: dict[str, str] = {}
    for one, other in pairs.items():
        joints |= {b: a for a, b in _joints(link(first, one), link(second, other))}
    actuators: dict[str, str] = {}
    for theirs, ours in joints.items():
        of_second = [each.name for each in second.actuators if each.target == theirs]
        of_first = [each.name for each in first.actuators if each.target == ours]
        actuators |= dict(zip(of_second, of_first, strict=False))
    return Match(
        links=_named({b: a for a, b in pairs.items()}, links(first), links(second)),
        joints=_named(joints, first.joints, second.joints),
        actuators=_named(actuators, first.actuators, second.actuators),
    )


def parents(spec: Any) -> dict[str, str]:
    """Return the parent of every link by name, in the description's order."""
    return {body.name: body.parent.name for body in links(spec)}


def _given(first: Any, second: Any, mapping: Mapping[str, str]) -> dict[str, str]:
    for one, other in mapping.items():
        link(first, one)
        link(second, other)
    if len(set(mapping.values())) < len(mapping):
        raise RobotError(
            f"the mapping {dict(mapping)} gives one link two counterparts",
            where=f"robot {second.modelname}",
            fix="map each link of the first body to another link of the second",
        )
    return dict(mapping)


def _found(first: Any, second: Any) -> dict[str, str]:
    ours, theirs = _children(first), _children(second)
    names = {body.name for body in links(second)}
    pairs = {body.name: body.name for body in links(first) if body.name in names}
    waiting = [(WORLD, WORLD), *pairs.items()]
    while waiting:
        one, other = waiting.pop(0)
        left = [name for name in ours[one] if name not in pairs]
        right = [name for name in theirs[other] if name not in pairs.values()]
        candidates = sorted(
            (abs(len(_below(ours, a)) - len(_below(theirs, b))), abs(i - j), a, b)
            for i, a in enumerate(left)
            for j, b in enumerate(right)
            if _kinds(link(first, a)) == _kinds(link(second, b))
            and {pairs[x] for x in _below(ours, a) if x in pairs}
            == {y for y in _below(theirs, b) if y in pairs.values()}
        )
        for _, _, a, b in candidates:
            if a not in pairs and b not in pairs.values():
                pairs[a] = b
                waiting.append((a, b))
    return pairs


def _children(spec: Any) -> dict[str, list[str]]:
    results: dict[str, list[str]] = {name: [] for name in (WORLD, *parents(spec))}
    for name, parent in parents(spec).items():
        results[parent].append(name)
    return results


def _below(children: dict[str, list[str]], name: str) -> list[str]:
    return [name, *(each for child in children[name] for each in _below(children, child))]


def _kinds(body: Any) -> list[int]:
    return [int(joint.type) for joint in body.joints]


def _joints(one: Any, other: Any) -> list[tuple[str, str]]:
    # In order on both sides: what follows a joint moves with it.
    left = list(other.joints)
    pairs = []
    for joint in one.joints:
        at = next((i for i, each in enumerate(left) if each.type == joint.type), None)
        if at is not None:
            pairs.append((joint.name, left[at].name))
            left = left[at + 1 :]
    return pairs


def _named(matched: dict[str, str], first: Iterable[Any], second: Iterable[Any]) -> dict[str, str]:
    taken = {part.name for part in first} | set(matched.values())
    names = dict(matched)
    for part in second:
        if part.name not in names:
            name, number = part.name, 2
            while name in taken:
                name, number = f"{part.name}_{number}", number + 1
            taken.add(name)
            names[part.name] = name
    return names
