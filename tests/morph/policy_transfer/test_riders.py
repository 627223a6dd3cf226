"""Humanoids on skateboards: how they are put there, where they rest, and how hard the push is."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from morph.body.load import load
from morph.body.spec import spec_of
from morph.errors import RobotError, TransferError
from morph.policy_transfer.body import Body, linear_law, still_law
from morph.policy_transfer.mapped.belief import read
from morph.policy_transfer.mapped.feedback import plain
from morph.policy_transfer.riders import rider, riding
from morph.policy_transfer.skateboard_bodies import on_board, servo_for

FEET = ("left_foot", "right_foot")


@pytest.fixture(scope="module")
def free() -> Body:
    return rider("humanoid_free")


@pytest.fixture(scope="module")
def passive() -> Body:
    return rider("humanoid_passive")


def test_a_humanoid_on_a_board_weighs_as_much_as_both() -> None:
    alone, both = load("humanoid"), load("humanoid_skateboard")
    found = on_board(alone, FEET, board="free")
    # The shelf's own pair is the same humanoid on the same board, described as one.
    assert found.mass == pytest.approx(both.mass, abs=1e-9)
    assert {joint.name for joint in found.joints} == {joint.name for joint in both.joints}


@pytest.mark.parametrize("board", ["driven", "passive"])
def test_on_a_rail_only_the_driven_board_has_a_motor(board: str) -> None:
    found = on_board(load("humanoid"), FEET, board=board)  # type: ignore[arg-type]
    kinds = [actuator.kind for actuator in found.actuators]
    assert kinds.count("motor") == (1 if board == "driven" else 0)
    assert kinds.count("position") == 25
    assert len(found.loops) == 2


def test_soles_stand_flat_on_the_deck() -> None:
    found = on_board(load("humanoid"), FEET, board="free")
    model = spec_of(found).compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    deck = model.geom("deck").id
    top = data.geom_xpos[deck][2] + model.geom_size[deck][2]
    for foot in FEET:
        sole = model.geom(f"{foot}_sole").id
        upright = data.geom_xmat[sole].reshape(3, 3)[:, 2]
        assert np.abs(upright) == pytest.approx([0.0, 0.0, 1.0], abs=1e-9)
        # They are sunk in by GAP, 0.1 mm.
        low = data.geom_xpos[sole][2] - model.geom_size[sole][2]
        assert low == pytest.approx(top - 1e-4, abs=1e-9)


def test_a_free_rider_rests_where_nothing_moves(free: Body) -> None:
    x = np.zeros((1, 2 * free.plant.model.nv))
    after = free.step(x, np.zeros((1, len(free.bounds[0]))))
    # It was let settle until it crept by less than 2 mm/s: 0.04 mm a period of 20 ms. Its wheels,
    # of 26 mm, turn by more.
    assert np.abs(after[0, 13 : free.plant.model.nv]).max() < 1e-4


def test_the_groups_are_ankles_knees_hips_waist_and_chest(free: Body) -> None:
    assert free.together is not None
    names = [actuator.name for actuator in free.task.robot.actuators]
    groups = [{names[at] for at in np.flatnonzero(each)} for each in free.together.T]
    assert groups == [
        {"l_ankle_y", "r_ankle_y"}, {"l_knee_y", "r_knee_y"}, {"l_hip_y", "r_hip_y"},
        {"abs_y"}, {"bust_y"},
    ]  # fmt: skip


@pytest.mark.parametrize("name", ["free", "passive"])
def test_holding_still_falls_under_the_push_and_feedback_stands(
    name: str, request: pytest.FixtureRequest
) -> None:
    body: Body = request.getfixturevalue(name)
    oracle = linear_law(plain(read(body), body))
    assert body.score(still_law(len(body.bounds[0])), rows=1) <= 0.3
    assert body.score(oracle, rows=1) >= 0.95


def test_the_true_model_sees_groups_as_the_simulation_answers_them(passive: Body) -> None:
    # One group told 1e-4 rad: welded feet leave the answer linear.
    k = len(passive.bounds[0])
    told = np.concatenate([1e-4 * np.eye(k), -1e-4 * np.eye(k)])
    x = np.zeros((2 * k, 2 * passive.plant.model.nv))
    after = passive.seen(passive.step(x, told))
    slope = (after[:k] - after[k:]).T / 2e-4
    # Differences of 1e-6 and 1e-4 agree to the contact solver's tolerance.
    assert slope == pytest.approx(read(passive)[:, passive.size :], abs=1e-3)


def test_servos_are_told_by_their_torque() -> None:
    assert [servo_for(effort).name for effort in (3.1, 7.3, 1.6)] == ["MX-28", "MX-64", "AX-12"]


def test_a_body_that_does_not_float_is_refused() -> None:
    with pytest.raises(RobotError, match=r"0 free joints"):
        on_board(load("cartpole"), ("cart", "cart"), board="free")


def test_an_unknown_rider_is_refused() -> None:
    with pytest.raises(TransferError, match=r"humanoid_driven, humanoid_passive"):
        rider("humanoid_flying")


def test_the_real_poppy_stands_free_on_the_board(real_robots: Path) -> None:
    folder = real_robots / "poppy_humanoid"
    if not folder.is_dir():
        pytest.skip("the real Poppy Humanoid is not there")
    poppy = load(folder / "robots" / "Poppy_Humanoid.URDF", base="floating", folder=folder)
    body = riding(poppy, ("l_foot", "r_foot"), "free")
    assert body.together is not None
    names = [actuator.name for actuator in body.task.robot.actuators]
    ankles = body.together[:, 0]
    # Its ankles turn about opposite axes: forward is 1 for one and -1 for the other.
    assert ankles[names.index("l_ankle_y")] == -ankles[names.index("r_ankle_y")]
    oracle = linear_law(plain(read(body), body))
    assert body.score(oracle, rows=1) >= 0.95
    still = replace(body)
    assert still.score(still_law(len(body.bounds[0])), rows=1) <= 0.3
