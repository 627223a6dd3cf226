"""Other names for the links, joints and actuators of a canonical description."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree

from morph.body.vary.match import Match

BODY, JOINT = ("body",), ("joint", "freejoint")
REFERENCES = {
    "links": ("body", "body1", "body2"),
    "joints": ("joint", "joint1", "joint2", "jointinparent"),
    "actuators": ("actuator",),
}
"""The attributes by which MJCF refers to a part (MuJoCo documentation, XML Reference)."""
OBJECTS = {"body": "links", "xbody": "links", "joint": "joints", "actuator": "actuators"}
"""The kinds that a sensor gives in `objtype` and `reftype`."""


def renamed(mjcf: str, match: Match) -> str:
    """Return a canonical description whose parts bear the names of a match."""
    root = ElementTree.fromstring(mjcf)
    for world in root.iter("worldbody"):
        for element in world.iter():
            if element.tag in BODY:
                _replace(element, "name", match.links)
            elif element.tag in JOINT:
                _replace(element, "name", match.joints)
            elif element.tag in ("camera", "light"):
                _replace(element, "target", match.links)
    for actuators in root.iter("actuator"):
        for element in actuators:
            _replace(element, "name", match.actuators)
    for element in root.iter():
        for family, attributes in REFERENCES.items():
            for attribute in attributes:
                _replace(element, attribute, getattr(match, family))
        for kind, name in (("objtype", "objname"), ("reftype", "refname")):
            family = OBJECTS.get(element.get(kind, ""), "")
            if family:
                _replace(element, name, getattr(match, family))
    return ElementTree.tostring(root, encoding="unicode")


def _replace(element: ElementTree.Element, attribute: str, names: dict[str, str]) -> None:
    value = element.get(attribute)
    if value is not None and value in names:
        element.set(attribute, names[value])
