from __future__ import annotations

import io

import numpy as np
import trimesh

from morph.print.mesh import Mesh
from morph.print.stl import stl


def test_a_second_library_reads_the_same_solid() -> None:
    ball = trimesh.creation.icosphere(subdivisions=3, radius=20.0)
    mesh = Mesh(vertices=np.asarray(ball.vertices) + 100.0, faces=np.asarray(ball.faces))
    read = trimesh.load(io.BytesIO(stl(mesh)), file_type="stl")
    assert len(read.faces) == len(ball.faces) == 1280
    # Numbers of four bytes: 120 mm to 120 * 2^-24 = 7e-6 mm.
    np.testing.assert_allclose(read.bounds, mesh.bounds, atol=1e-5)
    assert read.is_watertight
    assert abs(read.volume - mesh.volume) < 1e-5 * mesh.volume


def test_it_takes_84_bytes_and_50_for_each_triangle_and_does_not_pass_for_text() -> None:
    box = trimesh.creation.box()
    mesh = Mesh(vertices=np.asarray(box.vertices), faces=np.asarray(box.faces))
    content = stl(mesh)
    assert len(content) == 84 + 50 * 12
    assert not content.startswith(b"solid")
    assert content == stl(mesh)


def test_a_triangle_without_area_has_a_normal_of_zero_rather_than_none() -> None:
    mesh = Mesh(vertices=np.zeros((3, 3)), faces=np.array([[0, 1, 2]]))
    assert stl(mesh)[84:96] == bytes(12)
