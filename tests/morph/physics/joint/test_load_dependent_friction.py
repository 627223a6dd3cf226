from __future__ import annotations

from collections.abc import Callable

import pytest

from morph.body.robot import Robot
from morph.physics.actuator.dead_zone import DeadZone
from morph.physics.joint.load_dependent_friction import LoadDependentFriction
from morph.sim.simulator import Simulator

LAW = LoadDependentFriction(joint="axle", c0=0.1, k=0.2)


@pytest.mark.parametrize("told", [1.0, -2.0])
def test_friction_takes_its_share_of_what_the_motor_gives(
    wheels: Callable[..., Robot], told: float
) -> None:
    run = Simulator(wheels(), (LAW,), step=0.001).run(seconds=1.0, command={"axle": told})
    # (u - (0.1 + 0.2 u)) / 0.25 for 1 s. MuJoCo's friction is softer by a ten-thousandth of
    # its impedance: 1e-4 of 0.5 N m / 0.25 kg m2, twice.
    due = (abs(told) - 0.1 - 0.2 * abs(told)) / 0.25
    assert run["axle.velocity"][-1] == pytest.approx(due if told > 0.0 else -due, abs=4e-4)


# It breaks away where u = 0.1 + 0.2 u: at 0.125 N m.
@pytest.mark.parametrize(("told", "holds"), [(0.12, True), (0.13, False), (-0.12, True)])
def test_friction_holds_up_to_what_the_load_allows(
    wheels: Callable[..., Robot], told: float, holds: bool
) -> None:
    run = Simulator(wheels(), (LAW,)).run(seconds=1.0, command={"axle": told})
    # A held joint creeps at 0.12 / 0.25 * 1e-4 * 0.004 = 2e-7 rad/s; a free one comes 0.004 / 0.25
    # / 2 = 8 mrad far.
    assert (abs(run["axle.position"][-1]) < 1e-6) == holds


def test_the_load_is_what_other_laws_leave_of_the_torque(wheels: Callable[..., Robot]) -> None:
    # Of 1 N m a dead zone leaves 0.6; of that friction takes 0.1 + 0.12: 0.38 / 0.25 rad/s2.
    both = (LAW, DeadZone(actuator="axle", threshold=0.4))
    for effects in (both, both[::-1]):
        run = Simulator(wheels(), effects, step=0.001).run(seconds=1.0, command={"axle": 1.0})
        assert run["axle.velocity"][-1] == pytest.approx(1.52, abs=4e-4)
