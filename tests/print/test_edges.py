from __future__ import annotations

import numpy as np
import trimesh

from morph.print.edges import edges, trouble
from morph.print.mesh import Mesh


def cube() -> Mesh:
    box = trimesh.creation.box((20.0, 20.0, 20.0))
    return Mesh(vertices=np.array(box.vertices), faces=np.array(box.faces, dtype=np.int64))


def test_a_cube_has_eighteen_edges_and_no_trouble() -> None:
    # Euler: 8 corners + 12 triangles - 2 = 18 edges.
    found = edges(cube())
    assert len(found.along) == 18
    assert found.closed
    assert trouble(cube()) == ""


def test_a_missing_triangle_leaves_three_open_edges() -> None:
    whole = cube()
    found = edges(Mesh(vertices=whole.vertices, faces=whole.faces[1:]))
    assert (found.open, found.crowded, found.twisted) == (3, 0, 0)
    assert not found.closed


def test_a_flipped_triangle_twists_three_edges() -> None:
    whole = cube()
    faces = whole.faces.copy()
    faces[4] = faces[4][::-1]
    twisted = Mesh(vertices=whole.vertices, faces=faces)
    assert edges(twisted).twisted == 3
    assert trouble(twisted) == "3 edges between faces that wind differently"


def test_a_fin_on_an_edge_crowds_it() -> None:
    whole = cube()
    vertices = np.concatenate([whole.vertices, [[50.0, 50.0, 50.0]]])
    a, b, _ = whole.faces[0]
    faces = np.concatenate([whole.faces, [[a, b, 8]]])
    found = edges(Mesh(vertices=vertices, faces=faces))
    assert (found.open, found.crowded) == (2, 1)
