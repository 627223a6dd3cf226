from __future__ import annotations

from collections.abc import Callable

import pytest

from morph.body.robot import Robot
from morph.physics.actuator.voltage_sag import VoltageSag
from morph.sim.simulator import Simulator


@pytest.mark.parametrize("where", ["axle", "second"])
def test_every_motor_weakens_by_the_load_of_all(wheels: Callable[..., Robot], where: str) -> None:
    law = VoltageSag(actuator=where, k=0.5)
    run = Simulator(wheels(), (law,)).run(seconds=1.0, command={"axle": 0.4, "second": -0.8})
    # The gain is 1 / (1 + 0.5 * 1.2) = 0.625, for 1 s on 0.25 kg m2.
    assert run["axle.velocity"][-1] == pytest.approx(1.0, abs=1e-12)
    assert run["second.velocity"][-1] == pytest.approx(-2.0, abs=1e-12)
