"""Where servos belong: learned from responses, held against what the descriptions say."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import mujoco
import numpy as np
import pytest

from morph.alignment.samples import Transitions
from morph.body.load import load
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.body.vary.apply import vary
from morph.body.vary.operation import Operation
from morph.errors import TransferError
from morph.policy_transfer.gait.limbs import Limb, limbs, responses
from morph.policy_transfer.gait.mover import Mover, mover
from morph.policy_transfer.gait.swimmers import swimmer


@dataclass(frozen=True, kw_only=True)
class Mirror(Operation):
    """A hinge mounted the other way round."""

    name: ClassVar[str] = "mirror"

    joint: str

    def apply(self, spec: Any) -> None:
        found = spec.joint(self.joint)
        found.axis = -np.asarray(found.axis)


def learned(body: Mover, seed: int = 0, each: int = 20) -> tuple[Limb, ...]:
    seen = body.transitions(each * len(body.action), np.random.default_rng(seed))
    return limbs(responses(seen, period=body.task.period))


def axes(robot: Robot) -> np.ndarray:
    """Return the axes of the driven hinges at rest, in the world, (servos, 3)."""
    model: Any = spec_of(robot).compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    return np.array([data.xaxis[model.joint(each.joint).id] for each in robot.actuators])


def test_yaw_hinges_of_a_snake_stand_in_a_row_and_pitch_hinges_rest() -> None:
    found = learned(swimmer("sea_snake"))
    senses = [each.sense for each in found]
    assert senses == [1.0, 0.0] * 4 + [1.0]
    # Five hinges in a row: each a sixth of the body behind the other.
    assert [each.place for each in found[::2]] == pytest.approx([k / 6 for k in range(1, 6)])


@pytest.mark.parametrize("flipped", ["yaw_2", "yaw_5"])
def test_a_hinge_mounted_the_other_way_round_is_found_out(flipped: str) -> None:
    robot = vary(load("sea_snake"), Mirror(joint=flipped))
    found = learned(mover(robot, seconds=4.0, wet=True))
    at = [each.joint for each in robot.actuators].index(flipped)
    others = {each.sense for number, each in enumerate(found) if number % 2 == 0 and number != at}
    assert others == {-found[at].sense}


def test_paddles_of_the_hexapod_have_the_sides_and_places_of_their_names() -> None:
    body = swimmer("hexapod_swimmer")
    found = learned(body)
    assert {each.sense for each in found} in ({1.0}, {-1.0})
    for actuator, limb in zip(body.robot.actuators, found, strict=True):
        side, place = actuator.name.split("_")
        assert limb.side == {"left": 0.0, "right": 1.0}[side]
        assert limb.place == {"front": 0.25, "middle": 0.5, "rear": 0.75}[place]


def test_senses_of_the_real_snake_are_the_signs_of_its_axes(real_robots: Path) -> None:
    body = swimmer(real_robots / "urma_sea_snake" / "sea_snake.xml")
    found = learned(body)
    across = axes(body.robot)
    chosen = np.array([each.sense != 0.0 for each in found])
    # Each hinge is turned a quarter about the body against the one before: half of them bend
    # it in one plane, and every second one of these the other way round.
    assert chosen.sum() == len(chosen) // 2
    plane = int(np.abs(across[chosen]).sum(axis=0).argmax())
    signs = np.sign(across[chosen, plane]) * np.array([each.sense for each in found])[chosen]
    assert set(signs.tolist()) in ({1.0}, {-1.0})
    places = [each.place for each in found if each.sense]
    assert np.corrcoef(places, np.arange(len(places)))[0, 1] > 0.95


def test_a_response_is_the_share_that_was_put_in() -> None:
    # Two servos; the trunk follows the first by 0.3 and the second by -0.2 of its lagged bell.
    period, slot, late = 0.02, 20, 0.1
    told = np.zeros((2 * slot, 2))
    bell = 0.5 * (1.0 - np.cos(2.0 * np.pi * np.arange(slot) / slot))
    twist = np.zeros((2 * slot, 12))
    for servo, share in enumerate((0.3, -0.2)):
        rows = slice(servo * slot, (servo + 1) * slot)
        told[rows, servo] = bell
        now, place = 0.0, np.zeros(slot)
        for at in range(slot):
            now += period / (late + period) * (bell[at] - now)
            place[at] = share * now
        twist[rows, 5] = np.diff(place, prepend=0.0) / period
    seen = Transitions(state=twist, command=told, after=twist, turns=np.zeros(12, dtype=bool))
    found = responses(seen, period=period)
    assert found.late == late
    assert found.trunk[:, 5] == pytest.approx([0.3, -0.2])


def test_too_few_transitions_are_refused() -> None:
    body = swimmer("swimmer_three_links")
    with pytest.raises(TransferError, match="9 transitions are too few for 2 servos"):
        body.transitions(9, np.random.default_rng(0))


def test_transitions_in_which_nothing_moves_the_trunk_are_refused() -> None:
    told = np.zeros((20, 2))
    told[1:10, 0] = told[11:, 1] = 0.1
    seen = Transitions(
        state=np.zeros((20, 12)), command=told, after=np.zeros((20, 12)), turns=np.zeros(12, bool)
    )
    with pytest.raises(TransferError, match="0 of 2 servos move the trunk across"):
        limbs(responses(seen, period=0.02))


def test_a_body_of_motors_is_refused() -> None:
    with pytest.raises(TransferError, match="front, rear of its actuators take efforts"):
        mover(load("swimmer_three_links"), seconds=1.0, wet=True)
