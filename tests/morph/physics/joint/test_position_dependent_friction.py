from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from morph.body.robot import Robot
from morph.physics.joint.position_dependent_friction import PositionDependentFriction
from morph.sim.simulator import Simulator

LAW = PositionDependentFriction(joint="axle", c=0.2, a=0.15, n=3.0, phase=0.7)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_what_a_wheel_loses_is_the_level_along_its_path(
    wheels: Callable[..., Robot], way: float
) -> None:
    run = Simulator(wheels(), (LAW,), step=0.001).run(seconds=1.0, speed={"axle": 2.0 * way})
    q, v = run["axle.position"], run["axle.velocity"]
    # Work: c q - a / n (cos(n q + phase) - cos(phase)), against the motion either way.
    path = 0.2 * q - 0.05 * (np.cos(3.0 * q + 0.7) - np.cos(0.7))
    due = 0.5 * 0.25 * 4.0 - way * path
    # Velocities lag half a step behind positions: 0.25 * 2 rad/s * 0.35 N m / 0.25 kg m2 * 0.5 ms
    # = 3.5e-4 J, and MuJoCo's friction is softer by 1e-4 of what it takes, 0.3 J.
    assert 0.5 * 0.25 * v**2 == pytest.approx(due, abs=4e-4)
    assert due.min() < 0.25


# At q = pi / 3 the wave sin(3 q + 0.7) = -0.644: 0.103 N m; at q = 0 it is 0.644: 0.297 N m.
@pytest.mark.parametrize(
    ("start", "told", "holds"),
    [(0.0, 0.29, True), (0.0, 0.31, False), (np.pi / 3, 0.1, True), (np.pi / 3, 0.11, False)],
)
def test_friction_holds_by_its_level_at_rest(
    wheels: Callable[..., Robot], start: float, told: float, holds: bool
) -> None:
    run = Simulator(wheels(), (LAW,)).run(
        seconds=0.5, start={"axle": start}, command={"axle": told}
    )
    # A held joint creeps at 0.3 / 0.25 * 1e-4 * 0.004 = 5e-7 rad/s; one that is not held comes
    # 0.007 N m / 0.25 kg m2 / 8 = 3 mrad far.
    assert (abs(run["axle.position"][-1] - start) < 1e-6) == holds
