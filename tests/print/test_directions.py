from __future__ import annotations

import numpy as np
import trimesh

from morph.print.directions import resting, spread, turned_down
from morph.print.mesh import Mesh


def mesh(shape: trimesh.Trimesh) -> Mesh:
    return Mesh(vertices=np.asarray(shape.vertices), faces=np.asarray(shape.faces))


def test_a_box_rests_on_six_faces_the_largest_first() -> None:
    downs = resting(mesh(trimesh.creation.box(extents=(10, 20, 30))))
    assert len(downs) == 6
    # 20 * 30 mm2 across x, 10 * 30 across y, 10 * 20 across z.
    assert np.abs(downs).argmax(axis=1).tolist() == [0, 0, 1, 1, 2, 2]


def test_a_cylinder_rests_on_its_ends_and_around_its_side() -> None:
    downs = resting(mesh(trimesh.creation.cylinder(radius=10, height=5, sections=32)))
    assert len(downs) == 34
    assert np.isclose(np.abs(downs[:, 2]), 1.0).sum() == 2


def test_what_is_flat_still_rests_on_something() -> None:
    flat = Mesh(vertices=np.eye(3), faces=np.array([[0, 1, 2]]))
    assert len(resting(flat)) == 6


def test_directions_are_spread_without_a_gap() -> None:
    downs = spread()
    np.testing.assert_allclose(np.linalg.norm(downs, axis=1), 1.0)
    probe = np.random.default_rng(0).normal(size=(2000, 3))
    probe /= np.linalg.norm(probe, axis=1, keepdims=True)
    # 162 caps cover the sphere no better than with a radius of acos(1 - 2 / 162) = 9 degrees.
    assert np.rad2deg(np.arccos((probe @ downs.T).max(axis=1))).max() < 14.0


def test_every_direction_is_turned_down_by_a_rotation() -> None:
    for down in (*spread(50), np.array([0, 0, 1.0]), np.array([0, 0, -1.0])):
        turn = turned_down(down)
        np.testing.assert_allclose(turn @ down, [0, 0, -1], atol=1e-9)
        np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-9)
        assert np.linalg.det(turn) > 0
