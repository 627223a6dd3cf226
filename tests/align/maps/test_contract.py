"""What every map between bodies must honour, and every way to learn one."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from morph.alignment.errors import AlignError, MapError, SamplesError
from morph.alignment.maps.body_map import BodyMap, Mapper
from morph.alignment.maps.features import Features
from morph.alignment.maps.files import read, write
from morph.alignment.maps.maps import KINDS, MAPPERS, kind_of, mapper
from morph.alignment.samples import Transitions

from .conftest import Planted

CONSISTENT = ("transition", "transition_kernel", "transition_network")
"""Those that the source's simulator teaches: they need no pairs to know a sign."""


@pytest.fixture(scope="session")
def learned(planted: Planted) -> dict[str, BodyMap]:
    ways = [told(each) for each in MAPPERS]
    return {each.name: each.fit(planted.given, np.random.default_rng(100)) for each in ways}


def told(way: Mapper) -> Mapper:
    """Tell the one that asks for it what the task looks at: the angle, then its rate."""
    if not isinstance(way, Features):
        return way
    return replace(way, source_look=np.eye(2), target_look=np.array([[0.0, -2.0], [0.5, 0.0]]))


def test_every_mapper_has_a_name_of_its_own() -> None:
    assert len({each.name for each in MAPPERS}) == len(MAPPERS)
    assert len({each.kind for each in KINDS}) == len(KINDS)


@pytest.mark.parametrize("way", MAPPERS, ids=lambda each: each.name)
def test_states_of_the_source_come_back_as_they_went(
    way: Mapper, learned: dict[str, BodyMap], planted: Planted
) -> None:
    found = learned[way.name]
    back = found.state_back(planted.state)
    assert back.shape == planted.target.shape
    # Inverses by iteration end at 1e-12 of a spread, and spreads here are below 4.
    assert np.abs(found.state(back) - planted.state).max() < 1e-8
    told = found.action(planted.target, planted.command)
    assert np.abs(found.action_back(planted.target, told) - planted.command).max() < 1e-8


@pytest.mark.parametrize("way", MAPPERS, ids=lambda each: each.name)
def test_a_map_is_the_same_after_a_file(
    way: Mapper, learned: dict[str, BodyMap], planted: Planted, tmp_path: Path
) -> None:
    found = learned[way.name]
    write(tmp_path / "map.npz", found)
    again = read(tmp_path / "map.npz")
    assert type(again) is type(found)
    np.testing.assert_array_equal(again.state(planted.target), found.state(planted.target))
    np.testing.assert_array_equal(again.state_back(planted.state), found.state_back(planted.state))
    told = found.action(planted.target, planted.command)
    np.testing.assert_array_equal(again.action(planted.target, planted.command), told)


@pytest.mark.parametrize("way", MAPPERS, ids=lambda each: each.name)
def test_what_a_mapper_needs_is_asked_for(way: Mapper, planted: Planted) -> None:
    for need in way.needs:
        with pytest.raises(MapError, match=rf"it is not given .*{need}"):
            way.fit(replace(planted.given, **{need: None}), np.random.default_rng(100))


@pytest.mark.parametrize("way", MAPPERS, ids=lambda each: each.name)
def test_a_target_that_never_moved_is_refused(way: Mapper, planted: Planted) -> None:
    still = np.zeros((150, 2))
    target = replace(planted.given.target, state=still, command=still[:, :1], after=still)
    with pytest.raises(AlignError, match=r"fix: "):
        way.fit(replace(planted.given, target=target), np.random.default_rng(100))


@pytest.mark.parametrize("name", CONSISTENT)
def test_too_few_transitions_are_refused(name: str, planted: Planted) -> None:
    # A linear model of the pendulum has 2 + 1 + 1 numbers a row; half as many again are not twice.
    seen = planted.given.target
    few = Transitions(
        state=seen.state[:6], command=seen.command[:6], after=seen.after[:6], turns=seen.turns
    )
    with pytest.raises(
        SamplesError, match=r"and 6 of the target.*\n  fix: give at least 8 of both"
    ):
        mapper(name).fit(replace(planted.given, target=few), np.random.default_rng(100))


@pytest.mark.parametrize("name", CONSISTENT)
def test_a_planted_map_is_found_with_its_signs(
    name: str, learned: dict[str, BodyMap], planted: Planted
) -> None:
    # A pendulum is its own mirror image: both signs together are right, one alone is not.
    x = learned[name].state(planted.target)
    u = learned[name].action_back(planted.target, planted.told)
    sign = np.sign(x[:, 0] @ planted.state[:, 0])
    # What the simulator foresees exactly is found to what holds the numbers, 1e-6 of their squares,
    # leaves over: a thousandth, and the curves and the network, held by 1e-4, to a hundredth.
    assert np.abs(sign * x - planted.state).max() < 0.05
    assert np.abs(sign * u - planted.command).max() < 0.02


@pytest.mark.parametrize("name", CONSISTENT)
def test_the_same_chance_finds_the_same_map(
    name: str, learned: dict[str, BodyMap], planted: Planted
) -> None:
    again = mapper(name).fit(planted.given, np.random.default_rng(100))
    for key, value in learned[name].weights().items():
        np.testing.assert_array_equal(again.weights()[key], value)


def test_names_that_are_none_are_refused() -> None:
    with pytest.raises(
        MapError, match=r"no map is called 'guess'.*\n  fix: name one of transition"
    ):
        mapper("guess")
    with pytest.raises(MapError, match=r"'guess' is no sort of map.*\n  fix: name one of affine"):
        kind_of("guess")
