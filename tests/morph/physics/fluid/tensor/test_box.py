"""Boxes, against tables of others, against long prisms, and against their own meshes."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

from morph.errors import RobotError
from morph.physics.fluid.tensor import Tensor, box_tensor, extrapolated, kirchhoff


@lru_cache
def box(a: float, b: float, c: float) -> Tensor:
    return box_tensor(a, b, c)


def test_a_cube_drags_0_638_of_its_volume() -> None:
    # Sihvola, Yla-Oijala, Jarvenpaa and Avelin 2004, IEEE Trans. Antennas Propag. 52(9): a cube
    # that no flux enters has polarizability -1.6383 V, and -(V + added mass) is the same thing.
    tensor = box(1, 1, 1)
    assert np.diag(tensor.matrix)[:3] == pytest.approx(0.6383, abs=0.001)
    assert tensor.error < 0.01


# DNV-RP-C205, table D-2 (and Patton 1965): broadside added mass of rectangles without thickness,
# by pi/4 a^2 b, for b/a.
@pytest.mark.parametrize(("ratio", "table"), [(1.0, 0.579), (2.0, 0.757), (1.25, 0.642)])
def test_a_plate_drags_what_the_table_of_plates_says(ratio: float, table: float) -> None:
    # Thickness adds: sections of 0.1 a have 1.14 for a flat one's 1 (table D-1), so that 0.002 a
    # adds 0.3 % if in proportion, and more as it goes as t ln(1 / t): 1 %, give or take 1 %.
    found = box(ratio, 1.0, 0.002).matrix[2, 2] / (np.pi / 4 * ratio)
    assert found == pytest.approx(1.01 * table, rel=0.01)


def test_a_square_plate_turns_no_more_fluid_than_its_outer_disc_nor_less_than_its_inner() -> None:
    # 16/45 a^5 for discs of radius 1/2 and 1/sqrt 2: a larger screen moves more.
    about = box(1.0, 1.0, 0.002).matrix[3, 3]
    assert 16 / 45 * 0.5**5 < about < 16 / 45 * 0.5**2.5


def test_a_long_square_rod_drags_what_its_section_does() -> None:
    # DNV-RP-C205, table D-1: a square section of side 2 a has 1.51 pi a^2 per length. The
    # ends lose about a width each of 30: at most 7 %.
    rod = box_tensor(30.0, 1.0, 1.0)
    per_length = rod.matrix[1, 1] / 30.0
    assert 0.93 * 1.51 * np.pi / 4 < per_length < 1.51 * np.pi / 4


def test_the_box_agrees_with_plain_triangles(cube: tuple[np.ndarray, np.ndarray]) -> None:
    # Even triangles in two sizes, extrapolated at the order of right-angled edges, are good
    # to about 1 % along and 5 % about: a turning body pushes most near its edges, and these
    # triangles are up to five times as long as wide.
    corners, faces = cube
    sides = np.array((0.64, 0.21, 0.12))
    values = [kirchhoff(*_evenly(corners * sides, faces, level)) for level in (2, 3)]
    plain = np.diag(extrapolated(*values, order=4 / 3))
    exact = np.diag(box(*sides).matrix)
    assert plain[1:3] == pytest.approx(exact[1:3], rel=0.01)
    assert plain[4:] == pytest.approx(exact[4:], rel=0.05)


def _evenly(vertices: np.ndarray, faces: np.ndarray, level: int) -> tuple[np.ndarray, np.ndarray]:
    from trimesh.remesh import subdivide

    for _ in range(level):
        vertices, faces = subdivide(vertices, faces)
    return np.asarray(vertices), np.asarray(faces)


def test_naming_the_sides_otherwise_only_names_the_entries_otherwise() -> None:
    one = np.diag(box(0.16, 0.05, 0.003).matrix).reshape(2, 3)
    other = np.diag(box(0.003, 0.16, 0.05).matrix).reshape(2, 3)
    assert other == pytest.approx(one[:, (2, 0, 1)], rel=1e-9)


def test_a_box_grown_is_the_tensor_grown() -> None:
    found = box(16.0, 5.0, 0.3).matrix
    assert found == pytest.approx(box(0.16, 0.05, 0.003).scaled(100.0).matrix, rel=1e-9)


def test_a_paddle_of_three_millimetres_has_ten_times_its_own_volume_in_added_mass() -> None:
    paddle = box(0.16, 0.05, 0.003)
    found = np.diag(paddle.matrix)
    assert paddle.volume == pytest.approx(2.4e-5)
    # The thin rectangle 3.2 : 1 has 0.841 pi/4 a^2 b (DNV-RP-C205, table D-2, interpolated), and
    # sections of 0.1 a have 14 % more (table D-1): 0.06 a has 8 % and, by t ln(1 / t), up to 11 %.
    assert found[2] / (np.pi / 4 * 0.16 * 0.05**2) == pytest.approx(0.92, abs=0.015)
    assert 10 < found[2] / paddle.volume < 13
    assert paddle.error < 0.02


@pytest.mark.parametrize("bad", [0.0, -1.0, float("nan")])
def test_a_side_that_is_no_length_is_refused(bad: float) -> None:
    with pytest.raises(RobotError, match="c = "):
        box_tensor(1.0, 1.0, bad)


def test_a_foil_is_refused_because_its_two_faces_cannot_be_told_apart() -> None:
    with pytest.raises(RobotError, match=r"below 0\.001 of the greatest"):
        box_tensor(1.0, 1.0, 1e-4)
