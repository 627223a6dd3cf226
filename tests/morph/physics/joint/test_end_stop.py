from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from morph.arrays import Array
from morph.body.robot import Robot
from morph.physics.joint.end_stop import EndStop
from morph.sim.simulator import Simulator

STEP = 0.0005


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_wheel_bounces_off_a_spring_as_fast_as_it_came(
    wheels: Callable[..., Robot], side: float
) -> None:
    law = EndStop(joint="axle", q_stop=0.3 * side, side=side, k=400.0)
    run = Simulator(wheels(), (law,), step=STEP).run(seconds=0.4, speed={"axle": 2.0 * side})
    time, q = run.channel("axle.position").time, side * run["axle.position"]
    # It comes after 0.15 s, swings half a period, pi / 40 s, 2 / 40 rad deep, and goes.
    touch, gone = 0.15, 0.15 + np.pi / 40.0
    due = np.where(time < touch, 2.0 * time, 0.3 + 2.0 / 40.0 * np.sin(40.0 * (time - touch)))
    due = np.where(time > gone, 0.3 - 2.0 * (time - gone), due)
    # The stop is met up to a step late at either end, and half a step of velocity: 2 rad/s.
    assert np.abs(q - due).max() < 2.5 * STEP * 2.0
    # A leapfrog's spring keeps the energy: a step past the edge takes k h v^2 h of 0.5 J.
    assert np.abs(run["axle.velocity"][-1]) == pytest.approx(2.0, abs=0.02)


def test_a_damped_stop_takes_energy_and_never_pulls(wheels: Callable[..., Robot]) -> None:
    law = EndStop(joint="axle", q_stop=0.3, k=400.0, d=8.0)
    run = Simulator(wheels(), (law,), step=STEP).run(seconds=0.4, speed={"axle": 2.0})

    def rates(time: float, x: Array) -> list[float]:
        return [x[1], -(400.0 * x[0] + 8.0 * x[1]) / 0.25]

    def push(time: float, x: Array) -> float:
        return float(400.0 * x[0] + 8.0 * x[1])

    push.terminal, push.direction = True, -1.0  # type: ignore[attr-defined]
    # Where the damper's pull would outweigh the spring's push, it goes as fast as it is then.
    left = solve_ivp(rates, (0.0, 0.2), [0.0, 2.0], events=push, rtol=1e-10, atol=1e-12).y[1, -1]
    velocity = run["axle.velocity"]
    # A step at the edge is d v / I h = 8 * 2 / 0.25 * 0.5 ms, at both ends.
    assert velocity[-1] == pytest.approx(left, abs=2.0 * 8.0 * 2.0 / 0.25 * STEP)
    assert -1.5 < left < -0.5
    assert np.all(np.diff(velocity) < 1e-12)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_refit_begins_anew_where_the_stop_pushes_as_much(side: float) -> None:
    law = EndStop(joint="axle", q_stop=0.3 * side, side=side, k=400.0, d=8.0)
    shallow, deep = (
        SimpleNamespace(place=lambda joint, most=most: side * np.array([-0.9, 0.0, most]))
        for most in (0.1, 0.5)
    )
    others = law.restarts([shallow, deep])  # type: ignore[list-item]
    assert [side * other.q_stop for other in others] == pytest.approx([0.48, 0.44, -0.1])
    # 0.2 rad into it: 80 N m.
    pushes = [other.k * (0.5 - side * other.q_stop) for other in others]
    assert pushes == pytest.approx([80.0] * 3)
    # Of one that is not reached nothing is known.
    assert law.restarts([shallow]) == ()  # type: ignore[list-item]
