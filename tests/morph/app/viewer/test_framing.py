"""A camera sees everything, from as near as can be."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from morph.app.viewer.framing import FIELD, FILLED, Frame, framed
from morph.arrays import Array

TOWARDS = np.array([0.3, -1.0, 0.4]) / np.linalg.norm([0.3, -1.0, 0.4])


def pictured(points: Array, frame: Frame, aspect: float) -> Array:
    """Return where points are in the picture, -1 to 1 along its width and height."""
    forward = frame.target - frame.position
    forward = forward / np.linalg.norm(forward)
    right = np.cross(forward, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    away = points - frame.position
    depth = away @ forward
    tangent = math.tan(0.5 * FIELD)
    up = np.cross(right, forward)
    return np.stack(
        (away @ right / (depth * tangent * aspect), away @ up / (depth * tangent)), axis=1
    )


@given(seed=st.integers(0, 10_000), aspect=st.floats(0.4, 2.5), scale=st.floats(1e-3, 1e3))
def test_all_is_in_the_picture_and_touches_its_edge(seed: int, aspect: float, scale: float) -> None:
    rng = np.random.default_rng(seed)
    points = scale * (rng.uniform(-1.0, 1.0, (12, 3)) * rng.uniform(0.1, 1.0, 3) + 3.0)
    where = pictured(points, framed(points, TOWARDS, aspect), aspect)
    # Rounding of 1e-16 by coordinates that are 10 times the extent.
    assert np.abs(where).max() == pytest.approx(FILLED, rel=1e-6)
    # The axis that binds is filled to both of its sides, so that no place is nearer.
    least, most = where.min(axis=0), where.max(axis=0)
    binding = int(np.argmax(most - least))
    assert least[binding] == pytest.approx(-FILLED, rel=1e-6)
    assert most[binding] == pytest.approx(FILLED, rel=1e-6)


def test_a_flat_square_is_as_far_as_its_half_by_the_tangent() -> None:
    # Seen along y, 2 m by 2 m at y = 0: the distance is 1 / (0.86 tan 20 degrees) = 3.195 m.
    square = np.array([[x, 0.0, z] for x in (-1.0, 1.0) for z in (-1.0, 1.0)])
    frame = framed(square, np.array([0.0, -1.0, 0.0]), 1.0)
    assert np.allclose(frame.position, (0.0, -1.0 / (FILLED * math.tan(0.5 * FIELD)), 0.0))
    assert np.allclose(frame.target, 0.0)


def test_a_single_point_is_seen_from_somewhere() -> None:
    frame = framed(np.zeros((1, 3)), TOWARDS, 1.0)
    assert frame.distance > 0.0
