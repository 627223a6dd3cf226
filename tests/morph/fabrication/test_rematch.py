"""Whether a policy holds on a printed body, and what is kept if it does not."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from morph.body.load import load
from morph.errors import MakeError, PolicyError, SearchError
from morph.fabrication.link_mass import LinkMass
from morph.fabrication.match.case import Case
from morph.fabrication.match.matcher import Matcher
from morph.fabrication.match.regulator import RegulatorMatcher
from morph.fabrication.match.tune import Tune
from morph.fabrication.printed import designed, printed_robot
from morph.fabrication.rematch import UNCHANGED, Matched, rematch
from morph.policy.linear import Linear
from morph.policy.pattern import pattern
from morph.policy.policy import Policy
from morph.policy_transfer.retask import task_for
from morph.search.lqr import Lqr
from morph.search.search import Problem
from morph.task.task import Task
from morph.task.tasks import task

CART = load("cartpole")
WHOLE = task("balance", CART)
BALANCE = replace(WHOLE, horizon=3.0, goals=tuple(replace(goal, last=2.0) for goal in WHOLE.goals))
"""Runs of 3 s, in which a pole that is not held falls as well."""
BEFORE = designed(CART)["pole"]
OFF = printed_robot(
    CART,
    (
        LinkMass(
            link="pole",
            designed=BEFORE,
            predicted=replace(
                BEFORE.scaled(0.7 * BEFORE.mass), com=BEFORE.com + np.array([0.006, 0, 0])
            ),
            measured=None,
            source="estimate",
        ),
    ),
)
"""The cart-pole whose pole weighs 0.7 of what it should, 6 mm off its line."""

SHORT, LONG = 1.0, 60.0
"""Seconds: for judging alone, and for a regulator on a busy machine, which ends far before."""


@pytest.fixture(scope="module", autouse=True)
def few_runs() -> Iterator[None]:
    """Policies are judged by 20 runs, not by 100: a pole falls in every one or in none."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("morph.fabrication.match.case.MOST", 20)
        yield


@pytest.fixture(scope="module")
def learned() -> Linear:
    problem = Problem(task=BALANCE, simulator=BALANCE.simulator())
    found = Lqr().run(problem, seed=0).policy
    assert isinstance(found, Linear)
    return found


def broken(policy: Linear) -> Linear:
    return replace(policy, weight=-policy.weight)


class Failing(Matcher):
    """A way that there is not."""

    name = "failing"

    def suits(self, case: Case) -> bool:
        return True

    def proposals(self, case: Case) -> Iterator[Policy]:
        raise SearchError("no way", where="here", fix="none")
        yield case.policy


class Slow(Failing):
    """Proposes what is no better, as long as there is time."""

    name = "slow"

    def proposals(self, case: Case) -> Iterator[Policy]:
        while case.left > 0.0:
            time.sleep(0.05)
            yield case.policy


@pytest.fixture(scope="module")
def lost(learned: Linear) -> Matched:
    """What becomes of feedback of the wrong sign where no way leads to another."""
    return rematch(
        broken(learned), BALANCE, CART, learned=learned, matchers=(Failing(),), seconds=LONG
    )


def test_a_policy_on_the_body_that_it_was_learned_on_holds_exactly(learned: Linear) -> None:
    found = rematch(learned, BALANCE, CART, seconds=SHORT)
    assert (found.verdict, found.by) == ("holds", UNCHANGED)
    # The same starts and the same noise: the very same losses.
    assert (found.unchanged.printed.loss == found.unchanged.designed.loss).all()
    assert found.policy is learned


def test_a_regulator_is_made_anew_for_a_pole_off_its_line(learned: Linear) -> None:
    found = rematch(learned, BALANCE, OFF, seconds=LONG, seed=5)
    assert (found.verdict, found.by) == ("matched", "regulator")
    there = task_for(BALANCE, OFF)
    anew = Lqr().run(Problem(task=there, simulator=there.simulator()), seed=5).policy
    assert found.policy == anew
    # 6 mm of 0.7 m or so make the cart stand centimetres off until the regulator knows.
    assert found.kept.printed.mean < 0.5 * found.unchanged.printed.mean


def test_a_lost_policy_is_found_again_by_trying_alone(learned: Linear) -> None:
    # A third of the feedback lets the pole fall; a search about it needs no model.
    weak = replace(learned, weight=0.35 * learned.weight)
    tune = Tune(sigma=0.3, every=1)
    found = rematch(weak, BALANCE, CART, learned=learned, matchers=(tune,), seconds=LONG)
    assert found.unchanged.growth > 0.02
    assert found.by == tune.name
    assert found.kept.growth < found.unchanged.growth


def test_what_nothing_can_match_is_said_to_be_lost(lost: Matched) -> None:
    assert (lost.verdict, lost.by) == ("lost", UNCHANGED)
    assert lost.kept.printed.share == 0.0


def test_a_way_that_fails_is_told_and_the_next_is_tried(learned: Linear, lost: Matched) -> None:
    assert [(each.by, each.note) for each in lost.tried] == [(UNCHANGED, ""), ("failing", "no way")]
    ways = (Failing(), RegulatorMatcher())
    found = rematch(broken(learned), BALANCE, CART, learned=learned, matchers=ways, seconds=LONG)
    assert (found.verdict, found.by) == ("matched", "regulator")


def test_what_is_said_can_be_written(lost: Matched) -> None:
    said = json.loads(json.dumps(lost.said(), allow_nan=False))
    assert said["verdict"] == "lost"
    assert said["tried"][1]["loss"] is None
    assert "doing nothing costs" in said["what"]


def test_without_time_the_policy_is_judged_and_nothing_is_tried(learned: Linear) -> None:
    found = rematch(broken(learned), BALANCE, CART, learned=learned, seconds=0.0)
    assert (found.verdict, found.tried) == ("lost", ())


def test_no_way_is_begun_once_the_time_is_up(learned: Linear) -> None:
    ways = (Slow(), Slow())
    found = rematch(broken(learned), BALANCE, CART, learned=learned, matchers=ways, seconds=SHORT)
    # One way alone has its turn, or none where judging took all of the time.
    assert [each.by for each in found.tried] in ([UNCHANGED, "slow"], [UNCHANGED], [])


@pytest.mark.parametrize("seconds", [-1.0, float("nan"), float("inf")])
def test_a_time_that_is_none_is_refused(learned: Linear, seconds: float) -> None:
    with pytest.raises(MakeError, match="is no time"):
        rematch(learned, BALANCE, CART, seconds=seconds)


def test_a_policy_of_another_body_is_refused(learned: Linear) -> None:
    other: Task = task("swing-up", load("double_pendulum"))
    with pytest.raises(PolicyError, match="it commands"):
        rematch(learned, other, other.robot)


def test_a_pattern_that_does_nothing_is_tried_like_any(learned: Linear) -> None:
    # Of its one number, an offset, no evolution can be made: it is lost without a try.
    rest = pattern(CART, {}, period=BALANCE.period)
    found = rematch(rest, BALANCE, CART, learned=learned, matchers=(Tune(),), seconds=SHORT)
    assert (found.verdict, found.tried) == ("lost", ())
    assert np.isfinite(found.kept.growth)
