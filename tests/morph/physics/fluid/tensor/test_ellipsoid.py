"""Lamb's closed forms, against their own limits and against quadrature."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from morph.errors import RobotError
from morph.physics.fluid.tensor import ellipsoid_tensor


def diagonal(a: float, b: float, c: float) -> np.ndarray:
    return np.diag(ellipsoid_tensor(a, b, c).matrix)


def test_a_sphere_drags_half_its_volume_along_and_none_when_it_turns() -> None:
    tensor = ellipsoid_tensor(0.3, 0.3, 0.3)
    volume = 4 / 3 * np.pi * 0.027
    assert tensor.volume == pytest.approx(volume)
    assert np.diag(tensor.matrix) == pytest.approx([volume / 2] * 3 + [0] * 3, rel=1e-14)


def test_a_flat_spheroid_tends_to_the_disc() -> None:
    # Lamb 1932, art. 102 and 108: 8/3 a^3 broadside, 16/45 a^5 about a diameter. To first order
    # in c/a the closed forms exceed that by less than 1 + c/a (1e-4 here).
    found = diagonal(1.0, 1.0, 1e-4)
    assert found[2] == pytest.approx(8 / 3, rel=2e-4)
    assert found[3:5] == pytest.approx(16 / 45, rel=2e-4)
    assert found[5] == 0.0


def test_a_long_spheroid_tends_to_the_cylinder() -> None:
    # Per length a circular cylinder drags pi b^2 sideways: the whole volume. Along the axis the
    # spheroid drags V e^2 (ln(2/e) - 1) for slenderness e = b/a (Lamb 1932, art. 114).
    e = 0.01
    tensor = ellipsoid_tensor(1.0, e, e)
    assert tensor.matrix[1, 1] == pytest.approx(tensor.volume, rel=2e-3)
    slender = e**2 * (np.log(2 / e) - 1)
    assert tensor.matrix[0, 0] == pytest.approx(tensor.volume * slender, rel=2e-3)


@pytest.mark.parametrize("axes", [(0.3, 0.2, 0.1), (0.5, 0.1, 0.1), (0.2, 0.9, 0.5)])
def test_lambs_integrals_by_quadrature_give_the_same(axes: tuple[float, float, float]) -> None:
    squares = np.square(axes)

    def axis(at: int) -> float:
        # s = t / (1 - t) maps the half line to 0..1.
        def f(t: float) -> float:
            s = t / (1 - t)
            return float(1 / (1 - t) ** 2 / (squares[at] + s) / np.sqrt(np.prod(squares + s)))

        return float(np.prod(axes)) * quad(f, 0, 1, epsabs=1e-12, epsrel=1e-12)[0]

    alpha, beta, gamma = (axis(at) for at in range(3))
    assert alpha + beta + gamma == pytest.approx(2, rel=1e-10)
    volume = 4 / 3 * np.pi * np.prod(axes)
    x, _, z = squares
    found = diagonal(*axes)
    assert found[0] == pytest.approx(volume * alpha / (2 - alpha), rel=1e-9)
    turning = (z - x) ** 2 * (alpha - gamma) / (2 * (z - x) + (z + x) * (gamma - alpha))
    assert found[4] == pytest.approx(volume / 5 * turning, rel=1e-8)


@pytest.mark.parametrize("bad", [0.0, -1.0, float("nan"), float("inf")])
def test_an_axis_that_is_no_length_is_refused(bad: float) -> None:
    with pytest.raises(RobotError, match="b = "):
        ellipsoid_tensor(1.0, bad, 1.0)
