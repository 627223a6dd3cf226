"""Which inertias a body can have, and the nearest that one can."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from morph.body.inertia import THINNEST, ball, is_physical, mended, spread

rotations = st.integers(0, 10**6).map(lambda seed: Rotation.random(random_state=seed).as_matrix())


@st.composite
def clouds(draw: st.DrawFn) -> np.ndarray:
    """Draw the inertia of points with masses, about their centre of mass, by its definition."""
    count = draw(st.integers(2, 8))
    places = draw(arrays(float, (count, 3), elements=st.floats(-10, 10)))
    masses = draw(arrays(float, count, elements=st.floats(0.01, 100)))
    places = places - masses @ places / masses.sum()
    inertia = np.zeros((3, 3))
    for mass, (x, y, z) in zip(masses, places, strict=True):
        inertia += mass * np.array(
            [
                [y * y + z * z, -x * y, -x * z],
                [-x * y, x * x + z * z, -y * z],
                [-x * z, -y * z, x * x + y * y],
            ]
        )
    return inertia


@st.composite
def symmetric(draw: st.DrawFn) -> np.ndarray:
    """Draw any symmetric matrix of numbers that are whole millionths: no inertia is 1e-320."""
    values = draw(arrays(np.int64, (3, 3), elements=st.integers(-(10**7), 10**7)))
    return (values + values.T) * 1e-6


@settings(deadline=None)
@given(clouds())
def test_every_cloud_of_points_has_a_physical_inertia(inertia: np.ndarray) -> None:
    # Points that all but coincide have no inertia beside the rounding of their places, 1e-15.
    if np.trace(inertia) > 1e-9:
        assert is_physical(inertia)


@given(st.floats(0.1, 10), st.floats(0.1, 10), st.floats(1.001, 10), rotations)
def test_moments_that_break_the_triangle_inequality_are_not_physical(
    a: float, b: float, beyond: float, turn: np.ndarray
) -> None:
    broken = turn @ np.diag((a, b, (a + b) * beyond)) @ turn.T
    assert not is_physical((broken + broken.T) / 2)


@given(st.floats(0.1, 10), st.floats(0.1, 10), st.floats(0.0, 0.999), rotations)
def test_moments_within_the_triangle_inequality_are_physical(
    a: float, b: float, between: float, turn: np.ndarray
) -> None:
    # From |a - b| to a + b: every third side of a triangle.
    third = abs(a - b) + between * (a + b - abs(a - b))
    inertia = turn @ np.diag((a, b, third)) @ turn.T
    assert is_physical((inertia + inertia.T) / 2)


@pytest.mark.parametrize(
    "wrong",
    [
        *(np.zeros((3, 3)), -np.eye(3), np.diag((1.0, 1.0, -1.0)), np.diag((0.0, 0.0, 1.0))),
        *(np.full((3, 3), np.nan), np.diag((1.0, np.nan, 1.0)), np.diag((np.inf, 1.0, 1.0))),
    ],
)
def test_nothing_and_negative_moments_are_not_physical(wrong: np.ndarray) -> None:
    assert not is_physical(wrong)


@pytest.mark.parametrize("edge", [np.diag((0.1, 0.2, 0.3)), np.diag((0.0, 1.0, 1.0)), np.eye(3)])
def test_sheets_rods_and_balls_are_physical(edge: np.ndarray) -> None:
    assert is_physical(edge)
    turn = Rotation.from_euler("xyz", (0.3, -1.0, 2.0)).as_matrix()
    assert is_physical(turn @ edge @ turn.T)


def test_the_second_moments_of_a_box_are_its_edges_squared_over_twelve() -> None:
    # The integral of x^2 dm over a box of mass m and edge a is m a^2 / 12.
    m, a, b, c = 3.0, 0.1, 0.2, 0.4
    inertia = m / 12 * np.diag((b * b + c * c, a * a + c * c, a * a + b * b))
    expected = m / 12 * np.diag((a * a, b * b, c * c))
    assert spread(inertia) == pytest.approx(expected, rel=1e-12, abs=1e-15)


def test_a_ball_has_two_fifths_of_m_r_squared() -> None:
    radius = 0.3
    mass = 700 * 4 / 3 * math.pi * radius**3
    assert ball(mass, 700.0) == pytest.approx(0.4 * mass * radius**2 * np.eye(3), rel=1e-12)


@given(symmetric())
def test_what_is_mended_is_physical_and_keeps_its_axes(broken: np.ndarray) -> None:
    whole = mended(broken)
    if whole is None:
        # No second moment is positive, so that no mass can be placed anywhere.
        assert np.linalg.eigvalsh(spread(broken))[2] <= 0
        return
    assert is_physical(whole)
    assert np.linalg.eigvalsh(whole)[0] > 0
    assert whole == pytest.approx(whole.T)
    size = np.abs(broken).max()
    # Matrices with the same axes commute, but for rounding of products.
    assert whole @ broken == pytest.approx(broken @ whole, abs=1e-12 * size**2 + 1e-300)


@given(symmetric())
def test_mending_twice_is_mending_once(broken: np.ndarray) -> None:
    once = mended(broken)
    if once is not None:
        twice = mended(once)
        assert twice is not None
        assert twice == pytest.approx(once, rel=1e-12, abs=1e-12 * np.abs(once).max())


@given(clouds())
def test_what_is_well_inside_is_not_changed(inertia: np.ndarray) -> None:
    moments = np.linalg.eigvalsh(spread(inertia))
    if moments[0] > 1.001 * THINNEST * moments[2]:
        assert mended(inertia) == pytest.approx(inertia, rel=1e-12, abs=1e-13 * moments[2])


@settings(deadline=None, max_examples=15)
@given(st.integers(0, 10**6))
def test_no_other_physical_inertia_is_nearer(seed: int) -> None:
    rng = np.random.default_rng(seed)
    broken = rng.normal(size=(3, 3))
    broken = broken + broken.T
    moments = spread(broken)
    whole = mended(broken)
    if whole is None:
        return
    least = THINNEST * np.linalg.eigvalsh(moments)[2]

    # Second moments L L' + least 1: every matrix at or above the least, for any lower L.
    def place(x: np.ndarray) -> np.ndarray:
        lower = np.zeros((3, 3))
        lower[np.tril_indices(3)] = x
        return lower @ lower.T + least * np.eye(3)

    def distance(x: np.ndarray) -> float:
        return float(np.sum((place(x) - moments) ** 2))

    best = min(minimize(distance, rng.normal(size=6)).fun for _ in range(3))
    ours = float(np.sum((spread(whole) - moments) ** 2))
    # BFGS stops at a slope of 1e-5, of a sum of squares of some units: below 1e-6 of it.
    assert ours <= best + 1e-6
    assert ours == pytest.approx(best, rel=1e-3, abs=1e-5)


@pytest.mark.parametrize("hopeless", [np.full((3, 3), np.nan), -np.eye(3), np.zeros((3, 3))])
def test_what_cannot_be_mended_is_none_and_no_error(hopeless: np.ndarray) -> None:
    assert mended(hopeless) is None
