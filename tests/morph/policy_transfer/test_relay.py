"""A relay counts every sample, knows of bodies on its way only what they showed, and finds ways."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from morph.alignment.samples import Transitions
from morph.errors import TransferError
from morph.policy_transfer.balancers import balancer, seen_with
from morph.policy_transfer.body import Body, linear_law
from morph.policy_transfer.mapped.belief import read
from morph.policy_transfer.mapped.feedback import plain
from morph.policy_transfer.relay import (
    UNSEEN,
    as_believed,
    carry,
    nearest_path,
    reckoned,
    relay,
    same,
    tried,
)


@pytest.fixture(scope="module")
def bodies() -> list[Body]:
    return [balancer("cartpole"), balancer("rider_rigid_driven"), balancer("rider_rigid_passive")]


def test_a_relay_of_two_hops_balances_its_last_body(bodies: list[Body]) -> None:
    told: list[int] = []
    found = relay(bodies, counts=(40, 60), seed=100, done=lambda at, hop: told.append(hop.samples))
    assert told == [40, 60]
    assert found.samples == 100
    best = bodies[2].score(linear_law(plain(read(bodies[2]), bodies[2])), rows=2)
    # Feedback from 60 noisy transitions loses some of it; holding still has a seventh.
    assert bodies[2].score(linear_law(found.gain), rows=2) > 0.4 * best


def test_a_body_as_believed_has_the_believed_model_and_not_the_true_one(bodies: list[Body]) -> None:
    body = bodies[1]
    step = np.random.default_rng(0).normal(size=(body.size, body.size + 1))
    assert read(as_believed(body, step)) == pytest.approx(step, abs=1e-12)
    assert read(body) != pytest.approx(step, abs=0.1)


def test_a_body_that_is_wholly_seen_is_reckoned_as_noisy_as_it_is(bodies: list[Body]) -> None:
    seen = tried(bodies[1], 5, np.random.default_rng(0))
    assert reckoned(seen, bodies[1]) is bodies[1]


def test_what_is_hidden_of_a_body_counts_as_noise(bodies: list[Body]) -> None:
    # Speeds rise by 3 and 4 everywhere: sqrt((9 + 16) / 2) = 3.5355; readings have none.
    whole = seen_with(bodies[1], 0.0)
    body = replace(whole, sight=np.eye(4))
    after = np.tile([0.0, 0.0, 3.0, 4.0], (6, 1))
    seen = Transitions(
        state=np.zeros((6, 4)), command=np.zeros((6, 1)), after=after, turns=np.zeros(4, dtype=bool)
    )
    assert reckoned(seen, body).task.noise == pytest.approx(UNSEEN * np.sqrt(12.5))


def test_a_policy_carried_to_its_own_body_by_five_transitions_balances(bodies: list[Body]) -> None:
    first = plain(read(bodies[1]), bodies[1])
    hop, _ = carry(bodies[1], bodies[1], 5, seed=100, source_gain=first)
    assert bodies[1].score(linear_law(hop.gain), rows=2) > 0.95


def test_the_map_of_bodies_alike_changes_nothing(bodies: list[Body]) -> None:
    x = np.arange(4.0)[None]
    assert same(bodies[1]).state(x) == pytest.approx(x)
    assert same(bodies[1]).action(x, np.ones((1, 1))) == pytest.approx(np.ones((1, 1)))


def test_the_nearest_path_takes_two_short_hops_for_a_long_one(bodies: list[Body]) -> None:
    place = {id(body): where for body, where in zip(bodies, (0.0, 1.0, 2.0), strict=True)}

    def apart(a: Body, b: Body) -> float:
        return abs(place[id(a)] - place[id(b)])

    assert nearest_path(bodies, apart, most=3) == (0, 1, 2)
    assert nearest_path(bodies, apart, most=1) == (0, 2)


@pytest.mark.parametrize("counts", [(), (10,), (10, 0)])
def test_a_relay_with_a_count_too_few_is_refused(
    bodies: list[Body], counts: tuple[int, ...]
) -> None:
    with pytest.raises(TransferError, match=r"a count of 1 or more for each hop"):
        relay(bodies, counts=counts, seed=0)
