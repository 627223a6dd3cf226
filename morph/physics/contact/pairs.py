"""The contacts that an effect means, as explicit pairs of shapes that effects share."""

from __future__ import annotations

from itertools import product
from typing import Any

import mujoco
import numpy as np

from morph.errors import EffectError
from morph.physics.contact.floor import FLOOR, floor_of

ANY = "any"
"""Stands for every link in `any+floor`."""


def pairs_of(spec: Any, contact: str, where: str) -> list[Any]:
    """Return the pairs of shapes that touch where two bodies do, made where missing.

    A pair starts with what MuJoCo would have mixed from its two shapes, so making it
    changes nothing; the effects on one contact then each set their own part of it.
    Shapes that MuJoCo would not let collide (by their masks, in one rigid body, in
    parent and child, or excluded) get no pair.

    Args:
        spec: A `mujoco.MjSpec`.
        contact: Two links joined by `+`; `floor` is the world, `any` every link.
        where: The effect, for the error.

    Raises:
        EffectError: The contact does not name two bodies of this robot.
    """
    one, plus, two = contact.partition("+")
    if FLOOR in (one, two):
        floor_of(spec, where)
    sides = [_bodies(spec, name) for name in (one, two)]
    if not plus or not all(sides):
        raise EffectError(
            f"{contact!r} does not name two bodies of this robot",
            where=where,
            fix="say `link+floor`, `any+floor` or `link+link`, in the description's names",
        )
    excluded = {frozenset((e.bodyname1, e.bodyname2)) for e in spec.excludes}
    known = {frozenset((pair.geomname1, pair.geomname2)): pair for pair in spec.pairs}
    results = []
    for first, second in product(*sides):
        apart = _apart(spec, first, second) and {first.name, second.name} not in excluded
        for shape, other in product(first.geoms, second.geoms):
            there = known.get(frozenset((shape.name, other.name)))
            if there is not None:
                results.append(there)
            elif apart and _collide(shape, other):
                results.append(_pair(spec, shape, other))
    return results


def _bodies(spec: Any, name: str) -> list[Any]:
    world = spec.worldbody
    if name == ANY:
        return [body for body in spec.bodies if body.name != world.name]
    body = world if name == FLOOR else spec.body(name)
    return [] if body is None else [body]


def _carrier(spec: Any, body: Any) -> Any:
    """Return the first body upwards that a joint moves, or the world."""
    while body.name != spec.worldbody.name and not body.joints:
        body = body.parent
    return body


def _apart(spec: Any, first: Any, second: Any) -> bool:
    """Return whether MuJoCo lets two bodies collide.

    Source: MuJoCo documentation, Computation, Collision, Selection: bodies without a
    joint between them are one, and a parent and its child do not collide unless the
    parent is the world.
    """
    world = spec.worldbody.name
    one, two = _carrier(spec, first), _carrier(spec, second)
    if one.name == two.name:
        return False
    if world in (one.name, two.name):
        return True
    if spec.option.disableflags & int(mujoco.mjtDisableBit.mjDSBL_FILTERPARENT):
        return True
    above = {_carrier(spec, body.parent).name for body in (one, two)}
    return not above & {one.name, two.name}


def _collide(shape: Any, other: Any) -> bool:
    return bool((shape.contype & other.conaffinity) or (other.contype & shape.conaffinity))


def _named(spec: Any, shape: Any) -> str:
    """Return a shape's name, given to it if it has none: a pair goes by names."""
    if not shape.name:
        taken = {geom.name for geom in spec.geoms}
        wanted = f"{shape.parent.name}.shape"
        shape.name = next(
            name
            for name in (f"{wanted}{number}" for number in range(len(taken) + 1))
            if name not in taken
        )
    return str(shape.name)


def _pair(spec: Any, shape: Any, other: Any) -> Any:
    """Return a new pair that holds what MuJoCo mixes from its two shapes.

    Source: MuJoCo documentation, Modeling, Contact parameters: the higher priority
    wins; otherwise the larger friction and dimension, and solver parameters weighted
    by solmix, or their minimum where one is in the direct format; margins and gaps add.
    """
    ordered = sorted((shape, other), key=lambda geom: -geom.priority)
    if ordered[0].priority > ordered[1].priority:
        ordered = ordered[:1]
    weights = np.array([geom.solmix for geom in ordered]) + 1e-15
    solref = np.array([geom.solref for geom in ordered])
    direct = (solref <= 0.0).any()
    slide, twist, roll = np.max([geom.friction for geom in ordered], axis=0)
    return spec.add_pair(
        geomname1=_named(spec, shape),
        geomname2=_named(spec, other),
        condim=max(int(geom.condim) for geom in ordered),
        friction=(slide, slide, twist, roll, roll),
        solref=solref.min(axis=0) if direct else np.average(solref, axis=0, weights=weights),
        solreffriction=(0.0, 0.0),
        solimp=np.average([geom.solimp for geom in ordered], axis=0, weights=weights),
        margin=shape.margin + other.margin,
        gap=shape.gap + other.gap,
    )
