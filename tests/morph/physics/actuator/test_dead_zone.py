from __future__ import annotations

from collections.abc import Callable

import pytest

from morph.body.robot import Robot
from morph.physics.actuator.dead_zone import DeadZone
from morph.physics.actuator.speed_torque_limit import SpeedTorqueLimit
from morph.sim.simulator import Simulator


@pytest.mark.parametrize(
    ("told", "due"), [(0.1, 0.0), (-0.2, 0.0), (0.5, 0.3), (-0.5, -0.3), (0.0, 0.0)]
)
def test_what_is_below_the_threshold_is_lost(
    wheels: Callable[..., Robot], told: float, due: float
) -> None:
    law = DeadZone(actuator="axle", threshold=0.2)
    run = Simulator(wheels(), (law,)).run(
        seconds=1.0, command={"axle": told, "second": told}, speed={"axle": 0.1}
    )
    assert run["axle.velocity"][-1] == pytest.approx(0.1 + due / 0.25, abs=1e-12)
    assert run["second.velocity"][-1] == pytest.approx(told / 0.25, abs=1e-12)


def test_a_servo_does_nothing_on_small_errors(wheels: Callable[..., Robot]) -> None:
    servo = '<position name="axle" joint="axle" kp="4"/>'
    law = DeadZone(actuator="axle", threshold=0.2)
    run = Simulator(wheels(joint='damping="2"', actuator=servo), (law,), step=0.005).run(
        seconds=10.0, command={"axle": 1.0}
    )
    # It stops where 4 (1 - q) = 0.2. The slow root of 0.25 x^2 + 2 x + 4 is -4 / s: nothing is
    # left of exp(-40).
    assert run["axle.position"][-1] == pytest.approx(0.95, abs=1e-9)


def test_laws_of_one_motor_follow_one_another(wheels: Callable[..., Robot]) -> None:
    dead, limit = (
        DeadZone(actuator="axle", threshold=0.2),
        SpeedTorqueLimit(actuator="axle", tau0=0.5, v0=1e4),
    )
    for effects, due in (((dead, limit), 0.5), ((limit, dead), 0.3)):
        run = Simulator(wheels(), effects).run(seconds=1.0, command={"axle": 2.0})
        # Of 2 N m 1.8 are left and then 0.5, or 0.5 and then 0.3. Its line falls by 2 / 1e4.
        assert run["axle.velocity"][-1] == pytest.approx(due / 0.25, rel=1e-4)
