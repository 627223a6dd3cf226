"""The joints of a body as print sees them."""

from __future__ import annotations

import math

from morph.fabrication.drawing import MM, Drawing
from morph.fabrication.reach import reach
from morph.print.part import Hinge


def hinges(drawing: Drawing) -> tuple[Hinge, ...]:
    """Return every hinge and slide between two links, in the world with all joints at zero.

    A joint without limits turns as far as its closed chain lets it, and without one all the way
    round; a slide without limits stays where it is. What hangs from the world, or is free of
    what it is counted from, has no part to collide with, and is left out.
    """
    robot, model, data = drawing.robot, drawing.model, drawing.data
    parents = {link.name: link.parent for link in robot.links}
    free = {joint.link for joint in robot.joints if joint.kind in ("ball", "free")}
    reached = reach(drawing)
    results = []
    for joint in robot.joints:
        still = parents[joint.link]
        if joint.kind not in ("hinge", "slide") or still not in parents or joint.link in free:
            continue
        at = model.joint(joint.name).id
        unit = 1.0 if joint.kind == "hinge" else MM
        whole = (-math.pi, math.pi) if joint.kind == "hinge" else (0.0, 0.0)
        low, high = joint.limits or reached.get(joint.name, whole)
        results.append(
            Hinge(
                name=joint.name,
                kind="hinge" if joint.kind == "hinge" else "slide",
                position=MM * data.xanchor[at],
                axis=data.xaxis[at].copy(),
                low=low * unit,
                high=high * unit,
                still=still,
                moving=joint.link,
            )
        )
    return tuple(results)
