from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from morph.arrays import Array
from morph.body.robot import Robot
from morph.physics.joint.armature import Armature
from morph.physics.joint.series_elasticity import SeriesElasticity
from morph.sim.simulator import Simulator

LINK, ROTOR, STEP = 0.25, 0.1, 0.0005


@pytest.mark.parametrize("described", [True, False])
def test_a_link_swings_against_its_rotor_while_both_speed_up(
    wheels: Callable[..., Robot], described: bool
) -> None:
    robot = wheels(f'armature="{ROTOR}"' if described else "")
    more = () if described else (Armature(joint="axle", J=ROTOR),)
    law = SeriesElasticity(joint="axle", k=40.0)
    run = Simulator(robot, (law, *more), step=STEP).run(
        seconds=1.0, command={"axle": lambda t: (t > 0.1 - 1e-9).astype(float)}
    )
    # Two inertias on a spring, the torque on one: the link's acceleration is
    # (1 - cos(w t)) / (I + J), w^2 = k (1 / I + 1 / J).
    w = np.sqrt(40.0 * (1.0 / LINK + 1.0 / ROTOR))
    since = np.maximum(run.channel("axle.velocity").time - 0.1, 0.0)
    due = (since - np.sin(w * since) / w) / (LINK + ROTOR)
    # Velocities lag by half a step of at most 2 / (I + J); the leapfrog gains (w h)^2 / 24 of the
    # phase, 6e-6 of 21 rad, of a swing of 1 / w / (I + J) = 0.12 rad/s.
    late = 0.5 * STEP * 2.0 / (LINK + ROTOR)
    assert np.abs(run["axle.velocity"] - due).max() < 1.05 * late + 2e-5
    # As one body it would be past this by the swing.
    assert np.abs(due - since / (LINK + ROTOR)).max() > 50.0 * late


def test_a_servo_closes_on_the_rotor(wheels: Callable[..., Robot]) -> None:
    servo = '<position name="axle" joint="axle" kp="30" kv="1.5"/>'
    robot = wheels(f'armature="{ROTOR}" damping="0.1"', servo)
    law = SeriesElasticity(joint="axle", k=25.0, d=0.2)
    run = Simulator(robot, (law,), step=STEP).run(seconds=1.5, command={"axle": 0.5})

    def rates(time: float, x: Array) -> list[float]:
        q, v, rotor, rate = x
        tau = 25.0 * (rotor - q) + 0.2 * (rate - v)
        motor = 30.0 * (0.5 - rotor) - 1.5 * rate
        return [v, (tau - 0.1 * v) / LINK, rate, (motor - tau) / ROTOR]

    time = run.channel("axle.position").time
    # It starts with the spring wound by what the servo gives to a rotor at rest:
    # 30 (0.5 - x) = 25 x.
    start = [0.0, 0.0, 15.0 / 55.0, 0.0]
    due = solve_ivp(rates, (0.0, 1.5), start, t_eval=time, rtol=1e-9, atol=1e-11).y
    # First order in the step: it damps by its speed afterwards, and velocities lag by half a
    # step: together about a step of the greatest speed, 2.3 rad/s.
    assert np.abs(run["axle.position"] - due[0]).max() < STEP * np.abs(due[1]).max()
    # With both as one body the path is another by a third of the way.
    rigid = Simulator(robot, step=STEP).run(seconds=1.5, command={"axle": 0.5})
    assert np.abs(rigid["axle.position"] - due[0]).max() > 0.15


def test_a_rotor_too_light_for_the_step_hands_its_torque_on(wheels: Callable[..., Robot]) -> None:
    law = SeriesElasticity(joint="axle", k=500.0, d=1.0)
    run = Simulator(wheels(), (law,)).run(seconds=1.0, command={"axle": 0.5})
    # Without a rotor's inertia the spring is wound at once: 0.5 N m from the first step on.
    time = run.channel("axle.velocity").time
    # Its stand-in, 500 * 0.002^2 / 2 = 1e-3 kg m2, is wound with the link at rest, and lags
    # once: by 1e-3 / 0.25 of the speed, at most.
    assert run["axle.velocity"] == pytest.approx(0.5 * time / LINK, abs=2.0 * 0.004)
