"""The manifold family on bodies whose map is known: linear motions disguised by another basis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from morph.alignment.errors import MapError, SamplesError, SettingError
from morph.alignment.maps.affine_map import AffineMap
from morph.alignment.maps.body_map import MapData, Mapper
from morph.alignment.maps.features import Features
from morph.alignment.maps.follow import followed, linear
from morph.alignment.maps.graph import alike, neighbours, patterns
from morph.alignment.maps.joint import across, together
from morph.alignment.maps.manifold import Manifold, ManifoldFree
from morph.alignment.maps.pca_affine import PcaAffine
from morph.alignment.maps.sparse import Sparse, coded, dictionary
from morph.alignment.maps.state_law import StateLaw
from morph.alignment.maps.transport import Transport, fused
from morph.alignment.maps.uma import Uma
from morph.alignment.pairs import posed, shuffled
from morph.alignment.samples import Pairs, Transitions

PAIRED: tuple[Mapper, ...] = (PcaAffine(), Manifold(), Uma(), Sparse(), Transport())


@dataclass(frozen=True)
class Known:
    """Two bodies that are one: y = T x, a = u / 3."""

    given: MapData
    law: np.ndarray


def moved(count: int, seed: int, T: np.ndarray, command: float) -> Transitions:
    """A cart and a tilting pole, each with its speed, in the basis y = T x."""
    rng = np.random.default_rng(seed)
    A = np.array([[1, 0, 0.05, 0], [0, 1, 0, 0.05], [0, 0, 0.95, 0], [0, 0.3, 0, 0.9]])
    B = np.array([[0.0], [0.0], [0.1], [-0.2]])
    x = rng.standard_normal((count, 4)) * np.array([0.3, 0.1, 0.4, 0.3])
    u = rng.standard_normal((count, 1))
    after = x @ A.T + u @ B.T
    return Transitions(
        state=x @ T.T, command=u * command, after=after @ T.T, turns=np.zeros(4, dtype=bool)
    )


@pytest.fixture(scope="module")
def known() -> Known:
    # A quarter of each number leaks into the next; the pole's sign is turned.
    T = np.diag([2.0, -1.0, 2.0, -1.0]) @ (np.eye(4) + 0.25 * np.roll(np.eye(4), 1, axis=1))
    source, target = moved(150, 1, np.eye(4), 1.0), moved(120, 2, T, 1.0 / 3.0)
    law = np.linalg.inv(T)
    pairs = posed(
        target.state,
        np.eye(4),
        np.asarray(law, dtype=float),
        10,
        np.random.default_rng(3),
        error=0.02,
    )
    return Known(given=MapData(source=source, target=target, pairs=pairs), law=law)


def agreement(found: AffineMap, known: Known) -> float:
    """The least share of the variance of a number of the source that is explained."""
    truth = known.given.target.state @ known.law.T
    off = found.state(known.given.target.state) - truth
    return float((1.0 - np.square(off).sum(axis=0) / np.square(truth).sum(axis=0)).min())


@pytest.mark.parametrize("mapper", PAIRED, ids=lambda each: each.name)
def test_ten_landmarks_find_the_map_and_the_same_ones_shuffled_do_not(
    mapper: Mapper, known: Known
) -> None:
    # Labels err by 2 % of the spread; a map that knew nothing would explain 0.
    found = mapper.fit(known.given, np.random.default_rng(0))
    assert isinstance(found, AffineMap)
    assert agreement(found, known) > 0.8
    assert known.given.pairs is not None
    wrong = shuffled(known.given.pairs, np.random.default_rng(0))
    control = MapData(source=known.given.source, target=known.given.target, pairs=wrong)
    other = mapper.fit(control, np.random.default_rng(0))
    assert isinstance(other, AffineMap)
    assert agreement(other, known) < 0.3


@pytest.mark.parametrize("mapper", PAIRED, ids=lambda each: each.name)
def test_states_and_commands_come_back_from_the_other_body(mapper: Mapper, known: Known) -> None:
    found = mapper.fit(known.given, np.random.default_rng(0))
    x, y = known.given.source.state[:20], known.given.target.state[:20]
    np.testing.assert_allclose(found.state(found.state_back(x)), x, atol=1e-8)
    u = known.given.source.command[:20]
    np.testing.assert_allclose(found.action_back(y, found.action(y, u)), u, atol=1e-7)


@pytest.mark.parametrize("mapper", [*PAIRED, ManifoldFree()], ids=lambda each: each.name)
def test_the_same_chance_gives_the_same_map(mapper: Mapper, known: Known) -> None:
    first, second = (mapper.fit(known.given, np.random.default_rng(5)).weights() for _ in range(2))
    for name, value in first.items():
        np.testing.assert_array_equal(value, second[name])


def test_the_target_is_told_what_moves_it_as_the_source_would(known: Known) -> None:
    # On one body in two bases a = u / 3 follows exactly. Ridge and the price of effort take some
    # percent of it, and nothing is to be mended by the state.
    found = followed(
        StateLaw(S=known.law, s=np.zeros(4)),
        known.given.source,
        known.given.target,
        horizon=20,
        effort=1e-4,
    )
    assert found.action_law[0, 0] == pytest.approx(1.0 / 3.0, rel=0.05)
    mended = known.given.target.state @ found.action_state.T
    assert mended.std() < 0.1 * known.given.target.command.std()


def test_a_linear_body_is_found_from_its_transitions(known: Known) -> None:
    # A ridge of 1e-3 shrinks a slope by a thousandth where inputs are independent.
    found = linear(known.given.source)
    np.testing.assert_allclose(found.B[:, 0], [0.0, 0.0, 0.1, -0.2], atol=2e-3)
    np.testing.assert_allclose(found.A[3], [0.0, 0.3, 0.0, 0.9], atol=2e-3)


def test_what_looks_alike_to_the_task_needs_no_data(known: Known) -> None:
    looks = np.random.default_rng(4).standard_normal((4, 4))
    mapper = Features(source_look=looks, target_look=looks @ known.law)
    found = mapper.fit(known.given, np.random.default_rng(0))
    assert isinstance(found, AffineMap)
    np.testing.assert_allclose(found.state_law, known.law, atol=1e-10)


def test_bodies_that_share_nothing_that_the_task_looks_at_are_refused(known: Known) -> None:
    with pytest.raises(MapError, match=r"must share a quantity"):
        Features(source_look=np.eye(4), target_look=np.eye(3, 4)).fit(
            known.given, np.random.default_rng(0)
        )


def test_a_mapper_without_its_pairs_refuses(known: Known) -> None:
    bare = MapData(source=known.given.source, target=known.given.target)
    with pytest.raises(MapError, match=r"not given pairs"):
        Manifold().fit(bare, np.random.default_rng(0))


def test_pairs_of_other_bodies_are_refused(known: Known) -> None:
    pairs = Pairs(source=np.zeros((3, 2)), target=np.zeros((3, 4)))
    given = MapData(source=known.given.source, target=known.given.target, pairs=pairs)
    with pytest.raises(SamplesError, match=r"have 2 and 4 numbers"):
        Uma().fit(given, np.random.default_rng(0))


def test_a_map_that_loses_a_number_of_the_source_is_refused(known: Known) -> None:
    S = known.law.copy()
    S[1] = S[0]
    with pytest.raises(MapError, match=r"seen as fewer than the source's 4"):
        followed(
            StateLaw(S=S, s=np.zeros(4)),
            known.given.source,
            known.given.target,
            horizon=5,
            effort=0.1,
        )


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: PcaAffine(horizon=0), r"horizon is 0"),
        (lambda: Manifold(nearest=1), r"1 neighbours"),
        (lambda: Sparse(active=50), r"50 of 40 atoms"),
        (lambda: Transport(shape=0.0), r"shape counts 0"),
    ],
)
def test_a_setting_out_of_range_is_refused(make: object, words: str) -> None:
    assert callable(make)
    with pytest.raises(SettingError, match=words):
        make()


def test_neighbourhoods_are_alike_whatever_their_size_and_the_order_of_neighbours() -> None:
    # A square of twice the size with its corners in another order is the same pattern: exp(0).
    square = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.1]])
    other = 2.0 * square[[0, 2, 1, 3]]
    line = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]])
    R = patterns(square, 3)[:1]
    both = np.concatenate([patterns(other, 3)[:1], patterns(line, 3)[:1]])
    found = alike(R, both)[0]
    assert found[0] == pytest.approx(1.0, abs=1e-6)
    assert found[1] < 0.9


def test_neighbours_weigh_more_the_nearer_they_are() -> None:
    found = neighbours(np.array([[0.0], [1.0], [3.0], [10.0]]), 1)
    np.testing.assert_array_equal(found, found.T)
    # Nearest of each: 0-1, 1-0, 3-1, 10-3; squared 1, 1, 4, 4, 49, 49 in the symmetric graph.
    width = (1 + 1 + 4 + 4 + 49 + 49) / 6
    assert found[0, 1] == pytest.approx(np.exp(-0.5 / width))
    assert found[0, 2] == 0.0


def test_a_joint_embedding_with_all_pairs_is_the_map_between_them() -> None:
    # With every state paired and hardly any neighbours' weight, alpha' x = beta' y for y = T x.
    rng = np.random.default_rng(7)
    x = rng.standard_normal((60, 2))
    T = np.array([[0.0, -2.0], [0.5, 0.3]])
    y = x @ T.T
    little = 1e-4 * neighbours(x, 3)
    alpha, beta = together(x, y, little, little, np.eye(60), 2)
    np.testing.assert_allclose(across(alpha, beta, where="test") @ T, np.eye(2), atol=1e-3)


def test_an_embedding_that_lost_a_direction_is_refused() -> None:
    alpha = np.array([[1.0, 1.0], [1.0, 1.0]])
    with pytest.raises(MapError, match=r"lost a direction"):
        across(alpha, np.eye(2), where="test")


def test_pursuit_finds_the_atoms_that_made_a_datum() -> None:
    # Orthonormal atoms: the code is the product with each, and two suffice.
    atoms = np.linalg.qr(np.random.default_rng(8).standard_normal((5, 5)))[0]
    code = np.array([[0.0, 2.0, 0.0, -1.0, 0.0]])
    np.testing.assert_allclose(coded(code @ atoms, atoms, 2), code, atol=1e-6)


def test_atoms_are_learned_that_make_what_was_seen() -> None:
    # Data on three lines in the plane are made by one atom each if the three lines are found.
    rng = np.random.default_rng(9)
    lines = np.array([[1.0, 0.0], [0.0, 1.0], [0.6, 0.8]])
    z = rng.standard_normal((90, 1)) * lines[rng.integers(3, size=90)]
    atoms = dictionary(z, 8, 1, np.random.default_rng(1))
    off = z - coded(z, atoms, 1) @ atoms
    assert np.square(off).sum() < 0.01 * np.square(z).sum()


def test_a_plan_takes_every_point_of_a_turned_triangle_to_its_own() -> None:
    # Three points with different distances: only one plan keeps them, whatever the turn.
    points = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 3.0]])
    turned = points @ np.array([[0.0, 1.0], [-1.0, 0.0]])
    within = [np.linalg.norm(each[:, None] - each, axis=-1) for each in (points, turned)]
    plan = fused(np.zeros((3, 3)), within[0], within[1], 1.0)
    np.testing.assert_allclose(plan, np.eye(3) / 3.0, atol=1e-6)


def test_geometry_alone_cannot_tell_a_body_from_its_mirror_image(known: Known) -> None:
    # Distances within the mirrored body are the same, so is the map but for the mirror.
    mirror = np.diag([1.0, -1.0, 1.0, -1.0])
    target = known.given.target
    mirrored = Transitions(
        state=target.state @ mirror, command=target.command, after=target.after @ mirror,
        turns=target.turns,
    )  # fmt: skip
    first, second = (
        Transport().states(
            MapData(source=known.given.source, target=each), np.random.default_rng(1)
        )
        for each in (target, mirrored)
    )
    np.testing.assert_allclose(first.S, second.S @ mirror, atol=1e-6)
