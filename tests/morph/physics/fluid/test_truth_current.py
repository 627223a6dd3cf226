"""A current is still water seen from a frame that moves."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np
import pytest

from morph.arrays import Array
from morph.physics.fluid.numbers import CURRENT, SCALE

Make = Callable[..., Any]
STREAM = np.array([0.7, -0.4, 0.2])


def swum(model: Any, start: Array, speed: Array, seconds: float) -> Any:
    """Return data of a tree that swam by forces on its joints, not on its root."""
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = start, speed
    for step in range(round(seconds / model.opt.timestep)):
        data.qfrc_applied[6:] = 0.2 * np.sin(0.1 * step + np.arange(model.nv - 6))
        mujoco.mj_step(model, data)
    return data


@pytest.mark.parametrize("integrator", ["mjINT_RK4", "mjINT_IMPLICITFAST"])
@pytest.mark.parametrize(("bodies", "seed"), [(1, 0), (4, 1), (12, 2)])
def test_swimming_in_a_current_is_swimming_in_still_water_that_is_carried_along(
    grown: Make, moving: Make, integrator: str, bodies: int, seed: int
) -> None:
    spec = grown(bodies, seed)
    spec.option.integrator = getattr(mujoco.mjtIntegrator, integrator)
    model = spec.compile()
    model.body_user[1:, SCALE] = 1.0
    first = moving(model, seed, 0.3)
    ends = []
    for carried in (np.zeros(3), STREAM):
        model.body_user[1:, CURRENT] = carried
        speed = first.qvel.copy()
        speed[:3] += carried
        ends.append(swum(model, first.qpos, speed, 1.0))
    still, taken = ends
    # The step is linear in a carried frame, too: rounding of 500 steps, amplified by drag's
    # kinks, is 1e-13 or so.
    assert taken.qpos[:3] - still.qpos[:3] == pytest.approx(STREAM, abs=1e-10)
    assert taken.qpos[3:] == pytest.approx(still.qpos[3:], abs=1e-10)
    assert taken.qvel[:3] - still.qvel[:3] == pytest.approx(STREAM, abs=1e-10)
    assert taken.qvel[3:] == pytest.approx(still.qvel[3:], abs=1e-10)


def test_a_tree_that_drifts_with_the_current_feels_nothing(grown: Make, moving: Make) -> None:
    spec = grown(8, 3)
    spec.option.gravity = (0.0, 0.0, 0.0)
    model = spec.compile()
    model.body_user[1:, SCALE] = 1.0
    model.body_user[1:, CURRENT] = STREAM
    data = moving(model, 3, 0.0)
    data.qvel[:3] = STREAM
    mujoco.mj_forward(model, data)
    # Differences of speeds near 1 times coefficients near 10.
    assert data.qfrc_passive == pytest.approx(np.zeros(model.nv), abs=1e-13)
    assert data.qacc == pytest.approx(np.zeros(model.nv), abs=1e-12)
