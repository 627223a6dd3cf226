"""Copies of shapes that are light enough for a browser."""

from __future__ import annotations

from dataclasses import replace

from morph.app.picture.shapes import Shape
from morph.body.mesh.solid import Mesh
from morph.body.mesh.thin import thinned

MOST_FACES = 3000
"""Faces of one shape; more cannot be told apart on a screen."""


def web_shape(shape: Shape) -> Shape:
    """Return a shape with at most about `MOST_FACES` faces."""
    if len(shape.faces) <= MOST_FACES:
        return shape
    thin = thinned(Mesh(vertices=shape.vertices, faces=shape.faces), MOST_FACES)
    return replace(shape, vertices=thin.vertices, faces=thin.faces)
