"""Wet bodies that touch the ground: as stiff, and as slippery, as what they weigh in motion."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from morph.body.robot import Robot
from morph.physics.fluid.added_mass import AddedMass
from morph.sim.simulator import Simulator

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
