from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from morph.body.robot import Robot
from morph.physics.actuator.thermal_derating import ThermalDerating
from morph.sim.simulator import Simulator


@pytest.mark.parametrize("told", [0.6, -0.3])
def test_a_motor_under_constant_load_weakens_towards_its_floor(
    wheels: Callable[..., Robot], told: float
) -> None:
    law = ThermalDerating(actuator="axle", floor=0.4, rate=2.0, level=0.6)
    run = Simulator(wheels(), (law,), step=0.001).run(
        seconds=2.5, command={"axle": told, "second": told}
    )
    time = run.channel("axle.velocity").time
    # Heat is 1 - exp(-t rate (u / level)^2): the impulse is that of a gain 1 - 0.6 of it.
    heating = 2.0 * (told / 0.6) ** 2
    impulse = time - 0.6 * (time + np.expm1(-heating * time) / heating)
    # The gain is that of the start of each step: half a step of 0.6 of 2.4 rad/s2, 7.2e-4.
    assert run["axle.velocity"] == pytest.approx(told / 0.25 * impulse, abs=7.3e-4)
    assert run["second.velocity"] == pytest.approx(told / 0.25 * time, abs=1e-11)
