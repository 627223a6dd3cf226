from __future__ import annotations

from collections.abc import Callable

import pytest

from morph.body.robot import Robot
from morph.physics.actuator.torque_saturation import TorqueSaturation
from morph.sim.simulator import Simulator


def motor(more: str) -> str:
    return f'<motor name="axle" joint="axle" {more}/>'


@pytest.mark.parametrize(
    ("more", "told", "due"),
    [
        ("", 2.0, 0.5),
        ("", -2.0, -0.5),
        ("", 0.3, 0.3),
        # Behind a gear: 3 times 0.1 is below the limit, 3 times 0.4 is above it.
        ('gear="3"', 0.1, 0.3),
        ('gear="-3"', 0.4, -0.5),
        # A closer limit of the description stays, on its side.
        ('forcerange="-0.2 9"', -2.0, -0.2),
        ('forcerange="-0.2 9"', 2.0, 0.5),
        ('gear="2" forcelimited="false" forcerange="-0.1 0.1"', 2.0, 0.5),
    ],
)
def test_no_more_than_the_limit_reaches_the_joint(
    wheels: Callable[..., Robot], more: str, told: float, due: float
) -> None:
    law = TorqueSaturation(actuator="axle", limit=0.5)
    run = Simulator(wheels(actuator=motor(more)), (law,)).run(
        seconds=1.0, command={"axle": told, "second": told}
    )
    # A constant torque for 1 s on 0.25 kg m2: roundoff of 500 sums.
    assert run["axle.velocity"][-1] == pytest.approx(due / 0.25, abs=1e-12)
    assert run["second.velocity"][-1] == pytest.approx(told / 0.25, abs=1e-12)
