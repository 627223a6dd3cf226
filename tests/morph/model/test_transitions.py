"""Transitions are MuJoCo's own, along runs of bodies that float or not."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pytest

from morph.body.load import load
from morph.errors import DiagnosisError
from morph.model.latent.run import Run
from morph.model.transitions import transitions
from morph.physics.actuator.actuator_delay import ActuatorDelay
from morph.physics.sensor.sensor_bias import SensorBias
from morph.sim.rollout import Variant
from morph.sim.simulator import Simulator

PERIOD = 0.05


def _run(simulator: Simulator, *, biased: float = 0.0) -> Run:
    """Return a noiseless run with a command for every actuator."""
    robot = simulator.robot
    every, periods = round(PERIOD / simulator.step), 8
    told = {
        actuator.name: 0.3 * np.sin(1.0 + at + np.arange(periods))
        for at, actuator in enumerate(robot.actuators)
    }
    moved = simulator.trajectory(
        seconds=PERIOD * periods,
        speed={joint.name: 0.4 for joint in robot.joints if joint.kind == "hinge"},
        command={
            name: (lambda times, v=values: v[np.floor(times / PERIOD + 1e-6).astype(int)])
            for name, values in told.items()
        },
    )
    command = np.zeros((periods, simulator.model.nu))
    for name, values in told.items():
        command[:, simulator.model.actuator(name).id] = values
    position = moved.position[::every].copy()
    position[:, 0] += biased
    return Run(position=position, velocity=moved.velocity[::every], command=command, period=PERIOD)


def _variant(simulator: Simulator) -> Variant:
    return Variant(model=simulator.model, effects=simulator.effects)


@pytest.mark.parametrize("body", ["cartpole", "hexapod_swimmer"])
def test_a_model_misses_nothing_of_its_own_run(body: str) -> None:
    simulator = Simulator(load(body), step=0.005)
    seen = transitions(simulator.robot, [_variant(simulator)], _run(simulator))
    # The very same steps from the very same states; quaternions are normalised once more.
    assert np.abs(seen.miss).max() < 1e-9


def test_a_delay_looks_back_beyond_its_period_and_a_bias_is_taken_off() -> None:
    effects = (
        ActuatorDelay(actuator="slide", T=0.08),
        SensorBias(channel="slide.position", bias=0.2),
    )
    simulator = Simulator(load("cartpole"), effects, step=0.005)
    run = _run(simulator, biased=0.2)
    plain = Simulator(load("cartpole"), step=0.005)
    seen = transitions(simulator.robot, [_variant(simulator)], run)
    assert np.abs(seen.miss).max() < 1e-9
    assert np.abs(transitions(plain.robot, [_variant(plain)], run).miss).max() > 1e-3


@pytest.mark.parametrize("body", ["cartpole", "hexapod_swimmer"])
def test_small_errors_are_handed_on_as_mujoco_differentiates(body: str) -> None:
    simulator = Simulator(load(body), step=0.005, integrator="implicitfast")
    run = _run(simulator)
    seen = transitions(simulator.robot, [_variant(simulator)], run)
    model: Any = simulator.model
    data = mujoco.MjData(model)
    at = 5
    data.qpos[:], data.qvel[:] = run.position[at], run.velocity[at]
    data.ctrl[:] = run.command[at]
    whole = np.eye(2 * model.nv)
    for _ in range(10):
        step = np.zeros((2 * model.nv, 2 * model.nv))
        mujoco.mjd_transitionFD(model, data, 1e-6, 1, step, None, None, None)
        whole = step @ whole
        mujoco.mj_step(model, data)
    # Ours are one-sided, over 1e-5: off by 1e-5 times a curvature of a few units.
    assert np.abs(seen.carry[0, at] - whole).max() < 1e-3 * np.abs(whole).max()


def test_models_are_told_apart_by_their_own_misses_and_may_share_the_first_ones_carry() -> None:
    simulator = Simulator(load("cartpole"), step=0.005)
    other = Simulator(load("cartpole"), (ActuatorDelay(actuator="slide", T=0.1),), step=0.005)
    run, both = _run(simulator), [_variant(simulator), _variant(other)]
    seen = transitions(simulator.robot, both, run, each=False)
    assert seen.miss.shape == (2, 8, 4)
    assert seen.carry.shape == (1, 8, 4, 4)
    assert np.abs(seen.miss[0]).max() < 1e-9 < 1e-3 < np.abs(seen.miss[1]).max()


def test_a_run_of_another_body_or_clock_is_refused() -> None:
    simulator = Simulator(load("cartpole"), step=0.004)
    run = _run(Simulator(load("cartpole"), step=0.005))
    with pytest.raises(DiagnosisError, match=r"0\.05 s is no multiple of a step, 0\.004 s"):
        transitions(simulator.robot, [_variant(simulator)], run)
    pendulum = Simulator(load("pendulum"), step=0.005)
    with pytest.raises(DiagnosisError, match="it has 2 positions, 2 velocities and 1 commands"):
        transitions(pendulum.robot, [_variant(pendulum)], run)
