"""Softness as MuJoCo would have made it, had it known the fluid."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np
import pytest

from morph.physics.fluid import numbers as at
from morph.physics.fluid.settle import batches, settle

Make = Callable[..., Any]
WEIGHTS = ("body_invweight0", "dof_invweight0", "tendon_invweight0")


def strung(spec: Any) -> Any:
    """Return a spec with tendons: one through two bodies, one along two joints."""
    string = spec.add_tendon(name="string")
    for name in ("b1", "b3"):
        spec.body(name).add_site(name=f"eye_{name}", pos=(0.05, 0.02, -0.03))
        string.wrap_site(f"eye_{name}")
    along = spec.add_tendon(name="along")
    hinges = [j for j in spec.joints if j.type == mujoco.mjtJoint.mjJNT_HINGE][:2]
    for index, joint in enumerate(hinges):
        joint.name = f"hinge{index}"
        along.wrap_joint(joint.name, 1.0 - 3.0 * index)
    return spec


def spatial(model: Any, body: int) -> Any:
    """Return the rigid inertia of a body about its origin, in its axes, linear first, (6, 6)."""
    turned = np.zeros(9)
    mujoco.mju_quat2Mat(turned, model.body_iquat[body])
    axes, mass = turned.reshape(3, 3), model.body_mass[body]
    lever = np.cross(np.eye(3), model.body_ipos[body])  # lever @ v = com x v
    whole = np.zeros((6, 6))
    whole[:3, :3] = mass * np.eye(3)
    whole[3:, :3] = mass * lever
    whole[:3, 3:] = mass * lever.T
    whole[3:, 3:] = axes @ np.diag(model.body_inertia[body]) @ axes.T + mass * lever @ lever.T
    return whole


@pytest.mark.parametrize(("bodies", "seed"), [(4, 1), (9, 2), (20, 3)])
@pytest.mark.parametrize("scale", [0.0, 1e-300])
def test_without_water_the_weights_are_mujocos_own(
    grown: Make, bodies: int, seed: int, scale: float
) -> None:
    # A scale of 1e-300 makes every body wet, and adds nothing.
    spec = strung(grown(bodies, seed))
    model = spec.compile()
    model.body_user[1:, at.SCALE] = scale
    before = {name: getattr(model, name).copy() for name in WEIGHTS}
    assert all(value.any() for value in before.values())
    settle(model)
    for name, value in before.items():
        # Two ways of solving with one matrix: rounding times its condition, some 1e3.
        assert getattr(model, name) == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(("bodies", "seed"), [(4, 1), (9, 2), (20, 3)])
def test_wet_weights_are_those_of_heavier_dry_bodies(grown: Make, bodies: int, seed: int) -> None:
    # Water whose tensor is 3 times a body's own inertia makes that body 4 times as heavy.
    spec = strung(grown(bodies, seed))
    dry = spec.compile()
    for body in range(1, dry.nbody):
        numbers = np.zeros(at.WIDTH)
        numbers[at.MARK], numbers[at.SCALE] = at.SIGNATURE, 1.0
        numbers[at.ADDED] = 3.0 * spatial(dry, body)[np.triu_indices(6)]
        at.write_numbers(spec, dry.body(body).name, numbers.tolist())
    wet = settle(spec.compile())
    dry.body_user[:] = 0.0
    dry.body_mass[:] *= 4.0
    dry.body_inertia[:] *= 4.0
    mujoco.mj_setConst(dry, mujoco.MjData(dry))
    for name in WEIGHTS:
        assert getattr(wet, name) == pytest.approx(getattr(dry, name), rel=1e-11)


def test_a_dry_model_is_left_alone(grown: Make) -> None:
    model = grown(4, 1).compile()
    model.body_user[:, at.MARK] = 0.0
    model.body_invweight0[:] = 7.0
    assert settle(model) is model
    assert (model.body_invweight0 == 7.0).all()


def test_settling_twice_is_settling_once(grown: Make) -> None:
    model = settle(grown(9, 2).compile())
    before = model.body_invweight0.copy()
    assert np.array_equal(settle(model).body_invweight0, before)


def test_the_compiled_fluid_runs_in_batches(grown: Make) -> None:
    assert batches(grown(2, 0).compile())
