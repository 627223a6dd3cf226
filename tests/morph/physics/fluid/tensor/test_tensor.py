"""Moving, turning and growing a tensor, against the energy of the fluid."""

from __future__ import annotations

import numpy as np
import pytest

from morph.errors import RobotError
from morph.physics.fluid.tensor import Tensor, ellipsoid_tensor


@pytest.fixture
def tensor() -> Tensor:
    """An ellipsoid's, about a place off its centre."""
    return ellipsoid_tensor(0.3, 0.2, 0.1).shifted((0.4, -0.1, 0.2))


def energy(tensor: Tensor, velocity: np.ndarray, spin: np.ndarray) -> float:
    motion = np.concatenate([velocity, spin])
    return float(motion @ tensor.matrix @ motion) / 2


def test_the_fluid_has_the_same_energy_about_any_place(tensor: Tensor) -> None:
    rng = np.random.default_rng(0)
    velocity, spin, place = rng.normal(size=(3, 3))
    moved = tensor.about(place)
    # The place itself moves with v + w x place.
    expected = energy(tensor, velocity, spin)
    assert energy(moved, velocity + np.cross(spin, place), spin) == pytest.approx(expected)
    assert moved.about((0, 0, 0)).matrix == pytest.approx(tensor.matrix)
    assert moved.centre == pytest.approx((0.4, -0.1, 0.2))


def test_about_its_centre_an_ellipsoid_that_was_moved_is_diagonal_again(tensor: Tensor) -> None:
    own = ellipsoid_tensor(0.3, 0.2, 0.1)
    assert tensor.about(tensor.centre).matrix == pytest.approx(own.matrix, abs=1e-17)


def test_the_fluid_has_the_same_energy_however_it_is_turned(tensor: Tensor) -> None:
    rng = np.random.default_rng(1)
    velocity, spin = rng.normal(size=(2, 3))
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    turned = tensor.turned(turn)
    assert energy(turned, turn @ velocity, turn @ spin) == pytest.approx(
        energy(tensor, velocity, spin)
    )
    assert turned.centre == pytest.approx(turn @ tensor.centre)


def test_a_solid_twice_as_large_has_the_tensor_of_the_larger_ellipsoid(tensor: Tensor) -> None:
    larger = ellipsoid_tensor(0.6, 0.4, 0.2).shifted((0.8, -0.2, 0.4))
    grown = tensor.scaled(2.0)
    assert grown.matrix == pytest.approx(larger.matrix, rel=1e-12)
    assert grown.volume == pytest.approx(larger.volume)
    assert grown.centre == pytest.approx(larger.centre)


@pytest.mark.parametrize("factor", [0.0, -2.0, float("nan")])
def test_a_scale_that_is_no_size_is_refused(tensor: Tensor, factor: float) -> None:
    with pytest.raises(RobotError, match="scale"):
        tensor.scaled(factor)


def test_a_mirror_is_no_rotation(tensor: Tensor) -> None:
    with pytest.raises(RobotError, match="no rotation"):
        tensor.turned(np.diag((1.0, 1.0, -1.0)))


def test_a_matrix_that_is_no_inertia_is_refused() -> None:
    skewed = np.eye(6)
    skewed[0, 1] = 0.5
    with pytest.raises(RobotError, match="not symmetric"):
        Tensor(matrix=skewed, volume=1.0)
    with pytest.raises(RobotError, match="not finite"):
        Tensor(matrix=np.full((6, 6), np.nan), volume=1.0)
    with pytest.raises(RobotError, match="volume of 0"):
        Tensor(matrix=np.eye(6), volume=0.0)
