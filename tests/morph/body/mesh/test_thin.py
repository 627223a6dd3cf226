"""Meshes of too many faces, thinned."""

from __future__ import annotations

import numpy as np
import pytest

from morph.body.mesh import Mesh, thinned
from morph.body.mesh.thin import MOST_CORNERS, _distinct


def ball(steps: int) -> Mesh:
    """Return a ball of radius 1 as patches of a globe."""
    turns = np.linspace(0, 2 * np.pi, 2 * steps, endpoint=False)
    rises = np.linspace(-np.pi / 2, np.pi / 2, steps + 1)
    grid = [
        [(np.cos(r) * np.cos(t), np.cos(r) * np.sin(t), np.sin(r)) for t in turns] for r in rises
    ]
    index = np.arange((steps + 1) * 2 * steps).reshape(steps + 1, -1)
    low, high = index[:-1], index[1:]
    right, above = np.roll(low, -1, axis=1), np.roll(high, -1, axis=1)
    faces = [np.stack([low, right, above], -1)[1:], np.stack([low, above, high], -1)[:-1]]
    return Mesh(
        vertices=np.array(grid).reshape(-1, 3),
        faces=np.concatenate([part.reshape(-1, 3) for part in faces]),
    )


def test_a_thinned_ball_keeps_its_volume_and_its_size() -> None:
    fine = ball(100)
    coarse = thinned(fine, 5000)
    assert 1000 < len(coarse.faces) <= 5000
    # Cells of about 0.05 cut at most that much off: 4 pi r^2 * 0.05 / 2 of 4 pi / 3 is 7 %.
    assert coarse.volume == pytest.approx(4 / 3 * np.pi, rel=0.07)
    assert np.abs(coarse.bounds - fine.bounds).max() < 0.06


def test_a_mesh_with_few_faces_is_given_back_as_it_is() -> None:
    small = ball(5)
    assert thinned(small, 1000) is small


def test_faces_are_sorted_alike_as_one_number_and_as_three() -> None:
    faces = np.random.default_rng(3).integers(0, 12, (2000, 3))
    assert np.array_equal(_distinct(faces, 12), np.unique(faces, axis=0))
    most = np.array([[MOST_CORNERS - 1] * 3])
    assert np.array_equal(_distinct(most, MOST_CORNERS), most)
