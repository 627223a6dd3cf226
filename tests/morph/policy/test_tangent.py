"""The difference of two states, from what is seen of them."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from morph.body.load import load
from morph.errors import PolicyError
from morph.policy.linear import Linear
from morph.policy.observing import Observer, observations_of
from morph.policy.policy import actions_of
from morph.policy.tangent import tangent
from morph.sim.simulator import Simulator


@pytest.mark.parametrize("name", ["cartpole", "hexapod_swimmer", "humanoid_skateboard"])
def test_it_is_mujocos_difference_of_positions_to_first_order(name: str) -> None:
    robot = load(name)
    model, rng = Simulator(robot).model, np.random.default_rng(0)
    there = model.qpos0.copy()
    mujoco.mj_integratePos(model, there, rng.normal(size=model.nv), 1.0)
    here, away = there.copy(), 1e-4 * rng.normal(size=model.nv)
    mujoco.mj_integratePos(model, here, away, 1.0)
    speed = rng.normal(size=model.nv)
    some = tuple(replace(each, offset=0.2, scale=3.0) for each in observations_of(robot))
    some = (*some[:2], replace(some[2], history=2), *some[3:])
    size = sum(each.history for each in some)
    action = actions_of(robot)
    policy = Linear(
        weight=np.zeros((len(action), size)),
        bias=np.zeros(len(action)),
        action=action,
        observation=some,
    )
    seen = Observer(policy, robot, model, 2).see(
        np.stack([there, here]), np.stack([np.zeros(model.nv), speed])
    )
    found = tangent(robot, model, there, some) @ (seen[1] - seen[0])
    # The rotation's second order: its cube, 1e-12; sines of 1e-4 leave 1e-12 too.
    assert found == pytest.approx(np.concatenate([away, speed]), abs=1e-11)


def test_a_state_that_is_not_wholly_seen_is_refused() -> None:
    robot = load("cartpole")
    some = observations_of(robot, ("slide.position", "hinge.position", "hinge.velocity"))
    with pytest.raises(PolicyError, match=r"does not see slide\.velocity"):
        tangent(robot, Simulator(robot).model, np.zeros(2), some)
