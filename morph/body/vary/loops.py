"""Closed chains on the way from one body to another."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from morph.body.vary.fade import HARDEST

CONNECT, WELD = mujoco.mjtEq.mjEQ_CONNECT, mujoco.mjtEq.mjEQ_WELD
SITE, BODY = mujoco.mjtObj.mjOBJ_SITE, mujoco.mjtObj.mjOBJ_BODY

Key = tuple[int, str, str, int]
"""The kind of a loop, its two links, and which it is of those."""


def loops(spec: Any) -> dict[Key, Any]:
    """Return the constraints that close chains, by kind and links."""
    results: dict[Key, Any] = {}
    for each in spec.equalities:
        if each.type in (CONNECT, WELD):
            kind = (int(each.type), *_links(spec, each))
            results[*kind, sum(key[:3] == kind for key in results)] = each
    return results


def fade_loops(spec: Any, ends: tuple[Any, Any], fraction: float, sizes: dict[str, float]) -> None:
    """Give a spec the loops that only one of two bodies has, as far as they are there.

    Such a loop holds its links where they stand at home: a link that is not
    whole would not reach its place in the loop. Its impedance is that of the
    whole loop times its presence.

    Args:
        spec: The body between; its links have their places and sizes.
        ends: The two bodies.
        fraction: Where between them, 0 to 1.
        sizes: The scale of every link.
    """
    first, second = (loops(end) for end in ends)
    have = loops(spec)
    for key in first.keys() ^ second.keys():
        if key in have:
            spec.delete(have[key])
        end, presence = (0, 1 - fraction) if key in first else (1, fraction)
        if presence > 0:
            _add(spec, ends[end], (first, second)[end][key], presence, sizes)


def _links(spec: Any, loop: Any) -> tuple[str, str]:
    names = loop.name1, loop.name2 or "world"
    if loop.objtype == SITE:
        names = tuple(spec.site(name).parent.name for name in names)
    return names[0], names[1]


def _add(spec: Any, end: Any, loop: Any, presence: float, sizes: dict[str, float]) -> None:
    names = _links(end, loop)
    # A weld gives its anchor in the second body, a connect in the first.
    holder = names[0] if loop.type == CONNECT else names[1]
    data = np.array(loop.data)
    if loop.objtype == SITE:
        data[:3] = end.site(loop.name1 if loop.type == CONNECT else loop.name2).pos
    data[:3] *= sizes.get(holder, 1.0)
    data[3:10] = 0.0  # MuJoCo then takes the pose at home.
    copy = spec.add_equality(name=loop.name, type=loop.type, name1=names[0], name2=names[1])
    copy.objtype, copy.active, copy.data = BODY, loop.active, data
    copy.solref = loop.solref.copy()
    solimp = loop.solimp.copy()
    solimp[:2] = np.clip(solimp[:2] * presence, 1 - HARDEST, HARDEST)
    copy.solimp = solimp
