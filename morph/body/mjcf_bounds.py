"""What an MJCF may ask for: no code, no other model, no more memory than a robot needs."""

from __future__ import annotations

from morph.body.numbers import float_or
from morph.body.urdf import MOST_LINKS, MOST_SHAPES
from morph.body.xml import MOST_ELEMENTS, Element
from morph.errors import RobotError

FORBIDDEN = ("plugin", "extension", "model")
"""Elements that load code or other models."""

GREATEST = {
    "count": 10_000,
    "nrow": 4096,
    "ncol": 4096,
    "width": 8192,
    "height": 8192,
    "nuser_body": 1000,
    "nuser_jnt": 1000,
    "nuser_geom": 1000,
    "nuser_site": 1000,
    "nuser_cam": 1000,
    "nuser_tendon": 1000,
    "nuser_actuator": 1000,
    "nuser_sensor": 1000,
    "nkey": 10_000,
    "nuserdata": 100_000,
    "njmax": 1_000_000,
    "nconmax": 1_000_000,
    "nstack": 100_000_000,
    "maxhullvert": 100_000,
    "octree_maxdepth": 10,
    "maxcontacts": 100_000,
    "order": 10,
    "nsample": 10_000,
    "dim": 10_000,
    "params": 200,
}
"""Greatest value of attributes by which a few letters ask for much memory."""

MOST_MEMORY = 2**28
"""Most memory that an MJCF may ask for, bytes."""

MOST_PIXELS = 2**24
"""Most pixels of all textures, and most points of all height fields."""

MOST = {"body": ("bodies", MOST_LINKS), "geom": ("geoms", MOST_SHAPES)}
"""Most elements of a kind once all copies are made; as many as of a URDF."""

ALL = ("elements", MOST_ELEMENTS)
"""Most elements of all kinds, with their copies."""

COPIERS = ("replicate", "composite", "flexcomp")
"""Elements with a `count` of copies."""


def check_bounds(tree: Element) -> None:
    """Refuse an MJCF that runs code, or asks for more than a robot needs.

    Raises:
        RobotError: So it is; the line is named.
    """
    points = {"texture": 0.0, "hfield": 0.0}
    for element in tree.everything():
        _check(element)
        if element.tag in points:
            points[element.tag] += _points(element)
            if points[element.tag] > MOST_PIXELS:
                raise RobotError(
                    f"the {element.tag}s up to this one have more than {MOST_PIXELS} points",
                    where=element.place,
                    fix="make them smaller",
                )
    _check_copies(tree, 1.0, {})


def _check(element: Element) -> None:
    if element.tag in FORBIDDEN:
        raise RobotError(
            f"<{element.tag}> loads code or another model, which descriptions from strangers "
            "may not",
            where=element.place,
            fix="describe the robot in one file, without it",
        )
    # MuJoCo 4.0 takes some of its own messages for formats, and so a name's % for a command.
    for key, value in element.attrib.items():
        if "%" in value:
            raise RobotError(
                f"<{element.tag}> has a per cent sign in {key}={value[:80]!r}",
                where=element.place,
                fix="write it without the sign",
            )
    for key, greatest in GREATEST.items():
        for word in element.get(key, "").split() if key in element.attrib else ():
            if abs(float_or(word, 0.0)) > greatest:
                raise RobotError(
                    f"<{element.tag}> asks for {key}={word}; {greatest} are allowed",
                    where=element.place,
                    fix="ask for less",
                )
    if "memory" in element.attrib and _bytes(element.get("memory", "")) > MOST_MEMORY:
        raise RobotError(
            f"<{element.tag}> asks for {element.get('memory')} of memory",
            where=element.place,
            fix="leave memory out; MuJoCo knows how much it needs",
        )


def _points(element: Element) -> float:
    if element.tag == "hfield":
        return float_or(element.get("nrow", ""), 0.0) * float_or(element.get("ncol", ""), 0.0)
    width = float_or(element.get("width", ""), 0.0)
    height = float_or(element.get("height", ""), 0.0)
    # A cube has six sides; one whose sides are already stacked is six times as high.
    sides = 1 if element.get("type") == "2d" or height >= 6 * width else 6
    return sides * width * height if element.get("builtin", "none") != "none" else 0.0


def _bytes(text: str) -> float:
    units = {"K": 2**10, "M": 2**20, "G": 2**30, "T": 2**40, "P": 2**50, "E": 2**60}
    factor = units.get(text.strip()[-1:].upper(), 1)
    return float_or(text.strip().rstrip("KMGTPEkmgtpe"), 0.0) * factor


def _check_copies(element: Element, times: float, seen: dict[str, float]) -> None:
    """Count what all copies of an element will be; stop where they are too many."""
    for child in element.children():
        each = times
        if child.tag in COPIERS:
            for word in child.get("count", "1").split():
                each *= max(1.0, float_or(word, 1.0))
        kind = "body" if child.tag in COPIERS[1:] else child.tag
        for name, most in dict.fromkeys((MOST.get(kind, ALL), ALL)):
            seen[name] = seen.get(name, 0.0) + each
            if seen[name] > most:
                raise RobotError(
                    f"there are more than {most} {name} with their copies",
                    where=child.place,
                    fix="repeat less, and describe one robot",
                )
        _check_copies(child, each, seen)
