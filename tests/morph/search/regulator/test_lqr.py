"""The regulator is the one that textbooks give."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from morph.body.load import load
from morph.errors import SearchError
from morph.search.plan.terminal_controller import held
from morph.search.regulator.lqr import lqr, noise_aware
from morph.search.regulator.rest import rest
from morph.search.trajectory.linearise import linearise
from morph.search.trajectory.plant import Plant
from morph.sim.simulator import Simulator
from morph.task.quantity import JointPositions
from morph.task.tasks import task
from morph.task.term import Goal


def test_of_one_integrator_the_worth_is_the_golden_ratio() -> None:
    # p = 1 + p - p^2 / (1 + p) gives p^2 = p + 1; the gain is -p / (1 + p) = 1 - p.
    one = np.ones((1, 1))
    found = lqr(one, one, one, one, where="a test", kept=1.0)
    golden = (1.0 + np.sqrt(5.0)) / 2.0
    assert found.worth[0, 0] == pytest.approx(golden)
    assert found.gain[0, 0] == pytest.approx(1.0 - golden)


def test_of_a_double_integrator_the_gain_nears_that_of_continuous_time() -> None:
    # In continuous time, with Q = diag(1, 0) and R = 1: u = -x - sqrt(2) v (Anderson and Moore,
    # section 2.3). A period h costs h (Q, R), and the gain differs by a share of order h.
    h = 1e-3
    A, B = np.array([[1.0, h], [0.0, 1.0]]), np.array([[h**2 / 2.0], [h]])
    found = lqr(A, B, h * np.diag([1.0, 0.0]), h * np.eye(1), where="a test", kept=1.0)
    assert found.gain[0] == pytest.approx([-1.0, -np.sqrt(2.0)], rel=2e-3)


def test_upright_the_cartpole_has_the_modes_of_its_linear_equations() -> None:
    # Cart M, pole m with its centre c = l/2 off the hinge and I about it, lean p, friction b:
    # (M + m) x'' - m c p'' = -b x', (I + m c^2) p'' - m c x'' = m g c p.
    m, M, c, b, g = 0.5, 0.5, 0.25, 0.1, 9.82
    inertia = np.array([[M + m, -m * c], [-m * c, m * 0.25 / 12.0 + m * c**2]])
    force = np.array([[0.0, 0.0, -b, 0.0], [0.0, m * g * c, 0.0, 0.0]])
    slope = np.block([[np.zeros((2, 2)), np.eye(2)], [np.linalg.solve(inertia, force)]])
    expected = np.sort(np.linalg.eigvals(expm(0.05 * slope)).real)
    plant = Plant(Simulator(load("cartpole"), step=0.001), 0.05)
    A, _ = linearise(plant, np.array([0.0, np.pi]), np.zeros(2), np.zeros(1))
    # Semi-implicit steps h are off by a share of lambda^2 h T / 2 with lambda = 6.9 per s: 0.12 %.
    assert np.sort(np.linalg.eigvals(A).real) == pytest.approx(expected, rel=2e-3)


def test_a_motion_that_grows_and_that_nothing_moves_is_refused_by_its_place() -> None:
    A, B = np.diag([0.9, 1.2]), np.array([[1.0], [0.0]])
    with pytest.raises(SearchError, match=r"grows 1\.2-fold .* in number 1 of the state"):
        lqr(A, B, np.eye(2), np.eye(1), where="a test")


def test_a_drift_that_nothing_moves_is_left_alone() -> None:
    A, B = np.diag([1.3, 1.0]), np.array([[1.0], [0.0]])
    found = lqr(A, B, np.eye(2), np.eye(1), where="a test")
    assert abs(1.3 + found.gain[0, 0]) < 1.0
    assert found.gain[0, 1] == pytest.approx(0.0, abs=1e-9)


def test_louder_noise_makes_smaller_gains() -> None:
    A, B = np.array([[1.0, 0.05], [0.5, 1.0]]), np.array([[0.0], [0.05]])
    told = [
        noise_aware(
            A, B, np.eye(2), np.eye(1), np.full(2, noise), where="a test", bounds=np.array([10.0])
        )
        for noise in (0.001, 0.3)
    ]
    assert np.abs(told[0].gain).max() > np.abs(told[1].gain).max()
    assert told[0].noisy < told[1].noisy


def test_the_cost_at_rest_in_the_noise_is_what_sampling_gives() -> None:
    A, B = np.array([[1.0, 0.05], [0.5, 1.0]]), np.array([[0.0], [0.05]])
    noise = np.array([0.02, 0.01])
    found = noise_aware(A, B, np.eye(2), np.eye(1), noise, where="a test", bounds=np.ones(1))
    rng, x, total = np.random.default_rng(5), np.zeros((4000, 2)), []
    for at in range(400):
        x = x @ A.T + (x + noise * rng.normal(size=x.shape)) @ (B @ found.gain).T
        if at >= 200:
            total.append(0.5 * np.mean(np.sum(x**2, axis=1)))
    # 4000 rows, of which the 200 periods are not all new: about 1 % of sampling error; the
    # discount of 0.999 takes 1 / (1 + 0.001 / 0.1), another per cent, off slow motions.
    assert found.noisy == pytest.approx(np.mean(total), rel=0.05)


def test_a_pendulum_is_held_level_by_its_weight_times_its_length() -> None:
    robot = load("pendulum")
    level = Goal(
        name="level",
        quantity=JointPositions(joints=("hinge",)),
        target=(np.pi / 2.0,),
        within=0.1,
    )
    wanted = replace(task("balance", robot), goals=(level,))
    plant = Plant(wanted.simulator(), wanted.period)
    still = rest(wanted, plant, np.random.default_rng(0))
    assert still.position == pytest.approx([np.pi / 2.0], abs=1e-6)
    # 1 kg at 0.5 m: 9.81 * 0.5 N m.
    assert still.command == pytest.approx([4.905], rel=1e-5)
    regulator = held(wanted, plant, still)
    A, B = linearise(plant, still.position, still.velocity, still.command)
    assert np.abs(np.linalg.eigvals(A + B @ regulator.gain)).max() < 1.0


def test_where_a_pole_would_fall_nothing_rests_and_the_joint_is_named() -> None:
    robot = load("cartpole")
    leaning = Goal(
        name="leaning", quantity=JointPositions(joints=("hinge",)), target=(2.0,), within=0.01
    )
    wanted = replace(task("swing-up", robot), goals=(leaning,))
    plant = Plant(wanted.simulator(), wanted.period)
    with pytest.raises(SearchError, match=r"does not rest: .* at hinge that no actuator holds"):
        rest(wanted, plant, np.random.default_rng(0))


def test_a_motor_that_is_too_weak_to_hold_is_named() -> None:
    robot = load("pendulum")
    weak = replace(robot, actuators=(replace(robot.actuators[0], limit=2.0),))
    level = Goal(
        name="level",
        quantity=JointPositions(joints=("hinge",)),
        target=(np.pi / 2.0,),
        within=0.1,
    )
    wanted = replace(task("balance", robot), goals=(level,), robot=weak)
    plant = Plant(wanted.simulator(), wanted.period)
    with pytest.raises(SearchError, match=r"needs 4\.9 of actuator 'hinge', whose bounds are -2"):
        rest(wanted, plant, np.random.default_rng(0))
