"""What is not named: a process with the covariance that it promises, and forces that push."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np

from morph.model.kwik.features import LENGTH, forces, unnamed
from morph.task.task import Task


def test_many_waves_have_the_covariance_of_a_smooth_process(task: Task) -> None:
    model = task.simulator().model
    rng = np.random.default_rng(100)
    state, command = rng.normal(size=(40, 4)), rng.normal(size=(40, 1))
    few = unnamed(model, state, command, command, epsilon=np.ones(4), period=0.05)
    count = 20_000
    many = replace(
        few,
        frequency=rng.normal(scale=1.0 / LENGTH, size=(5, count)),
        phase=rng.uniform(0.0, 2.0 * np.pi, count),
    )
    inputs = np.concatenate([state, command], axis=1)
    wave = many(model, state, command, command)[:, 2, :count]
    scaled = inputs / few.spread
    apart = ((scaled[:, None] - scaled[None]) ** 2).sum(axis=2)
    # Each entry is a mean of 20000 terms of size 2 cos cos: a standard error below 0.0071; five.
    np.testing.assert_allclose(wave @ wave.T, np.exp(-0.5 * apart / LENGTH**2), atol=0.036)


def test_a_late_command_is_the_force_of_the_difference(task: Task) -> None:
    model = task.simulator().model
    rng = np.random.default_rng(101)
    state = rng.normal(size=(5, 4))
    command, before = np.full((5, 1), 4.0), np.full((5, 1), -3.0)
    late = forces(model, state, command, before, np.ones(5))[:, :, -1]
    data, full = mujoco.MjData(model), np.zeros((2, 2))
    for at, place in enumerate(state):
        data.qpos[:] = place[:2]
        mujoco.mj_forward(model, data)
        mujoco.mj_fullM(model, data, full)
        # The motor pushes the slide with -3 N instead of 4 N.
        np.testing.assert_allclose(full @ late[at], [-7.0, 0.0], atol=1e-9)


def test_frictions_take_energy_away(task: Task) -> None:
    model = task.simulator().model
    rng = np.random.default_rng(102)
    state, none = rng.normal(size=(20, 4)), np.zeros((20, 1))
    acceleration = forces(model, state, none, none, np.ones(5))
    data, full = mujoco.MjData(model), np.zeros((2, 2))
    for at, place in enumerate(state):
        data.qpos[:] = place[:2]
        mujoco.mj_forward(model, data)
        mujoco.mj_fullM(model, data, full)
        power = place[2:] @ full @ acceleration[at][:, :6]
        assert (power < 0.0).all()
