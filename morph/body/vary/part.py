"""Finding the links and joints that an operation names."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import Any

import mujoco

from morph.errors import RobotError

WHOLE = "*"
"""The name that stands for every link."""


def unknown(kind: str, name: str, known: Iterable[str], where: str) -> RobotError:
    """Return the error for a name that is not there, with the nearest names."""
    names = list(known)
    nearest = difflib.get_close_matches(name, names, n=3, cutoff=0.0)
    near = ", ".join(repr(each) for each in nearest) or "none, as it has none"
    return RobotError(
        f"there is no {kind} {name!r}; the nearest names are {near}",
        where=where,
        fix=f"name one of: {', '.join(names) or 'nothing'}",
    )


def links(spec: Any) -> list[Any]:
    """Return every body of a spec but the world."""
    return list(spec.bodies[1:])


def link(spec: Any, name: str) -> Any:
    """Return the body of a link.

    Raises:
        RobotError: There is no such link.
    """
    for body in links(spec):
        if body.name == name:
            return body
    raise unknown("link", name, (body.name for body in links(spec)), _where(spec))


def chosen(spec: Any, name: str) -> list[Any]:
    """Return the bodies that a name stands for: one, or all for `*`.

    Raises:
        RobotError: There is no such link.
    """
    return links(spec) if name == WHOLE else [link(spec, name)]


def joint(spec: Any, name: str) -> Any:
    """Return a joint by its name, or by that of the link that it alone moves.

    Raises:
        RobotError: There is no such joint.
    """
    for each in spec.joints:
        if each.name == name:
            return each
    for body in links(spec):
        if body.name == name and len(body.joints) == 1:
            return body.joints[0]
    raise unknown("joint", name, (each.name for each in spec.joints), _where(spec))


def anchor(body: Any) -> Any:
    """Return where a link hangs in its own frame: its first joint, else its origin; m, (3,)."""
    for each in body.joints:
        if each.type != mujoco.mjtJoint.mjJNT_FREE:
            return each.pos.copy()
    return body.pos * 0.0


def _where(spec: Any) -> str:
    return f"robot {spec.modelname}"
