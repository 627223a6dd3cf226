"""The layers of potential of triangles, against solid angles and sums that are known."""

from __future__ import annotations

import numpy as np
import pytest

from morph.physics.fluid.tensor.influence import influence
from morph.physics.fluid.tensor.panels import Panels, panels_of

TRIANGLE = np.array([[[0.0, 0.0, 0.0], [1.2, 0.1, 0.3], [0.2, 0.9, -0.1]]])


def summed(point: np.ndarray, corners: np.ndarray, parts: int) -> tuple[float, float]:
    """Both layers of one triangle by the middles of parts^2 small ones, for unit flux."""
    a, b, c = corners
    cells = [
        (i + third, j + third)
        for i in range(parts)
        for j in range(parts)
        for third in (1 / 3, 2 / 3)
        if i + j + 2 * third - 2 / 3 < parts - (third > 0.5)
    ]
    u, w = (np.array(cells) / parts).T[:, :, None]
    places = a + u * (b - a) + w * (c - a)
    twice = np.cross(b - a, c - a)
    r = places - point
    distance = np.linalg.norm(r, axis=1)
    area = 0.5 * np.linalg.norm(twice) / parts**2
    double = (r @ twice / np.linalg.norm(twice) / distance**3).sum() * area
    return double / (4 * np.pi), (1 / distance).sum() * area / (4 * np.pi)


@pytest.mark.parametrize("point", [(0.4, 0.3, 0.6), (0.5, 0.4, -0.3), (3.0, -2.0, 1.0)])
def test_both_layers_equal_their_sums_over_small_triangles(point: tuple[float, ...]) -> None:
    # The rule of middles errs by (h / r)^2 / 24 and less: (1.3 / 200 / 0.3)^2 / 24 = 2e-5.
    panels = Panels(corners=TRIANGLE)
    double, single = influence(np.array([point]), panels, np.ones((1, 1)))
    expected = summed(np.array(point), TRIANGLE[0], 200)
    assert (double.item(), single.item()) == pytest.approx(expected, rel=1e-4)


def test_from_the_middle_of_a_cube_each_side_fills_a_sixth_of_all_directions(
    cube: tuple[np.ndarray, np.ndarray],
) -> None:
    double, _ = influence(np.zeros((1, 3)), panels_of(*cube), np.ones((12, 1)))
    assert double.reshape(6, 2).sum(axis=1) == pytest.approx(1 / 6, abs=1e-14)


def test_a_square_seen_from_its_middle_has_the_potential_of_the_textbook(
    cube: tuple[np.ndarray, np.ndarray],
) -> None:
    # The integral of 1/r over a unit square from its centre is 4 ln(1 + sqrt 2), and
    # the centre lies on the diagonal that the two triangles share, where no logarithm is finite.
    corners, faces = cube
    side = Panels(corners=corners[faces[:2]])
    double, single = influence(side.corners[0, [0, 2]].mean(axis=0)[None], side, np.ones((2, 1)))
    assert 4 * np.pi * single.item() == pytest.approx(4 * np.log(1 + np.sqrt(2)), rel=1e-12)
    assert (double == 0).all()


def test_many_points_give_what_each_gives_alone(cube: tuple[np.ndarray, np.ndarray]) -> None:
    panels = panels_of(*cube)
    points = np.random.default_rng(1).normal(size=(10_000, 3))
    # 120 000 pairs are more than one block.
    double, single = influence(points, panels, panels.flux)
    alone = influence(points[-1:], panels, panels.flux)
    assert double[-1] == pytest.approx(alone[0][0], abs=1e-15)
    assert single[-1] == pytest.approx(alone[1][0], abs=1e-15)
