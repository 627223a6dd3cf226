from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from morph.body.robot import Robot
from morph.physics.actuator.back_emf import BackEmf
from morph.sim.simulator import Simulator

LAW = BackEmf(actuator="axle", k=0.5)


def test_a_powered_motor_nears_the_speed_at_which_it_induces_its_voltage(
    wheels: Callable[..., Robot],
) -> None:
    run = Simulator(wheels(), (LAW,), step=0.001).run(
        seconds=2.0, speed={"axle": -1.0}, command={"axle": 0.4}
    )
    time = run.channel("axle.velocity").time
    due = 0.8 - 1.8 * np.exp(-0.5 / 0.25 * time)
    # Explicit: x / 2 of 1.8 rad/s times 1 / e, with x = h k / I = 0.002.
    assert run["axle.velocity"] == pytest.approx(due, abs=0.5 * 0.002 * 1.8)


def test_a_motor_without_a_command_turns_freely(wheels: Callable[..., Robot]) -> None:
    time = 0.002 * np.arange(500)
    told = np.where(time < 0.4, 1e-9, 0.0)
    run = Simulator(wheels(), (LAW,)).run(
        seconds=1.0, speed={"axle": 2.0}, command={"axle": lambda _: told}
    )
    # A command of next to nothing powers it for 0.4 s: exp(-0.8), to x / 2 of it, twice; then
    # nothing changes its speed.
    speed = run["axle.velocity"]
    assert speed[200] == pytest.approx(2.0 * np.exp(-0.8), rel=0.004)
    assert np.array_equal(speed[200:], np.full(301, speed[200]))
