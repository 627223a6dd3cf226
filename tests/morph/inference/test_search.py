"""Sets of effects against least squares on the columns themselves."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from morph.inference.level import EffectColumn, WhitenedLevel
from morph.inference.search import BeamSearch, Prior
from morph.physics import EFFECTS
from morph.physics.effect import Effect

READINGS = 200
PRICES = (3.0, 7.0, 5.0, 4.0)
KINDS = {kind.__name__: kind for kind in EFFECTS}
EFFECTS_TRIED: tuple[Effect, ...] = (
    KINDS["ViscousFriction"].at("a"),
    KINDS["CoulombFriction"].at("a"),
    KINDS["ViscousFriction"].at("b"),
    KINDS["CoulombFriction"].at("b"),
)


def columns(rng: np.random.Generator, own: int) -> np.ndarray:
    """Return columns of own parameters and effects, shape (readings, own + 4)."""
    return rng.normal(size=(READINGS, own + len(EFFECTS_TRIED)))


def searched(
    table: np.ndarray,
    error: np.ndarray,
    own: int,
    together: tuple[tuple[frozenset[str], float], ...] = (),
) -> BeamSearch:
    """Return a search among the effects, whose strengths are small beside their bounds."""
    whole = np.column_stack([error, table])
    ends = np.arange(2, 2 + len(EFFECTS_TRIED))
    return BeamSearch(
        columns=tuple(
            EffectColumn(effect=effect, place=slice(end - 1, end))
            for effect, end in zip(EFFECTS_TRIED, ends, strict=True)
        ),
        prior=Prior(
            alone={e.label: price for e, price in zip(EFFECTS_TRIED, PRICES, strict=True)},
            together=together,
        ),
        levels=(
            WhitenedLevel(gram=whole.T @ whole, logarithm=0.0, low=np.full(own, -1e3),
                  high=np.full(own, 1e3)),
        ),
        readings=READINGS,
    )  # fmt: skip


def left(table: np.ndarray, error: np.ndarray) -> float:
    """Return the sum of squares that columns leave."""
    fit = np.linalg.lstsq(table, error, rcond=None)[0]
    return float(np.sum((error - table @ fit) ** 2))


def gain(table: np.ndarray, error: np.ndarray, own: int, chosen: Sequence[int]) -> float:
    """Return by how much more likely a set of effects is, by Schwarz's criterion and its prices."""
    with_them = left(table[:, [*range(own), *(own + each for each in chosen)]], error)
    price = sum(PRICES[each] for each in chosen) + 0.5 * len(chosen) * math.log(READINGS)
    return 0.5 * (left(table[:, :own], error) - with_them) - price


@pytest.mark.parametrize("own", [0, 3])
def test_every_set_has_the_gain_of_its_columns(own: int) -> None:
    rng = np.random.default_rng(own)
    table = columns(rng, own)
    strengths = np.array([*rng.normal(size=own), 0.8, 0.0, 0.9, 0.0])
    error = table @ strengths + rng.normal(size=READINGS)
    found = searched(table, error, own).sets(4)
    seen = {frozenset(effect.label for effect in each.effects): each.gain for each in found}
    for chosen in [(), (0,), (2,), (0, 2)]:
        label = frozenset(EFFECTS_TRIED[each].label for each in chosen)
        # Nine-digit sums of squares near 200.
        assert seen[label] == pytest.approx(gain(table, error, own, chosen), abs=1e-6)
    best = max(
        (chosen for size in range(4) for chosen in itertools.combinations(range(4), size)),
        key=lambda chosen: gain(table, error, own, chosen),
    )
    assert {effect.label for effect in found[0].effects} == {EFFECTS_TRIED[i].label for i in best}
    assert best == (0, 2)


def test_two_effects_are_found_of_which_neither_explains_much_alone() -> None:
    rng = np.random.default_rng(5)
    table = columns(rng, 0)
    # The third column hides the first but for a tenth: alone neither leaves less.
    table[:, 2] = -table[:, 0] + 0.1 * rng.normal(size=READINGS)
    error = table @ [9.0, 0.0, 9.0, 0.0] + 0.1 * rng.normal(size=READINGS)
    error *= 10.0
    alone = [gain(table, error, 0, (each,)) for each in (0, 2)]
    assert max(alone) < 0.25 * gain(table, error, 0, (0, 2))
    best = searched(table, error, 0).sets(2)[0]
    assert [effect.label for effect in best.effects] == [EFFECTS_TRIED[i].label for i in (0, 2)]


def test_a_strength_stays_within_its_bounds() -> None:
    rng = np.random.default_rng(1)
    table = columns(rng, 0)
    # No friction drives.
    error = -5.0 * table[:, 0] + rng.normal(size=READINGS)
    found = searched(table, error, 0).sets(1)
    (driving,) = [e for e in found if [one.label for one in e.effects] == [EFFECTS_TRIED[0].label]]
    assert driving.gain == pytest.approx(-PRICES[0] - 0.5 * math.log(READINGS), abs=1e-6)


def test_of_equal_columns_the_cheaper_effect_stands_first() -> None:
    rng = np.random.default_rng(2)
    table = columns(rng, 0)
    table[:, 1] = table[:, 0]
    error = 0.9 * table[:, 0] + rng.normal(size=READINGS)
    first, second, *_ = searched(table, error, 0).sets(1)
    assert first.effects[0].label == EFFECTS_TRIED[0].label
    assert second.effects[0].label == EFFECTS_TRIED[1].label
    assert first.gain - second.gain == pytest.approx(PRICES[1] - PRICES[0], abs=1e-6)


def test_effects_that_come_together_cost_less() -> None:
    rng = np.random.default_rng(3)
    table = columns(rng, 0)
    error = table @ [0.8, 0.0, 0.9, 0.0] + rng.normal(size=READINGS)
    pair = frozenset(EFFECTS_TRIED[i].label for i in (0, 2))
    best = searched(table, error, 0, ((pair, 4.0),)).sets(2)[0]
    assert {effect.label for effect in best.effects} == pair
    # Four nats together in place of three and five.
    assert best.gain == pytest.approx(gain(table, error, 0, (0, 2)) + 3.0 + 5.0 - 4.0, abs=1e-6)


@pytest.mark.parametrize("unseen", [0, 1])
def test_odds_of_another_in_the_place_of_an_effect(unseen: int) -> None:
    """A parameter of the effect that does nothing, a column of zeros, costs nothing."""
    rng = np.random.default_rng(4)
    table = columns(rng, 0)
    error = table @ [0.8, 0.0, 0.3, 0.0] + rng.normal(size=READINGS)
    alone = searched(table, error, 0)
    # The first column among the own parameters, as an effect that was found before.
    own = 1 + unseen
    whole = np.column_stack([error, table[:, :1], np.zeros((READINGS, unseen)), table[:, 1:]])
    others = enumerate(alone.columns[1:], 1)
    search = replace(
        alone,
        columns=tuple(replace(each, place=slice(i, i + 1)) for i, each in others),
        levels=(
            WhitenedLevel(
                gram=whole.T @ whole, logarithm=0.0, low=np.full(own, -9.0), high=np.full(own, 9.0)
            ),
        ),
        found=EFFECTS_TRIED[:1],
    )
    none, instead = search.instead(EFFECTS_TRIED[0].label, np.arange(own), np.zeros(own))
    held = gain(table, error, 0, (0,))
    assert none == pytest.approx(-held, abs=1e-6)
    found = {effect.label: nats for effect, nats in instead}
    for each in (1, 2, 3):
        due = gain(table, error, 0, (each,)) - held
        assert found[EFFECTS_TRIED[each].label] == pytest.approx(due, abs=1e-6) or due < -held


def test_a_figure_that_is_held_changes_the_errors_by_its_column() -> None:
    rng = np.random.default_rng(5)
    table = columns(rng, 1)
    error = rng.normal(size=READINGS)
    (level,) = searched(table, error, 1).levels
    held = level.fixed(np.array([0]), np.array([0.7]))
    whole = np.column_stack([error - 0.7 * table[:, 0], table[:, 1:]])
    assert held.gram == pytest.approx(whole.T @ whole)


@pytest.mark.parametrize("seed", range(8))
def test_what_is_not_fitted_could_not_be_the_best(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = np.random.default_rng(seed)
    table = columns(rng, 1)
    # Friction only takes: half of the strengths of this error end at their bounds.
    error = table @ rng.normal(size=5) + rng.normal(size=READINGS)
    search = replace(searched(table, error, 1), groups=((0, 1), (2, 3), (1, 2)))
    every = {each.members: each.gain for each in search.sets(1)}
    best = max((m for m in every if m), key=lambda members: every[members])
    monkeypatch.setattr("morph.inference.search.SINGLES", 1)
    few = {each.members: each.gain for each in search.sets(1)}
    assert few[best] == pytest.approx(every[best], rel=1e-12)
    assert len(few) < len(every)


def test_what_excludes_an_effect_found_before_is_not_added_and_is_its_rival(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    kind = KINDS["ViscousFriction"]
    monkeypatch.setattr(kind, "beside", lambda self, other: not isinstance(other, kind))
    rng = np.random.default_rng(6)
    table = columns(rng, 0)
    alone = searched(table, table @ [0.3, 0.0, 0.5, 0.0] + rng.normal(size=READINGS), 0)
    assert not any(len(each.members) > 1 and {0, 2} <= {*each.members} for each in alone.sets(3))
    # The first of them was found: its column is an own parameter, and the rest is the dictionary.
    (level,) = alone.levels
    whole = replace(level, low=np.full(1, -9.0), high=np.full(1, 9.0))
    others = enumerate(alone.columns[1:], 1)
    search = replace(
        alone,
        columns=tuple(replace(each, place=slice(i, i + 1)) for i, each in others),
        levels=(whole,),
        found=EFFECTS_TRIED[:1],
    )
    added = {effect.label for each in search.sets(2) for effect in each.effects}
    assert EFFECTS_TRIED[2].label not in added
    _, rivals = search.instead(EFFECTS_TRIED[0].label, np.array([0]), np.zeros(1))
    assert EFFECTS_TRIED[2].label in {effect.label for effect, _ in rivals}


def test_what_acts_through_another_is_added_with_it_and_never_stands_alone() -> None:
    rng = np.random.default_rng(7)
    table = columns(rng, 0)
    error = table @ [0.3, 0.0, 1.5, 0.0] + rng.normal(size=READINGS)
    search = replace(searched(table, error, 0), needs={2: 0})
    found = search.sets(2)
    # One step adds both, though a step adds one effect.
    assert (0, 2) in {each.members for each in search.sets(1)}
    assert found[0].members == (0, 2)
    assert all(0 in each.members for each in found if 2 in each.members)
    assert search.single(found[0])
    assert not search.single(next(each for each in found if each.members == (0, 1)))
    # Beside the one through which it acts it is one step more.
    began = replace(search, needs={2: 0, 3: 1}).sets(2)
    assert (0, 1, 2, 3) in {each.members for each in began}


def test_what_does_nothing_here_is_no_explanation() -> None:
    rng = np.random.default_rng(8)
    table = columns(rng, 0)
    table[:, 1] = 0.0
    search = searched(table, rng.normal(size=READINGS), 0)
    assert all(1 not in each.members for each in search.sets(2))
