"""Small moves of many states are those that MuJoCo makes of one."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from morph.body.load import load
from morph.body.spec import spec_of
from morph.sim.tangent import apart, moved_by


@pytest.mark.parametrize("name", ["humanoid", "cart_two_links"])
def test_moving_and_telling_apart_agree_with_mujoco_and_undo_each_other(name: str) -> None:
    model = spec_of(load(name)).compile()
    rng = np.random.default_rng(1)
    start = np.tile(model.qpos0, (20, 1))
    position = moved_by(model, start, rng.normal(size=(20, model.nv)))
    step = 0.7 * rng.normal(size=(20, model.nv))
    moved = moved_by(model, position, step)
    for row in range(20):
        expected, back = position[row].copy(), np.empty(model.nv)
        mujoco.mj_integratePos(model, expected, step[row], 1.0)
        assert moved[row] == pytest.approx(expected, abs=1e-12)
        mujoco.mj_differentiatePos(model, back, 1.0, position[row], moved[row])
        assert apart(model, moved[row], position[row]) == pytest.approx(back, abs=1e-9)
    assert apart(model, moved, position) == pytest.approx(step, abs=1e-9)


def test_no_move_at_all_is_told_as_none() -> None:
    model = spec_of(load("humanoid")).compile()
    assert not apart(model, model.qpos0, model.qpos0).any()
    assert moved_by(model, model.qpos0, np.zeros(model.nv)) == pytest.approx(model.qpos0)


def test_a_free_hinge_is_taken_the_shorter_way_round_and_a_slide_is_not() -> None:
    model = spec_of(load("cartpole")).compile()
    far = apart(model, np.array([7.0, 3.0]), np.array([0.0, -3.0]), wrapped=True)
    # From -3 to 3 rad the other way round: 6 - 2 pi.
    assert far == pytest.approx([7.0, 6.0 - 2.0 * np.pi])
