"""Mass, centre and inertia against sums over many small pieces."""

from __future__ import annotations

import numpy as np
import pytest

from morph.print.arrays import Array
from morph.print.weight import Weight, box, together


def cloud(points: Array, mass: float) -> Weight:
    """Return equal point masses as one body: I = sum m (r.r 1 - r r') about their middle."""
    com = points.mean(axis=0)
    away = points - com
    each = mass / len(points)
    inertia = each * sum(r @ r * np.eye(3) - np.outer(r, r) for r in away)
    return Weight(mass=mass, com=com, inertia=np.asarray(inertia))


def same(found: Weight, due: Weight) -> None:
    assert found.mass == pytest.approx(due.mass)
    assert found.com == pytest.approx(due.com)
    assert found.inertia == pytest.approx(due.inertia)


@pytest.fixture
def points() -> Array:
    return np.random.default_rng(0).normal(size=(40, 3))


def test_two_bodies_together_are_all_their_points(points: Array) -> None:
    first, second = cloud(points[:15], 1.5), cloud(points[15:], 2.5)
    same(together([first, second]), cloud(points, 4.0))


def test_nothing_beside_a_body_changes_it(points: Array) -> None:
    nothing = Weight(mass=0.0, com=np.ones(3), inertia=np.zeros((3, 3)))
    same(together([cloud(points, 2.0), nothing]), cloud(points, 2.0))
    assert together([]).mass == 0.0


def test_a_body_that_is_moved_is_its_points_moved(points: Array) -> None:
    # A third of a turn about (1, 1, 1): x to y, y to z, z to x; and 10, 20, 30 mm.
    pose = np.eye(4)
    pose[:3, :3] = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
    pose[:3, 3] = [10.0, 20.0, 30.0]
    moved = points[:, [2, 0, 1]] + [0.01, 0.02, 0.03]
    same(cloud(points, 2.0).moved(pose), cloud(moved, 2.0))


def test_the_same_spread_of_twice_the_mass_turns_half_as_easily(points: Array) -> None:
    same(cloud(points, 2.0).scaled(4.0), cloud(points, 4.0))


def test_a_box_is_many_small_boxes() -> None:
    sides = np.array([10.0, 20.0, 40.0])
    middles = [(np.arange(60) + 0.5) / 60 - 0.5 for _ in range(3)]
    grid = np.stack(np.meshgrid(*middles, indexing="ij"), axis=-1).reshape(-1, 3) * sides * 1e-3
    found, due = box(3.0, sides), cloud(grid, 3.0)
    # Each of 60 pieces a side leaves out its own inertia: 1 / 60^2 = 3e-4 of the whole.
    assert found.mass == 3.0
    assert found.inertia == pytest.approx(due.inertia, rel=5e-4, abs=1e-9)
