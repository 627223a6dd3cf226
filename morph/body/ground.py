"""Ground in a description of a robot."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree


def flatten(tree: ElementTree.Element) -> bool:
    """Take height fields out of an MJCF; return whether there were any."""
    fields = [
        (parent, child)
        for parent in tree.iter()
        for child in parent
        if child.tag == "hfield" or (child.tag == "geom" and child.get("hfield"))
    ]
    for parent, child in fields:
        parent.remove(child)
    return bool(fields)
