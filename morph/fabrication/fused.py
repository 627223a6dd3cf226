"""Links that are one piece with another, as parts that are not printed by themselves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from morph.fabrication.drawing import Drawing
from morph.fabrication.names import UniqueNames, safe
from morph.fabrication.off_the_shelf_parts import Item
from morph.fabrication.pieces import fusions, plastic, printed_links
from morph.print.mesh import joined
from morph.print.part import Part, Placement


def fused(
    drawing: Drawing, bought: Sequence[Item], printed: Sequence[Part], names: UniqueNames
) -> tuple[Part, ...]:
    """Return what is drawn of each link that is one piece with another, in its own frame."""
    into = fusions(drawing, printed_links(drawing))
    made = {place.link: part.name for part in printed for place in part.placements}
    results: list[Part] = []
    for link, root in into.items():
        shapes = [shape for shape in plastic(drawing, link, bought) if shape.kind != "mesh"]
        if not shapes or root not in made:
            continue
        place = Placement(link=link, pose=np.eye(4), world=drawing.world(link))
        results.append(
            Part(
                name=names.one(safe(link)),
                kind="fused",
                mesh=joined(shape.placed for shape in shapes),
                placements=(place,),
                into=made[root],
                number=f"F-{len(results) + 1:02d}",
            )
        )
    return tuple(results)
