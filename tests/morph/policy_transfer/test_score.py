from __future__ import annotations

import math

import numpy as np
import pytest

from morph.body.load import load
from morph.policy.pattern import pattern
from morph.policy_transfer.score import (
    AS_IT_CAME,
    KEPT,
    SEARCHED,
    UNMEASURED,
    PolicyScores,
    judged,
    score,
)
from morph.search.evaluate import Score
from morph.search.lqr import Lqr
from morph.search.search import Problem
from morph.search.target import Simulated
from morph.task.tasks import task


@pytest.mark.parametrize(
    ("loss", "is_worth"),
    # Between 60 of holding still and 20 of the oracle, 30 has won 30 of 40.
    [(60.0, 0.0), (20.0, 1.0), (30.0, 0.75), (10.0, 1.0), (99.0, 0.0), (math.inf, 0.0)],
)
def test_a_score_is_the_share_of_the_way_from_holding_still_to_the_oracle(
    loss: float, is_worth: float
) -> None:
    assert score(loss, 60.0, 20.0) == is_worth


@pytest.mark.parametrize("oracle", [60.0, 70.0, math.nan])
def test_where_the_oracle_does_no_better_than_holding_still_nothing_is_measured(
    oracle: float,
) -> None:
    assert score(50.0, 60.0, oracle) is None


def test_without_an_oracle_no_score_is_made_up() -> None:
    one = Score(loss=np.ones(3), success=np.ones(3, dtype=bool))
    found = PolicyScores(still=one, source=one, final=one, oracle=None)
    assert found.scores() == UNMEASURED


def test_all_policies_are_judged_by_the_same_chance() -> None:
    robot = load("cartpole")
    balance = task("balance", robot)
    policy = Lqr().run(Problem(task=balance, simulator=balance.simulator()), seed=0).policy
    target = Simulated(task=balance, simulator=balance.simulator())
    rest = pattern(robot, {}, period=balance.period)
    found = judged(target, rest, policy, seed=3, rows=4)
    assert found.source.loss == pytest.approx(found.still.loss)
    # The target is the source, so the oracle is the very policy to keep.
    assert found.oracle is not None
    assert found.oracle.loss == pytest.approx(found.final.loss)
    assert found.scores()["final"] == pytest.approx(1.0)
    assert found.scores()["zero_shot"] == 0.0


def test_the_oracle_is_never_worse_than_what_it_judges(monkeypatch: pytest.MonkeyPatch) -> None:
    robot = load("cartpole")
    balance = task("balance", robot)
    policy = Lqr().run(Problem(task=balance, simulator=balance.simulator()), seed=0).policy
    target = Simulated(task=balance, simulator=balance.simulator())
    rest = pattern(robot, {}, period=balance.period)
    # A search on the true body that finds nothing, and no better plan from the policy to keep.
    monkeypatch.setattr("morph.policy_transfer.score.oracle", lambda *_, **__: rest)
    monkeypatch.setattr("morph.policy_transfer.score.improved", lambda *_, **__: None)
    for source, final, best in ((rest, policy, KEPT), (policy, rest, AS_IT_CAME)):
        found = judged(target, source, final, seed=3, rows=4)
        assert found.oracle is not None
        assert found.best == best
        assert found.oracle.mean == min(found.source.mean, found.final.mean)
    # Where a plan from it is better still, that is the oracle, and it was searched there.
    monkeypatch.setattr("morph.policy_transfer.score.improved", lambda *_, **__: policy)
    weak = Lqr().run(Problem(task=balance, simulator=balance.simulator()), seed=0).policy
    found = judged(target, rest, weak, seed=3, rows=4)
    assert found.best == SEARCHED
    assert found.scores()["final"] == pytest.approx(1.0)
