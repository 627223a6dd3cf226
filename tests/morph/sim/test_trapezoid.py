"""Damping of second order in the step, against the closed form of a damped oscillator."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pytest
from scipy.linalg import expm

from morph.arrays import Array
from morph.physics.effect import Effect
from morph.physics.joint.series_elasticity import SeriesElasticity
from morph.sim.rollout import Variant, rollout
from morph.sim.trapezoid import MOST, trapezoidal

J, B, KP, KV, AIM = 0.2, 0.5, 20.0, 3.0, 0.4
"""Inertia, damping, stiffness and damping of a servo, and where it is sent."""
SECONDS = 0.4


def turntable(
    step: float, *, kv: float = KV, limited: str = "", effects: tuple[Effect, ...] = ()
) -> Variant:
    """Return a turntable on a servo; `limited` says whether the motor or the joint limits it."""
    force = 'forcerange="-99 99"' if limited == "motor" else ""
    effort = 'actuatorfrcrange="-99 99"' if limited == "joint" else ""
    model: Any = mujoco.MjModel.from_xml_string(
        f"""<mujoco>
          <option timestep="{step}" integrator="implicitfast" gravity="0 0 0"/>
          <worldbody><body>
            <joint name="hinge" axis="0 0 1" damping="{B}" armature="0.05" {effort}/>
            <inertial pos="0 0 0" mass="1" diaginertia="{J - 0.05} {J - 0.05} {J - 0.05}"/>
          </body></worldbody>
          <actuator>
            <general name="motor" joint="hinge" gear="2" gainprm="{KP / 2}" biastype="affine"
              biasprm="0 {-KP / 4} {-kv / 4}" {force}/>
          </actuator>
        </mujoco>"""
    )
    return Variant(model=model, effects=effects)


def exact(time: Array, start: Array) -> Array:
    """Return position and velocity of J a = KP (AIM - q) - (B + KV) v."""
    flow = np.array([[0.0, 1.0, 0.0], [-KP / J, -(B + KV) / J, KP * AIM / J], [0.0] * 3])
    return np.stack([expm(flow * t) @ np.append(start, 1.0) for t in time])[:, :2]


def error(step: float, *, second: bool) -> float:
    """Return the largest error of position along a run that starts in the middle of a motion."""
    steps = round(SECONDS / step)
    variant = turntable(step)
    variant = trapezoidal(variant) if second else variant
    time = step * np.arange(steps + 1)
    due = exact(time, np.array([-0.2, 1.0]))
    # A semi-implicit step's velocities are those of half a step before.
    before = exact(np.array([-0.5 * step]), np.array([-0.2, 1.0]))[0, 1]
    command = np.full((1, steps, 1), AIM)
    found, _ = rollout([variant], np.zeros(1, int), due[:1, :1], np.array([[before]]), command)
    return float(np.abs(found[0, :, 0] - due[:, 0]).max())


def test_damping_is_of_second_order() -> None:
    # Halving the step leaves a quarter of an error of second order, half of one of first order.
    assert error(0.004, second=True) / error(0.002, second=True) == pytest.approx(4.0, rel=0.05)
    assert error(0.004, second=False) / error(0.002, second=False) == pytest.approx(2.0, rel=0.1)
    assert error(0.002, second=True) < 0.1 * error(0.002, second=False)


def test_what_is_taken_is_half_a_step_of_damping() -> None:
    variant = turntable(0.004)
    found = trapezoidal(variant)
    # The servo's damping is that of the joint: gear squared is in it.
    assert found.model.dof_armature == pytest.approx([0.05 - 0.002 * (B + KV)], rel=1e-12)
    assert variant.model.dof_armature == pytest.approx([0.05], rel=1e-12)


def test_little_is_taken_of_a_light_joint() -> None:
    found = trapezoidal(turntable(0.004, kv=500.0))
    assert found.model.dof_armature == pytest.approx([0.05 - MOST * J], rel=1e-9)


@pytest.mark.parametrize("limited", ["motor", "joint"])
def test_limited_motors_keep_their_inertia(limited: str) -> None:
    found = trapezoidal(turntable(0.004, limited=limited))
    assert found.model.dof_armature == pytest.approx([0.05 - 0.002 * B], rel=1e-12)


def test_motors_on_springs_keep_their_inertia() -> None:
    sprung = trapezoidal(turntable(0.004, effects=(SeriesElasticity(joint="hinge", k=1e3),)))
    assert sprung.model.dof_armature == pytest.approx([0.05], rel=1e-12)
