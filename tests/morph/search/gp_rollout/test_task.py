from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from morph.body.load import load
from morph.errors import SearchError
from morph.search.gp_rollout.task import view_of
from morph.task.moved import Moved
from morph.task.tasks import task


@pytest.mark.parametrize(
    ("name", "body", "reach"),
    [
        ("swing-up", "cartpole", 4.0),
        ("swing-up", "double_pendulum", 4.0),
        ("swing-up", "cart_two_links", 4.0),
        # An angle's error is wrapped, half a turn from the top where a balance begins.
        ("balance", "cartpole", 1.0),
        ("balance", "cart_two_links", 1.0),
    ],
)
def test_the_cost_of_a_certain_state_is_the_tasks(name: str, body: str, reach: float) -> None:
    asked = task(name, load(body))
    view = view_of(asked)
    rng = np.random.default_rng(1)
    states = view.start[0] + rng.uniform(-reach, reach, size=(50, 2 * view.joints))
    moved = Moved(
        robot=asked.robot,
        model=asked.simulator().model,
        time=np.zeros(1),
        position=states[:, None, : view.joints],
        velocity=states[:, None, view.joints :],
        command=np.zeros((50, 1, len(view.action))),
    )
    z = view.lifted(states)
    none = np.zeros((*z.shape, z.shape[-1]))
    expected = sum(cost.value(z, none)[0] for cost in view.costs)
    # Kinematics of links of about a metre, to rounding; and least squares over 400 postures.
    assert expected == pytest.approx(asked.loss(moved), abs=1e-9)


def test_a_cost_of_two_links_needs_the_sum_of_their_angles() -> None:
    view = view_of(task("swing-up", load("double_pendulum")))
    assert view.lift.angles[:, : view.joints].tolist() == [[1.0, 0.0], [0.0, 1.0], [1.0, 1.0]]
    # The policy sees each joint's own angle and both speeds, and no sum.
    assert len(view.sees) == 6


def test_a_body_with_other_joints_is_refused_by_name() -> None:
    cartpole = task("swing-up", load("cartpole"))
    free = tuple(replace(j, kind="free") if j.kind == "slide" else j for j in cartpole.robot.joints)
    other = replace(cartpole)
    object.__setattr__(other, "robot", replace(cartpole.robot, joints=free))
    with pytest.raises(SearchError, match="hinges and slides"):
        view_of(other)


def test_a_term_of_the_end_alone_is_refused_by_name() -> None:
    asked = task("swing-up", load("cartpole"))
    late = replace(asked, terms=(replace(asked.terms[0], last_only=True),))
    with pytest.raises(SearchError, match="counts at the end alone"):
        view_of(late)


def test_what_is_seen_is_what_a_policy_sees() -> None:
    from morph.policy.angles import features

    view = view_of(task("swing-up", load("cartpole")))
    states = np.random.default_rng(2).normal(size=(5, 4))
    plain, angles = np.flatnonzero(view.angles == 0.0), np.flatnonzero(view.angles)
    assert view.lifted(states)[:, view.sees] == pytest.approx(features(states, plain, angles))
