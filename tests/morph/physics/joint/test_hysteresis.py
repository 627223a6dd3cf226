from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from morph.arrays import Array
from morph.body.robot import Robot
from morph.physics.joint.hysteresis import Hysteresis, followed
from morph.sim.simulator import Simulator

C, Z = 0.6, 0.08


def law(time: float, state: Array) -> list[float]:
    """Return the rates of q, v and h of a wheel that is told 2 sin(7 t)."""
    _, v, h = state
    return [v, (2.0 * np.sin(7.0 * time) - C * h) / 0.25, (v - 0.5 * (abs(v) * h + v * abs(h))) / Z]


def test_a_wheel_in_a_loop_follows_the_law_as_it_is_written(wheels: Callable[..., Robot]) -> None:
    step = 0.0005
    run = Simulator(wheels(), (Hysteresis(joint="axle", c=C, z=Z),), step=step).run(
        seconds=1.5, command={"axle": lambda t: 2.0 * np.sin(7.0 * (t + 0.5 * step))}
    )
    time = run.channel("axle.position").time
    due = solve_ivp(law, (0.0, 1.5), [0.0, 0.0, 0.0], t_eval=time, rtol=1e-9, atol=1e-10).y
    # Half a step of velocity, 0.25 ms * 2 rad/s, for a leapfrog that starts unstaggered.
    assert np.abs(run["axle.position"] - due[0]).max() < 5e-4
    assert np.ptp(due[0]) > 4.0 * Z
    assert np.abs(due[2]).max() > 0.9


@pytest.mark.parametrize("held", [-0.9, -0.2, 0.0, 0.4, 1.0])
@pytest.mark.parametrize("move", [-2.5, -0.3, 0.0, 0.1, 3.0])
def test_between_two_places_the_loop_is_solved_exactly(held: float, move: float) -> None:
    sense = np.sign(move)

    def slope(way: float, h: Array) -> Array:
        return sense - 0.5 * (h + sense * np.abs(h))

    due = solve_ivp(slope, (0.0, abs(move)), [held], rtol=1e-10, atol=1e-12, max_step=0.01).y[0, -1]
    # The kink at h = 0 costs the integrator the fifth power of its steps: 0.01^5 = 1e-10.
    assert followed(np.array(held), np.array(move)) == pytest.approx(due, abs=1e-9)


def test_a_loop_depends_on_the_path_and_not_on_the_speed() -> None:
    path = np.cumsum(np.random.default_rng(0).normal(size=40))
    h, fine = np.array(0.0), np.array(0.0)
    for move in np.diff(path):
        h = followed(h, move)
        for part in np.full(10, 0.1 * move):
            fine = followed(fine, part)
        # Ten parts add up to roundoff.
        assert fine == pytest.approx(h, abs=1e-14)
