from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from morph.body.robot import Robot
from morph.physics.joint.cogging import Cogging
from morph.sim.simulator import Simulator


def test_a_cogging_wheel_swings_about_the_place_where_its_magnets_rest(
    wheels: Callable[..., Robot],
) -> None:
    law = Cogging(joint="axle", a=0.5, n=8.0, phase=0.6)
    # a sin(n q + phase) draws back where n q + phase = pi, with a stiffness of a n = 4 N m/rad.
    rest, step = (np.pi - 0.6) / 8.0, 0.001
    run = Simulator(wheels(), (law,), step=step).run(seconds=2.0, start={"axle": rest + 1e-3})
    time = run.channel("axle.position").time
    due = rest + 1e-3 * np.cos(4.0 * time)
    # A leapfrog gains (w h)^2 / 24 of the phase, 5e-6 of 8 rad. MuJoCo starts with the velocity
    # of half a step before: 0.5 ms * 4 / s of 1e-3 rad. (n x)^2 / 6 of the torque is 1e-5.
    assert run["axle.position"] == pytest.approx(due, abs=2.1e-6)


def test_cogging_gives_back_what_it_takes(wheels: Callable[..., Robot]) -> None:
    law = Cogging(joint="axle", a=0.5, n=8.0, phase=-2.0)
    run = Simulator(wheels(), (law,), step=0.001).run(seconds=2.0, speed={"axle": 2.0})
    q, v = run["axle.position"], run["axle.velocity"]
    # tau = -dV/dq with V = a / n cos(n q + phase), forwards and backwards alike.
    speed = 0.5 * (v[1:] + v[:-1])
    energy = 0.5 * 0.25 * speed**2 + 0.5 / 8.0 * np.cos(8.0 * q[:-1] - 2.0)
    # h^2 (v^2 V'' / 12 - V'^2 / 24 I) of a leapfrog, with V' = 0.5, V'' = 4, v = 2.2 rad/s:
    # 1e-6 * (1.6 + 0.04) J, up and down. V itself is 0.0625 J.
    assert np.ptp(energy) < 3.3e-6
