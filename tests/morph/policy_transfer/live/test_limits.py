from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from morph.body.load import load
from morph.errors import TransferError
from morph.policy_transfer.live.limits import LimitGuard, Limits
from morph.sim.simulator import Simulator
from morph.task.task import Task


def guard(swing: Task, **limits: object) -> LimitGuard:
    return LimitGuard(Limits(**limits), swing.robot, swing.simulator().model, swing.period)  # type: ignore[arg-type]


def test_a_command_beyond_the_motor_is_clipped_to_its_limit(swing: Task) -> None:
    told, held = guard(swing).allowed(np.array([25.0]), np.array([0.0]))
    # The card's limit is 10 N.
    assert told.tolist() == [10.0]
    assert held.tolist() == [True]


def test_the_users_limit_counts_beside_the_motors(swing: Task) -> None:
    both = guard(swing, command={"slide": (-20.0, 4.0)})
    assert both.allowed(np.array([25.0]), np.zeros(1))[0].tolist() == [4.0]
    assert both.allowed(np.array([-25.0]), np.zeros(1))[0].tolist() == [-10.0]


def test_a_command_changes_no_faster_than_its_rate(swing: Task) -> None:
    # 40 N/s for 0.05 s are 2 N.
    slow = guard(swing, rate={"slide": 40.0})
    told = [0.0]
    for _ in range(4):
        told.append(float(slow.allowed(np.array([7.0]), np.array([told[-1]]))[0][0]))
    assert told == [0.0, 2.0, 4.0, 6.0, 7.0]


def test_a_servo_starts_from_where_its_joint_is() -> None:
    arm = load("so101")
    model = Simulator(arm).model
    servos = LimitGuard(Limits(), arm, model, 0.02)
    position = np.clip(0.1 * np.arange(model.nq), servos.low, servos.high)
    np.testing.assert_allclose(servos.rest(position), position[: len(arm.actuators)])


@pytest.mark.parametrize(
    ("q", "v", "says"),
    [
        ([0.0, 7.0], [0.0, 0.0], None),
        ([0.41, 0.0], [0.0, 0.0], r"slide is at 0.41 m, beyond its limits -0.4 and 0.4 m"),
        ([0.0, 0.0], [0.0, -9.0], r"hinge moves at -9 rad/s, beyond its limit 8 rad/s"),
    ],
)
def test_a_state_beyond_a_limit_is_named(
    swing: Task, q: list[float], v: list[float], says: str | None
) -> None:
    watched = guard(swing, position={"slide": (-0.4, 0.4)}, speed={"hinge": 8.0})
    assert watched.breach(np.array(q), np.array(v)) == says


def test_a_reading_may_be_a_little_beyond_the_limit_of_a_description() -> None:
    arm = load("so101")
    model = Simulator(arm).model
    joint = arm.joints[0]
    assert joint.limits is not None
    at, still = np.zeros(model.nq), np.zeros(model.nv)
    found = []
    # The slack is 0.05 rad.
    for beyond in (0.04, 0.06):
        at[0] = joint.limits[1] + beyond
        found.append(LimitGuard(Limits(), arm, model, 0.02).breach(at, still) is not None)
    assert found == [False, True]


def test_the_users_limits_do_not_loosen_those_of_the_description() -> None:
    arm = load("so101")
    first = arm.joints[0]
    assert first.limits is not None
    arm = replace(arm, joints=(replace(first, velocity=2.0), *arm.joints[1:]))
    model = Simulator(arm).model
    wide = Limits(position={first.name: (-99.0, 0.5)}, speed={first.name: 50.0})
    watched = LimitGuard(wide, arm, model, 0.02)
    at, rate = np.zeros(model.nq), np.zeros(model.nv)
    found = []
    # Below: the description's, and 0.05 rad of slack. Above: the user's. Speed: 2.05 rad/s.
    for q, v in (
        (first.limits[0] - 0.04, 0.0),
        (first.limits[0] - 0.06, 0.0),
        (0.49, 2.04),
        (0.51, 0.0),
        (0.0, 2.06),
    ):
        at[0], rate[0] = q, v
        found.append(watched.breach(at, rate) is not None)
    assert found == [False, True, False, True, True]
    with pytest.raises(TransferError, match=r"outside those of the description"):
        LimitGuard(Limits(position={first.name: (8.0, 9.0)}), arm, model, 0.02)


@pytest.mark.parametrize(
    ("limits", "says"),
    [
        ({"command": {"slid": (0.0, 1.0)}}, r"no actuator 'slid'[\s\S]*'slide'"),
        ({"speed": {"pole": 1.0}}, r"no joint 'pole'"),
        ({"command": {"slide": (1.0, -1.0)}}, r"the limits of slide are 1 and -1"),
        ({"rate": {"slide": -1.0}}, r"the limit of slide is -1"),
        ({"command": {"slide": (20.0, 30.0)}}, r"outside the actuator's own"),
        ({"position": {"slide": (float("nan"), 1.0)}}, r"the limits of slide are nan and 1"),
    ],
)
def test_a_limit_that_is_none_is_refused(swing: Task, limits: dict[str, object], says: str) -> None:
    with pytest.raises(TransferError, match=says):
        guard(swing, **limits)
