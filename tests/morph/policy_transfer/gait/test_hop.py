"""Gaits carried along a chain: what is counted, what is chosen, what is refused."""

import math

import numpy as np
import pytest

from morph.errors import TransferError
from morph.policy_transfer.gait.controls import CONTROLS, control
from morph.policy_transfer.gait.direct import GaitSearchResult, direct
from morph.policy_transfer.gait.free import free
from morph.policy_transfer.gait.hop import Budget, GaitBody, family_of, scaled
from morph.policy_transfer.gait.limbs import Limb
from morph.policy_transfer.gait.relay import Chained, relay
from morph.policy_transfer.gait.swimmers import swimmer
from morph.policy_transfer.gait.wave import at, wave

FEW = Budget(transitions=10, trials=9)


@pytest.fixture(scope="module")
def chained() -> Chained:
    names = ("swimmer_three_links", "sea_snake_planar")
    return relay([swimmer(name, seconds=2.0) for name in names], seed=100, learning=10, budget=FEW)


def test_every_sample_on_a_target_is_counted(chained: Chained) -> None:
    # Five servos, ten transitions each, and nine trials of 2 s at 50 Hz.
    assert chained.samples_total == 5 * 10 + 9 * 100
    assert chained.bodies[0].samples == 2 * 10 + 10 * 100


def test_what_is_kept_is_the_fastest_of_what_was_tried(chained: Chained) -> None:
    last = chained.bodies[-1]
    assert last.speed == last.speeds.max()
    assert last.mover.speed([last.policy])[0] == pytest.approx(last.speed, rel=1e-9)


def test_the_first_trial_is_the_sources_wave_at_the_pace_of_the_target(chained: Chained) -> None:
    source, last = chained.bodies
    expected = scaled(source.values, source.late / last.late)
    family = family_of(last.mover, last.limbs)
    np.testing.assert_allclose(last.tried[0], family.values(at(family, expected)))
    assert last.speeds[0] == last.first["zero_shot"]


def test_the_same_seed_gives_the_same_chain(chained: Chained) -> None:
    movers = [each.mover for each in chained.bodies]
    again = relay(movers, seed=100, learning=10, budget=FEW)
    np.testing.assert_array_equal(again.bodies[-1].speeds, chained.bodies[-1].speeds)


@pytest.mark.parametrize("name", CONTROLS)
def test_a_control_has_as_many_trials_as_the_chain(name: str, chained: Chained) -> None:
    source, last = chained.bodies
    found = control(name, source, last, rng=np.random.default_rng(0), budget=FEW)
    assert isinstance(found, GaitBody)
    assert len(found.speeds) == FEW.trials


def test_a_body_that_is_told_to_rest_goes_nowhere() -> None:
    body = swimmer("sea_snake", seconds=1.5)
    family = free(body.action, period=body.task.period)
    still = np.zeros(len(family.numbers))
    still[0] = 1.0
    # It weighs what its water weighs, to the gram, and lies at rest.
    assert abs(body.speed([family.make(still)])[0]) < 1e-4


def test_a_wave_travels_from_the_front_to_the_rear() -> None:
    body = swimmer("sea_snake", seconds=1.5)
    size = len(body.action)
    limbs = tuple(
        Limb(place=(k + 1) / (size + 1), side=0.5, sense=(-1.0) ** k, sure=True)
        for k in range(size)
    )
    made = wave(body.action, limbs, period=0.02).make(np.array([1.5, 0.4, 5.0, 0.0]))
    for t in (0.0, 0.3, 0.77):
        told = made.act(np.empty(0), np.asarray(t))
        for k in range(size):
            place = (k + 1) / (size + 1)
            sine = math.sin(2.0 * math.pi * 1.5 * t - 5.0 * place)
            assert told[k] == pytest.approx((-1.0) ** k * 0.4 * sine)


def test_direct_learning_says_when_it_reached_a_speed() -> None:
    found = GaitSearchResult(point=np.zeros((4, 1)), speed=np.array([0.1, 0.3, 0.2, 0.5]))
    assert (found.trials_to(0.3), found.trials_to(0.4), found.trials_to(0.6)) == (2, 4, None)


def test_direct_learning_begins_where_its_family_does() -> None:
    body = swimmer("swimmer_three_links", seconds=1.5)
    family = free(body.action, period=body.task.period)
    found = direct(body, family, trials=10, sigma=0.2, seed=1)
    np.testing.assert_allclose(found.point[0], family.start)


def test_a_chain_of_one_body_is_refused() -> None:
    with pytest.raises(TransferError, match="a chain of 1 bodies has no target"):
        relay([swimmer("swimmer_three_links")], seed=0)


def test_a_budget_without_trials_is_refused() -> None:
    with pytest.raises(TransferError, match="0 trials"):
        Budget(trials=0)
