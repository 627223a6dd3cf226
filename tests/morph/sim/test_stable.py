from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from morph.body.load import load
from morph.errors import RobotError, SimulationFailed
from morph.physics.joint.joint_stiffness import JointStiffness
from morph.sim.simulator import Simulator
from morph.sim.stable import as_far_as_stable


def test_a_run_is_kept_up_to_the_step_at_which_it_fails(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    # w h = sqrt(200 / 0.251) * 0.2 = 5.6, and a leapfrog is stable only below 2.
    spring = JointStiffness(joint="hinge", k=200.0)
    simulator = Simulator(load("pendulum"), (spring,), step=0.2)
    moved, why = as_far_as_stable(simulator, seconds=20.0, start={"hinge": 1.0})
    assert why is not None
    assert "unstable" in why.what
    steps = len(moved.time) - 1
    assert 1 < steps < 100
    # One step more fails, and all that is kept is what a run of that length gives.
    with pytest.raises(SimulationFailed):
        simulator.trajectory(seconds=0.2 * (steps + 1), start={"hinge": 1.0})
    again = simulator.trajectory(seconds=0.2 * steps, start={"hinge": 1.0})
    assert np.array_equal(moved.position, again.position)


def test_a_stable_run_is_whole() -> None:
    moved, why = as_far_as_stable(Simulator(load("pendulum")), seconds=0.5, start={"hinge": 1.0})
    assert why is None
    assert moved.time[-1] == pytest.approx(0.5)


def test_what_fails_at_once_is_refused() -> None:
    with pytest.raises(SimulationFailed, match="its command is not one finite number"):
        as_far_as_stable(Simulator(load("pendulum")), seconds=0.5, command={"hinge": np.nan})
    with pytest.raises(RobotError, match="there is no joint 'knee'"):
        as_far_as_stable(Simulator(load("pendulum")), seconds=0.5, start={"knee": 1.0})


def test_a_run_too_long_to_keep_is_refused_rather_than_tried() -> None:
    # 1e8 steps of a position and a velocity are 2e8 numbers; with the command, 3e8.
    simulator = Simulator(load("pendulum"), step=0.001)
    with pytest.raises(SimulationFailed, match=r"1e\+08 steps holds 3e\+08 numbers"):
        as_far_as_stable(simulator, seconds=1e5)
