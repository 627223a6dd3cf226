"""Wet bodies that touch the ground: as stiff, and as slippery, as what they weigh in motion."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mujoco
import pytest

from morph.body.robot import Robot
from morph.physics.fluid.added_mass import AddedMass
from morph.sim.simulator import Simulator

Make = Callable[..., Any]
MASS, WATER = 2.0, 18.0
"""Of a light shell, and of the fluid that moves along with it, kg."""

SHELL = """<option gravity="0 0 {gravity}" integrator="implicitfast"/>
<worldbody>
  <geom name="floor" type="plane" size="5 5 0.1" friction="0.4"/>
  <body name="shell" pos="0 0 0.3">
    <freejoint/>
    <inertial pos="0 0 0" mass="{mass}" diaginertia="0.02 0.03 0.04"/>
    <geom type="{shape}" size="0.1 0.15 0.08"/>
  </body>
</worldbody>"""


@pytest.mark.parametrize("shape", ["sphere", "box", "ellipsoid"])
def test_a_shell_in_water_lands_as_a_heavier_one_does(
    written: Callable[[str], Robot], shape: str
) -> None:
    # Water that adds alike along every axis is mass without weight.
    light = 9.81 * MASS / (MASS + WATER)
    wet = Simulator(
        written(SHELL.format(mass=MASS, gravity=-9.81, shape=shape)),
        (AddedMass(body="shell", x=WATER, y=WATER, z=WATER),),
    )
    dry = Simulator(written(SHELL.format(mass=MASS + WATER, gravity=-light, shape=shape)))
    start = {"shell.linear_velocity.x": 0.4, "shell.angular_velocity.y": 1.0}
    runs = [each.trajectory(seconds=2.0, speed=start) for each in (wet, dry)]
    lowest = [float(run.position[:, 2].min()) for run in runs]
    assert lowest[0] < 0.2
    # Contacts are solved to 1e-8 of their scale, 20 kg: until it lies still, 1e-6 m.
    assert runs[0].position == pytest.approx(runs[1].position, abs=1e-6)
    assert runs[0].velocity == pytest.approx(runs[1].velocity, abs=1e-5)


def fallen(spec: Any, solver: str, cone: str) -> Any:
    """Return a spec whose bodies touch, over a floor, with limits on their hinges."""
    for body in spec.bodies[1:]:
        for geom in body.geoms:
            geom.contype = geom.conaffinity = 1
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_PLANE, size=(5.0, 5.0, 0.1), pos=(0.0, 0.0, -0.6)
    )
    for joint in spec.joints:
        if joint.type == mujoco.mjtJoint.mjJNT_HINGE:
            joint.range, joint.limited = (-0.3, 0.3), True
    spec.option.solver = getattr(mujoco.mjtSolver, solver)
    spec.option.cone = getattr(mujoco.mjtCone, cone)
    # Runge and Kutta's step knows nothing of bodies, as others do of single ones that spin.
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
    spec.option.tolerance, spec.option.iterations = 1e-14, 200
    return spec


@pytest.mark.parametrize("cone", ["mjCONE_PYRAMIDAL", "mjCONE_ELLIPTIC"])
@pytest.mark.parametrize("solver", ["mjSOL_NEWTON", "mjSOL_CG", "mjSOL_PGS"])
@pytest.mark.parametrize("roots", [1, 3])
def test_trees_in_water_fall_and_touch_as_heavier_ones_do(
    grown: Make, alike: Make, solver: str, cone: str, roots: int
) -> None:
    wet, dry = alike(fallen(grown(6, 1, roots=roots), solver, cone))
    dry.opt.solver = wet.opt.solver
    one, other = mujoco.MjData(wet), mujoco.MjData(dry)
    touched = 0
    for _ in range(300):
        # From the same state each time, as falls part at every edge that one misses.
        one.qpos[:], one.qvel[:] = other.qpos, other.qvel
        one.qacc_warmstart[:] = other.qacc_warmstart
        mujoco.mj_step(wet, one)
        mujoco.mj_step(dry, other)
        touched += other.ncon
        # Accelerations of 1e3 m/s2, solved to rounding, over 2 ms.
        assert one.qvel == pytest.approx(other.qvel, abs=1e-9)
    assert touched > 100
