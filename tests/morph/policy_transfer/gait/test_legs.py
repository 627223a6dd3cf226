"""Legs: which servo swings and which lifts, held against kinematics of the descriptions."""

import math
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from morph.body.load import load
from morph.body.spec import spec_of
from morph.errors import TransferError
from morph.policy.policy import Action
from morph.policy_transfer.gait.hop import Budget, felt
from morph.policy_transfer.gait.legs import legs
from morph.policy_transfer.gait.limbs import Limb, Responses
from morph.policy_transfer.gait.pace import pace
from morph.policy_transfer.gait.walkers import walker

BUDGET = Budget(transitions=40, width=0.3)


def test_legs_of_the_printed_quadruped_swing_by_the_hip_and_lift_by_the_knee() -> None:
    body = walker("quadruped_printed")
    found, _, samples = felt(body, BUDGET, np.random.default_rng(100))
    assert [each.role for each in found] == ["swing", "lift"] * 4
    # One command for left and right gives two mirrored legs, as the description says.
    assert [each.sense for each in found] == [1.0] * 8
    assert samples == 8 * (40 + 20)


def test_legs_of_four_bars_swing_the_way_that_their_feet_go() -> None:
    body = walker("quadruped_four_bar")
    found, _, _ = felt(body, BUDGET, np.random.default_rng(100))
    assert [each.role for each in found] == ["lift", "swing"] * 4
    model: Any = spec_of(body.robot).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    for at, actuator in enumerate(body.robot.actuators):
        if found[at].role != "swing":
            continue
        # By the description a shank lifts what points outward: its foot goes out along the
        # leg, which is ahead in front and back at the rear.
        leg = actuator.name.removesuffix("_knee_servo")
        foot = data.site(f"{leg}_foot").xpos
        assert found[at].sense == np.sign(foot[0])


STILTS = """<mujoco model="stilts"><worldbody><body><freejoint/><geom size="0.1"/>
<body name="left" pos="0 0.1 0"><joint name="left_hip" axis="0 1 0"/><geom size="0.05"/></body>
<body name="right" pos="0 -0.1 0"><joint name="right_hip" axis="0 1 0"/><geom size="0.05"/></body>
</body></worldbody><actuator><position name="left_hip" joint="left_hip" kp="1"/>
<position name="right_hip" joint="right_hip" kp="1"/></actuator></mujoco>"""
"""A body on two legs that swing and do not lift."""


def test_a_leg_of_one_servo_is_refused(tmp_path: Path) -> None:
    (tmp_path / "stilts.xml").write_text(STILTS)
    ones = np.ones((2, 6))
    flat = Responses(trunk=ones, end=ones, error=ones, late=0.1)
    with pytest.raises(TransferError, match="a leg has 1 servo, left_hip"):
        legs(flat, load(tmp_path / "stilts.xml"))


def test_a_pace_keeps_the_lags_between_its_corners() -> None:
    action = tuple(Action(actuator=name, unit="rad", low=-0.5, high=1.5) for name in "abcd")
    limbs = tuple(
        Limb(place=place, side=side, sense=-1.0, sure=True, role=role)
        for place, side, role in ((0, 0, "swing"), (0, 0, "lift"), (1, 1, "swing"), (1, 1, "lift"))
    )
    values = np.array([2.0, 0.3, 0.2, 0.7, 1.1, 0.4, 0.1])
    told = pace(action, limbs, period=0.02).make(values).act(np.empty(0), np.asarray(0.13))
    for at, late in ((0, 0.0), (2, 1.5)):
        t = 2.0 * math.pi * 2.0 * 0.13 - late
        # Middle 0.5 and half range 1 of every servo.
        assert told[at] == pytest.approx(0.5 - 0.3 * math.sin(t))
        assert told[at + 1] == pytest.approx(0.5 - (0.1 + 0.2 * math.sin(t + 0.7)))
