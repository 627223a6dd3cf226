"""Body and policy sought together."""

from __future__ import annotations

from functools import partial

import mujoco
import numpy as np
import pytest

from experiments.codesign import design as quadruped
from morph.body.load import load
from morph.body.spec import spec_of
from morph.errors import SearchError
from morph.search.codesign import Design, lowest, sought, standing
from morph.search.family.gait import gait
from morph.sim.start import started
from morph.task.walk import walk


@pytest.fixture(scope="module")
def plan() -> Design:
    """Return what is free of the printed quadruped."""
    return quadruped()


def test_the_start_is_the_body_as_it_is_described(plan: Design) -> None:
    values = plan.values(plan.start)
    assert values["front_left_lower_leg_size"] == pytest.approx(1.0)
    before = {link.name: link.mass for link in plan.robot.links}
    after = {link.name: link.mass for link in plan.body(plan.start).links}
    assert after == pytest.approx(before, rel=1e-6)


def test_legs_of_a_group_grow_alike(plan: Design) -> None:
    point = plan.start.copy()
    point[-2:] = 0.75, 0.25
    values = plan.values(point)
    # 0.5 to 1.5: three quarters of the way is 1.25.
    assert values["front_left_lower_leg_size"] == values["front_right_lower_leg_size"] == 1.25
    assert values["rear_left_lower_leg_size"] == 0.75


def test_a_body_on_longer_legs_begins_on_the_floor(plan: Design) -> None:
    point = plan.start.copy()
    point[-2:] = 0.9
    task = standing(plan.pose(plan.body(point)))
    model = spec_of(task.robot).compile()
    data = mujoco.MjData(model)
    data.qpos, _ = started(task.robot, model, task.start.position, {})
    mujoco.mj_kinematics(model, data)
    assert lowest(model, data) == pytest.approx(0.0, abs=1e-9)


def test_legs_that_do_not_move_go_nowhere(plan: Design) -> None:
    point = plan.start.copy()
    point[[n.name.endswith("amplitude") for n in plan.policies.numbers] + [False] * 2] = 0.0
    far = plan.far(point, rng=np.random.default_rng(0))
    # It sinks into its servos by a few millimetres.
    assert abs(far) < 0.02


def test_only_what_is_free_is_turned(monkeypatch: pytest.MonkeyPatch, plan: Design) -> None:
    # The distance is a number's own: what is sought goes up, what is not free stays.
    monkeypatch.setattr(Design, "far", lambda self, point, *, rng, rows=1: float(point[-2:].sum()))
    found = sought(plan, ((~plan.of_policy, 8),), seed=100)
    assert (found.point[plan.of_policy] == plan.start[plan.of_policy]).all()
    assert found.point[-2:].sum() > plan.start[-2:].sum() + 0.4
    assert found.runs == 8 * 12
    assert (np.diff(found.curve) >= 0.0).all()


def test_a_parameter_that_the_card_has_not_is_refused() -> None:
    with pytest.raises(SearchError, match=r"no parameter tail_length"):
        Design(
            robot=load("quadruped_printed"),
            groups=(("tail_length",),),
            pose=partial(walk, distance=0.5, horizon=4.0),
            family=lambda task: gait(task.robot, period=task.period),
        )
