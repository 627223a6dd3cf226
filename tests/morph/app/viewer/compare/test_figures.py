"""Energy, margin, cost and verdict against a wheel that a constant torque turns."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from morph.app.viewer.compare.figures import (
    COST,
    ENERGY,
    MARGIN,
    cost,
    energy,
    margin,
    series,
    verdict,
)
from morph.app.viewer.compare.forces import forces
from morph.app.viewer.compare.run import SimulatedRun, ran
from morph.body.robot import Robot
from morph.policy.pattern import Swing, pattern
from morph.task.task import Task

INERTIA = 2.0


def turned(task: Task, torque: float) -> SimulatedRun:
    return ran(task, pattern(task.robot, {"axle": Swing(offset=torque)}, period=task.period))


@pytest.fixture
def task(wheel: Robot, asked: Callable[..., Task]) -> Task:
    return asked(wheel)


def test_the_energy_of_a_constant_torque_is_the_energy_of_the_wheel(task: Task) -> None:
    run = turned(task, 3.0)
    spent = energy(run, forces(run))
    # Torque times angle: 3 N m (3 / 2 rad/s2) t^2 / 2. A step that ends with the new speed
    # goes t h / 2 farther: relative to t that is h / t = 0.005 at the end.
    assert spent[-1] == pytest.approx(3.0 * 0.75, rel=0.006)
    assert spent[-1] == pytest.approx(3.0 * run.position[-1, 0], rel=1e-9)
    # And the wheel has it, but for the same error.
    assert spent[-1] == pytest.approx(0.5 * INERTIA * run.velocity[-1, 0] ** 2, rel=0.006)


def test_braking_takes_energy_like_driving(task: Task) -> None:
    swings = {"axle": Swing(amplitude=3.0, frequency=1.0, phase=np.pi / 2.0)}
    run = ran(task, pattern(task.robot, swings, period=0.05))
    spent = energy(run, forces(run))
    assert (np.diff(spent) >= 0.0).all()
    # A cosine speeds the wheel up, brings it back to rest, and so on: v = A sin(w t), with
    # A = 3 / (2 w) = 0.239 rad/s. Four times the greatest energy: 4 * 0.5 * 2 * A^2 = 0.228 J;
    # commands held for a twentieth of the period shift it by some percent.
    assert spent[-1] == pytest.approx(4.0 * 0.5 * INERTIA * (3.0 / (4.0 * np.pi)) ** 2, rel=0.1)


def test_the_margin_is_what_was_left_at_the_worst_so_far() -> None:
    efforts = np.array([[1.0, 0.0], [-3.0, 9.0], [0.5, 0.0]])
    # The second motor has no limit: only the first counts, 4 N m.
    left = margin(efforts, np.array([4.0, np.nan]))
    np.testing.assert_allclose(left, [0.75, 0.25, 0.25])
    assert np.isnan(margin(efforts, np.array([np.nan, np.nan]))).all()


def test_a_motor_at_its_limit_has_no_margin(task: Task) -> None:
    # It is told more than its 4 N m, and its policy's bounds keep it there.
    run = turned(task, 9.0)
    assert margin(forces(run).effort, np.array([4.0]))[-1] == pytest.approx(0.0, abs=1e-12)


def test_the_cost_falls_due_at_control_times(task: Task) -> None:
    run = turned(task, 3.0)
    due = cost(task, run)
    # u^2 / 2 = 4.5 at 0, 0.05 s and so on: 21 times up to the end at 1 s.
    assert due[0] == pytest.approx(4.5)
    assert due[9] == pytest.approx(4.5)
    assert due[10] == pytest.approx(9.0)
    assert due[-1] == pytest.approx(21 * 4.5)


def test_a_longer_run_costs_and_is_judged_up_to_the_horizon_only(task: Task) -> None:
    policy = pattern(task.robot, {"axle": Swing(offset=0.5)}, period=task.period)
    run = ran(task, policy, seconds=1.5)
    assert cost(task, run)[-1] == pytest.approx(21 * 0.125)
    judged = verdict(task, run)
    assert judged is not None
    assert (judged.reached, judged.missed) == (("rest",), ())
    assert verdict(task, ran(task, policy, seconds=0.5)) is None


def test_a_goal_that_is_missed_is_named(task: Task) -> None:
    judged = verdict(task, turned(task, 3.0))
    assert judged is not None
    assert (judged.reached, judged.missed) == ((), ("rest",))


def test_a_run_that_becomes_unstable_ends_before_and_is_not_judged(
    made: Callable[..., Robot], asked: Callable[..., Task]
) -> None:
    # A stiff spring that an explicit step cannot follow: w h = sqrt(1e6 / 1) * 0.02 = 20.
    robot = made(
        """<body name="a"><joint name="a" type="slide" axis="1 0 0" stiffness="1e6"
        springref="0.01"/><geom type="sphere" size="0.1" mass="1" contype="0"
        conaffinity="0"/></body>""",
        '<motor name="a" joint="a"/>',
    )
    task = asked(robot, step=0.02, period=0.02, integrator="rk4")
    run = ran(task, None)
    assert "unstable" in run.why
    assert 0.0 < run.time[-1] < 1.0
    assert np.isfinite(run.position).all()
    assert verdict(task, run) is None


def test_series_have_a_number_for_each_picture(task: Task) -> None:
    run = turned(task, 3.0)
    found = series(task, run, forces(run))
    assert {name: len(each) for name, each in found.items()} == {ENERGY: 61, MARGIN: 61, COST: 61}
    assert found[MARGIN][-1] == pytest.approx(25.0)


def test_bodies_alike_begin_alike_and_the_seed_says_where(task: Task) -> None:
    spread = replace(task, start=replace(task.start, spread=0.1))
    one, same, other = (ran(spread, None, seed=seed).position[0] for seed in (0, 0, 1))
    assert one == pytest.approx(same)
    assert one != pytest.approx(other)
