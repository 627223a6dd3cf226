"""A relay counts every sample, knows of bodies on its way only what they showed, and finds ways."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from align.samples import Transitions
from morph.errors import TransferError
from morph.transfer.balancers import balancer
from morph.transfer.body import Body, linear_law
from morph.transfer.mapped.belief import read
from morph.transfer.mapped.feedback import plain
from morph.transfer.relay import as_believed, fused, nearest_path, relay, same


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


def test_without_noise_many_transitions_outweigh_what_was_believed(bodies: list[Body]) -> None:
    # x'' = law (x, u) exactly, and noise held to be 1e-6: of a belief of width w 4000 draws leave
    # the share v / (4000 w^2), v = 16 * 2 * 1e-12 / 0.02^2 = 8e-8 and w >= 0.003: 3e-6.
    task = replace(bodies[1].task, noise=0.0)
    body, rng = replace(bodies[1], task=task), np.random.default_rng(0)
    law = rng.normal(size=(2, 5))
    state, command = rng.normal(size=(4000, 4)), rng.normal(size=(4000, 1))
    after = state.copy()
    after[:, 2:] += body.task.period * np.hstack([state, command]) @ law.T
    seen = Transitions(state=state, command=command, after=after, turns=np.zeros(4, dtype=bool))
    wrong = 1.3 * law
    found = fused(wrong, seen, body)
    assert np.abs(found.law - law).max() < 1e-4 * np.abs(wrong - law).max()


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
