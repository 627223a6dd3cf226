"""Names and mirror images of left and right."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from morph.body.check.sides import normal_between, slide, turn, twins

vectors = arrays(float, 3, elements=st.floats(-10, 10))
directions = vectors.filter(lambda v: np.linalg.norm(v) > 0.1).map(lambda v: v / np.linalg.norm(v))


@pytest.mark.parametrize(
    ("left", "right"),
    [
        ("left_knee", "right_knee"),
        ("knee_left", "knee_right"),
        ("LeftKnee", "RightKnee"),
        ("l_knee", "r_knee"),
        ("knee_l", "knee_r"),
        ("LKnee", "RKnee"),
        ("LEFT_KNEE", "RIGHT_KNEE"),
        ("FL_hip", "FR_hip"),
        ("RL_hip", "RR_hip"),
        ("HL_HAA", "HR_HAA"),
        ("LF_HAA", "RF_HAA"),
        ("lhip", "rhip"),
        ("arm_left_7_link", "arm_right_7_link"),
    ],
)
def test_names_of_left_and_right_are_found_left_first(left: str, right: str) -> None:
    assert twins([right, "trunk", left]) == [(left, right)]


@pytest.mark.parametrize(
    "names",
    [
        ("link", "rink2"),
        ("leg_1", "leg_2"),
        ("upper", "lower"),
        ("left_knee", "right_hip"),
        ("bottle", "bottre"),
        ("l", "m"),
        ("left_knee",),
    ],
)
def test_names_that_tell_no_sides_are_left_alone(names: tuple[str, ...]) -> None:
    assert twins(names) == []


@given(directions, vectors)
def test_a_mirror_image_twice_is_the_vector_itself(normal: np.ndarray, vector: np.ndarray) -> None:
    # 10 m, and some roundings of it.
    assert slide(normal, slide(normal, vector)) == pytest.approx(vector, abs=1e-13)
    assert turn(normal, turn(normal, vector)) == pytest.approx(vector, abs=1e-13)


@given(directions, vectors, directions, st.floats(-3, 3))
def test_a_mirrored_point_turns_about_the_mirrored_axis(
    normal: np.ndarray, point: np.ndarray, axis: np.ndarray, angle: float
) -> None:
    moved = Rotation.from_rotvec(angle * axis).apply(point)
    image = Rotation.from_rotvec(angle * turn(normal, axis)).apply(slide(normal, point))
    # 17 m at most, and some roundings of it.
    assert image == pytest.approx(slide(normal, moved), abs=1e-12)


def test_the_plane_between_hips_is_found_from_right_to_left() -> None:
    left = np.array([(0, 0.1, 0), (0.2, 0.3, -0.5), (0, 0, -0.4)])
    right = left * (1, -1, 1)
    assert normal_between(left, right) == pytest.approx([0, 1, 0])
    assert normal_between(right, left) == pytest.approx([0, -1, 0])


def test_pairs_that_stand_in_one_place_have_no_plane() -> None:
    same = np.array([(0, 0, -0.4), (0, 0, 1.0)])
    assert normal_between(same, same) is None
