"""A design's state, read again."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from typing import Any

import pytest

from morph.app.viewer.design.design_state import BodyPlan
from morph.app.viewer.views.design import DesignView
from morph.body.robot import Robot
from morph.errors import ViewError


@pytest.fixture
def plan(arm: Callable[..., Robot]) -> BodyPlan:
    return BodyPlan(arm())


def test_a_state_shows_the_same_again(plan: BodyPlan) -> None:
    view = DesignView((plan, plan))
    view.choose(1)
    view.turn("elbow", 0.5)
    view.set("lower: mass", 1.5)
    view.show_original(False)
    state = json.loads(json.dumps(view.state()))
    other = DesignView((plan, plan))
    other.restore(state)
    assert other.state() == state
    assert other.at == 1
    assert not other.ghost
    assert other.bench.built.robot.mass == pytest.approx(3.5, abs=1e-12)
    assert other.content().actors[0].motion.turn[0, 2] == pytest.approx(
        # Half of 0.5 rad about +y.
        [math.cos(0.25), 0.0, math.sin(0.25), 0.0],
        abs=1e-12,
    )


def test_an_empty_state_is_the_beginning(plan: BodyPlan) -> None:
    view = DesignView((plan,))
    view.restore({})
    assert view.at == 0
    assert view.bench.choice.values == {}


@pytest.mark.parametrize(
    ("state", "told"),
    [
        ([], r"it holds list instead of a table"),
        ({"colour": 1}, r"there is no 'colour'"),
        ({"body": 1}, r"the body 1 is not one of the 1 that are shown"),
        ({"body": True}, r"the body True is not one"),
        ({"body": "0"}, r"the body '0' is not one"),
        ({"show_original": 1}, r"neither true nor false"),
        ({"designs": {"7": {}}}, r"it designs body 7 of 1|it designs body '7' of 1"),
        ({"designs": {"0": 3}}, r"it holds int instead of a table"),
        ({"designs": {"0": {"parameters": {"wing: mass": 1.0}}}}, r"there is no 'wing: mass'"),
        ({"designs": {"0": {"parameters": {"lower: mass": 9.0}}}}, r"outside 0\.5 to 2"),
        ({"designs": {"0": {"parameters": {"lower: mass": None}}}}, r"'None' is no number"),
        ({"designs": {"0": {"pose": {"elbow": math.nan}}}}, r"'nan' is no number"),
        ({"designs": {"0": {"pose": {"tail": 0.1}}}}, r"there is no 'tail'"),
    ],
)
def test_a_state_that_does_not_fit_is_refused(plan: BodyPlan, state: Any, told: str) -> None:
    with pytest.raises(ViewError, match=told):
        DesignView((plan,)).restore(state)
