"""Closed loops against open ones, closed forms, and the effects that look back."""

from __future__ import annotations

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.errors import SimulationFailed
from morph.physics.actuator.actuator_delay import ActuatorDelay
from morph.physics.actuator.actuator_lag import ActuatorLag
from morph.physics.actuator.dead_zone import DeadZone
from morph.physics.joint.armature import Armature
from morph.physics.joint.series_elasticity import SeriesElasticity
from morph.physics.joint.stribeck_friction import StribeckFriction
from morph.sim.closed_loop import closed_loop
from morph.sim.simulator import Simulator


@pytest.fixture(scope="module")
def cartpole() -> Robot:
    return load("cartpole")


def wave(time: Array) -> Array:
    """A command that holds for 50 ms at a time."""
    return np.asarray(3.0 * np.sin(4.0 * 0.05 * np.floor(np.asarray(time) / 0.05 + 1e-6)))


EFFECTS = {
    "none": (),
    "a delay of 2.6 steps": (ActuatorDelay(actuator="slide", T=0.013),),
    "a lag": (ActuatorLag(actuator="slide", T=0.03),),
    "a friction that acts before each step": (
        StribeckFriction(joint="hinge", c=0.01, s=0.02, vs=0.3),
    ),
    "both kinds": (
        ActuatorDelay(actuator="slide", T=0.013),
        StribeckFriction(joint="hinge", c=0.01, s=0.02, vs=0.3),
    ),
    "one that remembers, on what another leaves": (
        SeriesElasticity(joint="slide", k=300.0, d=2.0),
        Armature(joint="slide", J=0.2),
        DeadZone(actuator="slide", threshold=0.5),
    ),
}


@pytest.mark.parametrize("effects", EFFECTS.values(), ids=EFFECTS.keys())
@pytest.mark.parametrize("every_step", [False, True])
def test_a_policy_that_looks_at_nothing_moves_a_body_as_the_open_loop_does(
    cartpole: Robot, effects: tuple, every_step: bool
) -> None:
    simulator = Simulator(cartpole, effects, step=0.005)
    open_loop = simulator.trajectory(seconds=1.0, start={"hinge": 0.4}, command={"slide": wave})
    start = np.array([[0.0, 0.4]])
    loop = closed_loop(
        simulator,
        lambda q, v, time: np.full((1, 1), wave(time)),
        start,
        np.zeros((1, 2)),
        period=0.05,
        seconds=1.0,
        every_step=every_step,
    )
    each = 1 if every_step else 10
    # The same arithmetic in the same order: to the last bits of sums of 200 steps.
    np.testing.assert_allclose(loop.position[0], open_loop.position[::each], atol=1e-12)
    np.testing.assert_allclose(loop.time, open_loop.time[::each], atol=1e-12)


def test_rows_do_not_know_of_each_other(cartpole: Robot) -> None:
    simulator = Simulator(cartpole, step=0.005)
    rng = np.random.default_rng(3)
    q, v = rng.normal(size=(5, 2)), rng.normal(size=(5, 2))
    gain = np.array([1.0, -2.0])

    def act(q: Array, v: Array, time: float) -> Array:
        return np.asarray((q + v) @ gain[:, None])

    together = closed_loop(simulator, act, q, v, period=0.05, seconds=0.5)
    for row in range(5):
        alone = closed_loop(simulator, act, q[[row]], v[[row]], period=0.05, seconds=0.5)
        np.testing.assert_array_equal(alone.position[0], together.position[row])


def test_a_proportional_loop_on_a_mass_is_the_recursion_of_textbooks() -> None:
    # A cart alone: m v' = u - b v, held for h; exactly discretised with a = exp(-b h / m).
    robot = load("cartpole")
    simulator = Simulator(robot, step=0.0005)
    # The pole hangs at rest, so at first the cart moves as if the pole were not felt by gravity;
    # instead of approximating, hold both: momentum of the whole along x changes by u - b v.
    loop = closed_loop(
        simulator,
        lambda q, v, time: -4.0 * q[:, :1] + 1.0,
        np.zeros((1, 2)),
        np.zeros((1, 2)),
        period=0.02,
        seconds=1.0,
        every_step=True,
    )
    _, th = loop.position[0].T
    xd, thd = loop.velocity[0].T
    # p = (M + m) x' + m l/2 cos(th) th'; dp/dt = u - b x' (Gamboa Higuera 2015, figure 7).
    momentum = 1.0 * xd + 0.5 * 0.25 * np.cos(th) * thd
    force = loop.command[0, :-1, 0] - 0.1 * xd[1:]
    # A first-order integrator at 0.5 ms: the sum's error is of the order of force * step = 5e-4.
    np.testing.assert_allclose(momentum[-1], 0.0005 * force.sum(), atol=5e-4)
    assert abs(momentum[-1]) > 0.05


@pytest.mark.parametrize("period", [0.013, 0.0, -1.0, 3.0])
def test_a_period_that_does_not_fit_is_refused(cartpole: Robot, period: float) -> None:
    simulator = Simulator(cartpole, step=0.005)
    with pytest.raises(SimulationFailed, match="fits neither"):
        closed_loop(
            simulator,
            lambda q, v, time: np.zeros((1, 1)),
            np.zeros((1, 2)),
            np.zeros((1, 2)),
            period=period,
            seconds=1.0,
        )


@pytest.mark.parametrize("command", [np.full((1, 1), np.nan), np.zeros((1, 2)), np.zeros(3)])
def test_a_command_that_is_no_number_or_not_for_this_body_is_refused(
    cartpole: Robot, command: Array
) -> None:
    simulator = Simulator(cartpole, step=0.005)
    with pytest.raises(SimulationFailed, match="not a finite number"):
        closed_loop(
            simulator,
            lambda q, v, time: command,
            np.zeros((1, 2)),
            np.zeros((1, 2)),
            period=0.05,
            seconds=0.5,
        )
