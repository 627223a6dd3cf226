from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from morph.body.robot import Robot
from morph.physics.actuator.speed_torque_limit import SpeedTorqueLimit
from morph.physics.actuator.torque_saturation import TorqueSaturation
from morph.sim.simulator import Simulator

LAW = SpeedTorqueLimit(actuator="axle", tau0=0.8, v0=2.5)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_wheel_nears_its_speed_without_load_exponentially(
    wheels: Callable[..., Robot], way: float
) -> None:
    run = Simulator(wheels(), (LAW,), step=0.001).run(seconds=2.0, command={"axle": 5.0 * way})
    time = run.channel("axle.velocity").time
    rate = 0.8 / (0.25 * 2.5)
    # Explicit: each step multiplies what is missing by 1 - x in place of exp(-x), x = 1.28e-3:
    # x^2 / 2 a step, worst at 1 / x steps: x / 2 of 2.5 rad/s times 1 / e.
    due = 2.5 * (1.0 - np.exp(-rate * time))
    assert way * run["axle.velocity"] == pytest.approx(due, abs=0.5 * rate * 0.001 * 2.5)


def test_what_brakes_is_limited_by_the_stall_torque_alone(wheels: Callable[..., Robot]) -> None:
    run = Simulator(wheels(), (LAW,)).run(
        seconds=0.5, speed={"axle": -2.0, "second": 4.0}, command={"axle": 5.0, "second": 0.1}
    )
    # From -2 rad/s by 0.8 / 0.25 for 0.5 s: it never turns forwards. Roundoff of 250 sums.
    assert run["axle.velocity"][-1] == pytest.approx(-2.0 + 0.8 / 0.25 * 0.5, abs=1e-12)
    # Another motor is not limited.
    assert run["second.velocity"][-1] == pytest.approx(4.2, abs=1e-12)


def test_a_small_torque_is_not_touched(wheels: Callable[..., Robot]) -> None:
    run = Simulator(wheels(), (LAW,)).run(seconds=1.0, speed={"axle": 1.0}, command={"axle": 0.2})
    # At 1.8 rad/s the limit is 0.8 (1 - 1.8 / 2.5) = 0.224 N m still.
    assert run["axle.velocity"][-1] == pytest.approx(1.0 + 0.2 / 0.25, abs=1e-12)


def test_nothing_drives_beyond_the_speed_without_load(wheels: Callable[..., Robot]) -> None:
    run = Simulator(wheels(), (LAW,)).run(seconds=0.5, speed={"axle": 3.0}, command={"axle": 5.0})
    assert run["axle.velocity"] == pytest.approx(3.0, abs=1e-12)


def test_without_its_speed_it_is_a_limit_at_the_torque_at_stall() -> None:
    line = SpeedTorqueLimit(actuator="motor", tau0=0.9, v0=500.0)
    law = TorqueSaturation(actuator="motor", limit=3.0)
    assert line.simplified(law) == TorqueSaturation(actuator="motor", limit=0.9)
