"""Figure of a body on a skateboard, whose balance model has only the soles."""

from __future__ import annotations

from dataclasses import replace

from morph.app.picture.shapes import PictureShape
from morph.app.viewer.figure import Figure, figure
from morph.body.robot import Robot


def dressed(placed: Robot, rider: Robot) -> Figure:
    """Return what is drawn of a body on a board, with the shapes that its rider had before.

    Links keep their names and frames when they are put on a board; their shapes are left behind,
    but for the soles.
    """
    bare, own = figure(placed), figure(rider)
    places = {name: at for at, name in enumerate(bare.links) if at}
    shapes: list[PictureShape] = [
        replace(shape, body=places[own.links[shape.body]])
        for shape in own.shapes
        if own.links[shape.body] in places
    ]
    clad = {shape.body for shape in shapes}
    kept = [shape for shape in bare.shapes if shape.body not in clad]
    return replace(bare, shapes=(*kept, *shapes), notes=(*bare.notes, *own.notes))
