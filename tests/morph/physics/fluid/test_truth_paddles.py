"""A light hull with paddles that stir ten times the water they displace, at coarse steps."""

from __future__ import annotations

import math
from collections.abc import Callable

import mujoco
import numpy as np
import pytest

from morph.arrays import Array
from morph.body.robot import Robot
from morph.physics.effect import Effect
from morph.physics.fluid.added_mass import AddedMass
from morph.physics.fluid.buoyancy import Buoyancy
from morph.physics.fluid.quadratic_drag import QuadraticDrag
from morph.sim.simulator import Simulator

HULL = """<worldbody>
  <body name="hull">
    <freejoint/>
    <inertial pos="0 0 0" mass="1" diaginertia="0.01 0.02 0.02"/>
    {paddles}
  </body>
</worldbody>
<actuator>{motors}</actuator>"""
PADDLE = """<body name="{name}" pos="{x} {y} 0">
  <joint name="{name}" axis="0 1 0" stiffness="0.15" damping="0.001"/>
  <inertial pos="-0.08 0 0" mass="0.024" diaginertia="5e-6 5e-5 5.5e-5"/>
</body>"""
PLACES = {"one": (0.2, 0.15), "two": (0.2, -0.15), "three": (-0.2, 0.15), "four": (-0.2, -0.15)}


def swimmer(written: Callable[[str], Robot]) -> Robot:
    """Return a hull of 1 kg with four paddles, each of 24 g."""
    paddles = [PADDLE.format(name=name, x=x, y=y) for name, (x, y) in PLACES.items()]
    motors = [f'<motor name="{name}" joint="{name}"/>' for name in PLACES]
    return written(HULL.format(paddles="".join(paddles), motors="".join(motors)))


def stirred(written: Callable[[str], Robot], integrator: str, step: float) -> tuple[Array, Array]:
    """Return where the hull is and how the paddles stand, every 10 ms of 4 s."""
    effects: list[Effect] = [
        Buoyancy(body="hull", volume=1e-3),
        QuadraticDrag(body="hull", x=2.0, y=9.0, z=9.0),
    ]
    for name in PLACES:
        # A plate of 16 by 5 cm: its water is 10 times what it displaces, all of it across.
        effects += [
            AddedMass(body=name, z=0.24, ry=0.24 * 0.16**2 / 12.0, cx=-0.08),
            Buoyancy(body=name, volume=2.4e-5, cx=-0.08),
            QuadraticDrag(body=name, z=4.5, ry=0.001, cx=-0.08),
        ]

    def beat(time: Array) -> Array:
        # As it is in the middle of the step over which it is held.
        return np.asarray(0.1 * np.sin(2.0 * math.pi * 1.5 * (time + 0.5 * step)))

    simulator = Simulator(swimmer(written), tuple(effects), step=step)
    simulator.model.opt.integrator = getattr(mujoco.mjtIntegrator, integrator)
    moved = simulator.trajectory(
        seconds=4.0,
        command=dict.fromkeys(PLACES, beat),
    )
    every = round(0.01 / step)
    return moved.position[::every, :3], moved.position[::every, 7:]


@pytest.mark.parametrize(
    ("integrator", "order", "most"), [("mjINT_IMPLICITFAST", 1, 0.15), ("mjINT_RK4", 2, 2e-4)]
)
def test_paddles_are_stable_at_five_milliseconds_and_true_to_their_order(
    written: Callable[[str], Robot], integrator: str, order: int, most: float
) -> None:
    sharp = stirred(written, integrator, 0.00025)
    coarse, fine = (stirred(written, integrator, step) for step in (0.005, 0.0025))
    # Strokes of more than 60 degrees, by which the hull moves as far as its paddles are apart.
    assert np.abs(sharp[1]).max() > 1.05
    assert np.abs(sharp[0]).max() > 0.4
    for at in (0, 1):
        # MuJoCo's implicit step is of the first order. Runge and Kutta's is of the fourth, but a
        # command that is held over a step only of the second. Half of the step shows which.
        size = float(np.abs(sharp[at]).max())
        far, near = (float(np.abs(run[at] - sharp[at]).max()) / size for run in (coarse, fine))
        assert far < most
        assert near == pytest.approx(far / 2.0**order, rel=0.2)
