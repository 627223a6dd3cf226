from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from morph.body.load import load
from morph.errors import TransferError
from morph.policy.linear import Linear
from morph.policy.observing import observations_of
from morph.policy.policy import actions_of
from morph.policy.store import load_policy, write_policy
from morph.policy_transfer.live.callable_target import Called
from morph.policy_transfer.live.limited_task import within
from morph.policy_transfer.live.limits import LimitGuard, Limits
from morph.policy_transfer.live.live import Live
from morph.policy_transfer.live.watch import Watch
from morph.policy_transfer.live.wiring import hello_for
from morph.search.target import Simulated
from morph.search.trajectory.plant import bounds_of
from morph.task.task import Task
from morph.task.tasks import task


def bounds(found: Task) -> list[float]:
    return [float(each) for side in bounds_of(found.simulator()) for each in side]


@pytest.mark.parametrize(
    ("limit", "holds"),
    [((-3.0, 3.0), [-3.0, 3.0]), ((-1.0, 3.0), [-1.0, 3.0]), ((-20.0, 4.0), [-10.0, 4.0])],
)
def test_searches_and_the_guard_know_the_limits(
    swing: Task, limit: tuple[float, float], holds: list[float]
) -> None:
    limits = Limits(command={"slide": limit})
    found = within(swing, limits)
    assert bounds(found) == holds
    guard = LimitGuard(limits, found.robot, found.simulator().model, found.period)
    assert [*guard.low.tolist(), *guard.high.tolist()] == holds
    # What actions tell is one number for both sides.
    (action,) = actions_of(found.robot)
    assert action.high == -action.low == max(-holds[0], holds[1])


def test_a_push_beyond_the_limits_moves_a_simulated_cart_as_the_limit_does(swing: Task) -> None:
    found = within(swing, Limits(command={"slide": (-1.0, 3.0)}))
    for asked, clipped in ((-9.0, -1.0), (9.0, 3.0)):
        end, clip = (
            Simulated(task=one, simulator=one.simulator())
            .trial(np.full((10, 1), push), np.random.default_rng(100))
            .velocity
            for one, push in ((found, asked), (swing, clipped))
        )
        np.testing.assert_allclose(end, clip, atol=1e-12)


def test_limits_that_tighten_nothing_leave_the_task_as_it_is(swing: Task) -> None:
    assert within(swing, Limits(rate={"slide": 9.0}, command={"slide": (-10.0, 99.0)})) is swing


def test_a_servo_keeps_its_joint_and_takes_less(swing: Task) -> None:
    arm = task("reach", load("so101"))
    name = arm.robot.actuators[0].name
    found = within(arm, Limits(command={name: (-0.2, 0.3)}))
    assert found.robot.joints[0].limits == arm.robot.joints[0].limits
    low, high = bounds_of(found.simulator())
    assert (low[0], high[0]) == (-0.2, 0.3)
    assert bounds(found)[1] == bounds(arm)[1]


def test_a_policy_of_the_body_as_described_still_loads(swing: Task, tmp_path: Path) -> None:
    found = within(swing, Limits(command={"slide": (-3.0, 3.0)}))
    assert found.robot.name != swing.robot.name
    write_policy(pushing(swing, 8.0), tmp_path / "own", swing.robot)
    write_policy(pushing(found, 8.0), tmp_path / "less", found.robot)
    assert load_policy(tmp_path / "own", found.robot).action[0].high == 10.0
    assert load_policy(tmp_path / "less", swing.robot).action[0].high == 3.0


@pytest.mark.parametrize(
    ("limit", "says"),
    [
        ({"slid": (-1.0, 1.0)}, r"no actuator 'slid'"),
        ({"slide": (2.0, 2.0)}, r"slide may be told nothing but 2 N"),
        ({"slide": (11.0, 12.0)}, r"outside the actuator's own"),
    ],
)
def test_limits_that_leave_nothing_are_refused(
    swing: Task, limit: dict[str, tuple[float, float]], says: str
) -> None:
    with pytest.raises(TransferError, match=says):
        within(swing, Limits(command=limit))


def pushing(swing: Task, push: float) -> Linear:
    """Return a policy that pushes alike all the time."""
    seen = observations_of(swing.robot)
    return Linear(
        weight=np.zeros((1, len(seen))),
        bias=np.array([push]),
        observation=seen,
        action=actions_of(swing.robot),
        period=swing.period,
    )


@pytest.mark.parametrize(("push", "said"), [(8.0, True), (2.0, False)])
def test_a_policy_made_for_wider_bounds_is_said_to_be(
    swing: Task, cart: object, push: float, said: bool
) -> None:
    target = Called(
        cart,  # type: ignore[arg-type]
        hello_for(swing.robot, swing.period),
        stopped=cart.stop,  # type: ignore[attr-defined]
    )
    live = Live(
        swing, target, limits=Limits(command={"slide": (-3.0, 3.0)}), watch=Watch(start_within=9.0)
    )
    live.trial(pushing(swing, push), np.random.default_rng(100))
    live.close()
    assert live.conduct is not None
    words = "10 of 10 commands were clipped: the policy was made for wider bounds"
    assert (words in live.conduct.notes) is said
