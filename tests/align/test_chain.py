"""Maps one after another."""

from __future__ import annotations

import numpy as np
import pytest

from morph.alignment.chain import ChainMap, composed
from morph.alignment.errors import MapError
from morph.alignment.maps.affine_map import AffineMap
from morph.alignment.maps.bent_map import BentMap
from morph.alignment.maps.feature_warping import flat_curves

RNG = np.random.default_rng(100)


def affine(n_s: int, n_t: int, k_s: int, k_t: int) -> AffineMap:
    """Return a map by chance, whose ways back are no inverses: nothing here asks for them."""
    sizes = {
        "state_law": (n_s, n_t), "state_shift": (n_s,), "lift_law": (n_t, n_s),
        "lift_shift": (n_t,), "action_law": (k_t, k_s), "action_state": (k_t, n_t),
        "action_shift": (k_t,), "read_law": (k_s, k_t), "read_state": (k_s, n_t),
        "read_shift": (k_s,),
    }  # fmt: skip
    return AffineMap(**{name: RNG.standard_normal(size) for name, size in sizes.items()})


def bent(n: int, k: int) -> BentMap:
    states, commands = flat_curves(n, 3, 2.0), flat_curves(k, 3, 2.0)
    return BentMap(
        affine=affine(n, n, k, k),
        states=states.at(0.1 * RNG.standard_normal(states.parameters.size)),
        commands=commands.at(0.1 * RNG.standard_normal(commands.parameters.size)),
        middle=RNG.standard_normal(n), spread=np.full(n, 2.0),
        command_middle=RNG.standard_normal(k), command_spread=np.full(k, 0.5),
    )  # fmt: skip


def test_three_affine_maps_make_one_that_does_what_they_do_in_turn() -> None:
    a, b, c = affine(2, 3, 1, 1), affine(3, 4, 1, 2), affine(4, 4, 2, 3)
    whole = composed([a, b, c])
    assert isinstance(whole, AffineMap)
    y, told = RNG.standard_normal((6, 4)), RNG.standard_normal((6, 3))
    x, u = RNG.standard_normal((6, 2)), RNG.standard_normal((6, 1))
    at_b = c.state(y)
    at_a = b.state(at_b)
    # Sums of a few dozen products of numbers near 1: rounding of 1e-16 grows to 1e-13 at most.
    np.testing.assert_allclose(whole.state(y), a.state(at_a), atol=1e-12)
    np.testing.assert_allclose(
        whole.state_back(x), c.state_back(b.state_back(a.state_back(x))), atol=1e-12
    )
    forth = c.action(y, b.action(at_b, a.action(at_a, u)))
    np.testing.assert_allclose(whole.action(y, u), forth, atol=1e-12)
    back = a.action_back(at_a, b.action_back(at_b, c.action_back(y, told)))
    np.testing.assert_allclose(whole.action_back(y, told), back, atol=1e-12)


def test_a_chain_kept_as_links_does_the_same_as_one_written_out() -> None:
    links = (affine(2, 3, 1, 2), affine(3, 3, 2, 2))
    whole, chain = composed(links), ChainMap(links=links)
    y, told = RNG.standard_normal((5, 3)), RNG.standard_normal((5, 2))
    x, u = RNG.standard_normal((5, 2)), RNG.standard_normal((5, 1))
    np.testing.assert_allclose(chain.state(y), whole.state(y), atol=1e-12)
    np.testing.assert_allclose(chain.state_back(x), whole.state_back(x), atol=1e-12)
    np.testing.assert_allclose(chain.action(y, u), whole.action(y, u), atol=1e-12)
    np.testing.assert_allclose(chain.action_back(y, told), whole.action_back(y, told), atol=1e-12)


def test_a_chain_with_a_bend_is_the_same_from_its_numbers() -> None:
    chain = composed([affine(2, 3, 1, 2), bent(3, 2)])
    assert isinstance(chain, ChainMap)
    again = ChainMap.of(chain.weights())
    y, u = RNG.standard_normal((5, 3)), RNG.standard_normal((5, 1))
    np.testing.assert_array_equal(again.state(y), chain.state(y))
    np.testing.assert_array_equal(again.action(y, u), chain.action(y, u))


def test_maps_that_share_no_body_are_refused() -> None:
    with pytest.raises(MapError, match=r"a body with \(3, 1\) states.*begins at \(2, 1\)"):
        composed([affine(2, 3, 1, 1), affine(2, 3, 1, 1)])


@pytest.mark.parametrize("name", ["nonsense", "0.chain.0.affine.state_law", "99999.affine.x"])
def test_numbers_that_belong_to_no_link_are_refused(name: str) -> None:
    with pytest.raises(MapError, match=r"names no number of a map in a chain"):
        ChainMap.of({name: np.zeros(2)})


def test_a_chain_with_a_link_missing_is_refused() -> None:
    numbers = {f"1.affine.{name}": value for name, value in affine(2, 2, 1, 1).weights().items()}
    with pytest.raises(MapError, match=r"its maps stand at the places \[1\]"):
        ChainMap.of(numbers)


def test_a_chain_of_nothing_is_refused() -> None:
    with pytest.raises(MapError, match=r"it has 0 maps"):
        composed([])
