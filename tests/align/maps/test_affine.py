"""An affine map, and the laws behind it, against the formulas of their docstrings."""

from __future__ import annotations

import numpy as np
import pytest

from morph.alignment.arrays import Array
from morph.alignment.maps.affine_map import SHAPES, AffineMap
from morph.alignment.maps.bent_map import BentMap
from morph.alignment.maps.feature_warping import Curves
from morph.alignment.maps.follow import LinearDynamics, linear
from morph.alignment.maps.state_law import unscaled
from morph.alignment.samples import Transitions
from morph.alignment.scale import Standardizer


@pytest.fixture
def drawn() -> AffineMap:
    """Ten arrays of random numbers: no two ways are inverses of each other."""
    rng = np.random.default_rng(1)
    shapes = {
        "state_law": (2, 3), "state_shift": (2,), "lift_law": (3, 2), "lift_shift": (3,),
        "action_law": (2, 1), "action_state": (2, 3), "action_shift": (2,),
        "read_law": (1, 2), "read_state": (1, 3), "read_shift": (1,),
    }  # fmt: skip
    assert set(shapes) == set(SHAPES)
    return AffineMap(**{name: rng.normal(size=shape) for name, shape in shapes.items()})


def by_sums(law: Array, x: Array, shift: Array) -> Array:
    """Return law x + shift of one vector, number by number."""
    return np.array(
        [sum(law[i, j] * x[j] for j in range(law.shape[1])) + shift[i] for i in range(law.shape[0])]
    )


def test_each_way_is_its_formula(drawn: AffineMap) -> None:
    rng = np.random.default_rng(2)
    x, y, u, a = (rng.normal(size=n) for n in (2, 3, 1, 2))
    m = drawn
    assert m.state(y[None])[0] == pytest.approx(by_sums(m.state_law, y, m.state_shift))
    assert m.state_back(x[None])[0] == pytest.approx(by_sums(m.lift_law, x, m.lift_shift))
    told = by_sums(m.action_law, u, m.action_shift) + by_sums(m.action_state, y, np.zeros(2))
    assert m.action(y[None], u[None])[0] == pytest.approx(told)
    read = by_sums(m.read_law, a, m.read_shift) + by_sums(m.read_state, y, np.zeros(1))
    assert m.action_back(y[None], a[None])[0] == pytest.approx(read)


def test_a_bent_map_is_an_affine_one_of_numbers_about_their_middle(drawn: AffineMap) -> None:
    none = Curves(height=np.zeros((3, 0)), centre=np.zeros(0), width=1.0)
    few = Curves(height=np.zeros((2, 0)), centre=np.zeros(0), width=1.0)
    rng = np.random.default_rng(3)
    middle, spread = rng.normal(size=3), rng.uniform(0.5, 2.0, 3)
    told_middle, told_spread = rng.normal(size=2), rng.uniform(0.5, 2.0, 2)
    bent = BentMap(
        affine=drawn, states=none, commands=few, middle=middle, spread=spread,
        command_middle=told_middle, command_spread=told_spread,
    )  # fmt: skip
    x, y, u, a = (rng.normal(size=(4, n)) for n in (2, 3, 1, 2))
    t = (y - middle) / spread
    assert bent.state(y) == pytest.approx(drawn.state(t))
    assert bent.state_back(x) == pytest.approx(middle + spread * drawn.state_back(x))
    assert bent.action(y, u) == pytest.approx(told_middle + told_spread * drawn.action(t, u))
    read = drawn.action_back(t, (a - told_middle) / told_spread)
    assert bent.action_back(y, a) == pytest.approx(read)


def test_a_law_in_spreads_is_the_same_law_in_the_bodies_units() -> None:
    rng = np.random.default_rng(4)
    ours = Standardizer(middle=rng.normal(size=2), spread=rng.uniform(0.5, 2.0, 2))
    theirs = Standardizer(middle=rng.normal(size=3), spread=rng.uniform(0.5, 2.0, 3))
    law, shift = rng.normal(size=(2, 3)), rng.normal(size=2)
    found = unscaled(law, shift, ours, theirs)
    y = rng.normal(size=(5, 3))
    z = (y - theirs.middle) / theirs.spread
    assert found(y) == pytest.approx(ours.middle + ours.spread * (z @ law.T + shift))


def test_a_linear_body_is_told_by_its_transitions() -> None:
    rng = np.random.default_rng(5)
    A, B, c = np.array([[0.9, 0.1], [-0.3, 0.8]]), np.array([[0.0], [0.5]]), np.array([0.2, -0.1])
    x, u = rng.normal(size=(4000, 2)), rng.normal(size=(4000, 1))
    seen = Transitions(
        state=x, command=u, after=x @ A.T + u @ B.T + c, turns=np.array([False, False])
    )
    found: LinearDynamics = linear(seen)
    # A ridge of a thousandth draws slopes of x' - x by a thousandth of themselves to 0.
    assert np.abs(found.A - A).max() < 2e-3
    assert np.abs(found.B - B).max() < 2e-3
    assert np.abs(found.c - c).max() < 2e-3
