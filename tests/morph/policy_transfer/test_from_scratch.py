from __future__ import annotations

from dataclasses import replace

from morph.policy_transfer.balancers import balancer
from morph.policy_transfer.body import still_law
from morph.policy_transfer.from_scratch import DIRECTIONS, scratch


def test_it_begins_at_holding_still_and_becomes_better_on_a_body_that_is_easy() -> None:
    body = balancer("cart_two_links")
    found = scratch(body, rows=2, seed=100, rounds=3)
    # 5 s of 20 ms are 250 transitions a run, and a round has 4 directions both ways.
    assert found.samples == tuple(2 * DIRECTIONS * 250 * at for at in (1, 2, 3))
    assert found.scores.shape == (1, 3)
    assert found.scores[0, -1] > body.score(still_law(1), rows=2, seed=100) + 0.1


def test_the_same_seed_searches_the_same_way() -> None:
    whole = balancer("cart_two_links")
    goals = tuple(replace(goal, last=0.5) for goal in whole.task.goals)
    body = replace(whole, task=replace(whole.task, horizon=0.5, goals=goals))
    one, two = (scratch(body, rows=1, seed=7, rounds=1).scores for _ in range(2))
    assert one.tolist() == two.tolist()
