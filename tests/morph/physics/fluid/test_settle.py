"""Softness as MuJoCo would have made it, had it known the fluid."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np
import pytest

from morph.errors import EffectError
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
def test_wet_weights_are_those_of_heavier_dry_bodies(
    grown: Make, alike: Make, bodies: int, seed: int
) -> None:
    wet, dry = alike(strung(grown(bodies, seed)))
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


def test_ways_of_solving_that_know_no_fluid_are_replaced(grown: Make) -> None:
    spec = grown(3, 0)
    spec.option.solver = mujoco.mjtSolver.mjSOL_PGS
    flags = mujoco.mjtEnableBit
    spec.option.enableflags |= int(flags.mjENBL_DIAGEXACT | flags.mjENBL_ENERGY)
    model = settle(spec.compile())
    assert model.opt.solver == mujoco.mjtSolver.mjSOL_NEWTON
    assert model.opt.enableflags == flags.mjENBL_ENERGY
    spec.option.solver = mujoco.mjtSolver.mjSOL_CG
    assert settle(spec.compile()).opt.solver == mujoco.mjtSolver.mjSOL_CG


def test_a_tree_that_may_sleep_does_not_grow_heavier(grown: Make) -> None:
    spec = grown(6, 1, ideal=True, roots=2)
    spec.option.gravity = (0.0, 0.0, 0.0)
    spec.option.enableflags |= int(mujoco.mjtEnableBit.mjENBL_SLEEP)
    model = settle(spec.compile())
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    inertia = data.M.copy()
    mujoco.mj_step(model, data, 100)
    # At rest nothing turns but by rounding.
    assert pytest.approx(inertia, abs=1e-12) == data.M


def test_noslip_in_water_is_refused(grown: Make) -> None:
    spec = grown(3, 0)
    spec.option.noslip_iterations = 3
    with pytest.raises(EffectError, match="noslip_iterations is 3, and noslip knows no fluid"):
        settle(spec.compile())


def test_water_without_passive_forces_is_refused(grown: Make) -> None:
    spec = grown(3, 0)
    flags = mujoco.mjtDisableBit
    spec.option.disableflags |= int(flags.mjDSBL_SPRING | flags.mjDSBL_DAMPER)
    with pytest.raises(EffectError, match="springs and dampers are both disabled"):
        settle(spec.compile())


def test_the_compiled_fluid_runs_in_batches(grown: Make) -> None:
    assert batches(grown(2, 0).compile())
