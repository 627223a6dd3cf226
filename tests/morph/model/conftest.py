"""Robots and recordings of them that MuJoCo makes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.physics.effect import Effect
from morph.record.recording import Channel, Recording
from morph.sim.simulator import Simulator

Recorded = Callable[..., Recording]


@pytest.fixture(scope="session")
def pendulum() -> Robot:
    return load("pendulum")


@pytest.fixture(scope="session")
def cartpole() -> Robot:
    return load("cartpole")


def _recorded(
    robot: Robot,
    *effects: Effect,
    seconds: float = 4.0,
    noise: float = 2e-4,
    seed: int = 0,
    name: str = "run",
    start: Mapping[str, float] | None = None,
    command: Callable[[Array], Array] | None = None,
) -> Recording:
    """Return a recording at 200 Hz of a run simulated at 2 kHz, every actuator told alike."""
    rng = np.random.default_rng(seed)
    told = {a.name: command or (lambda times: 0.0 * times) for a in robot.actuators}
    fine = Simulator(robot, effects=effects, step=0.0005).run(
        seconds=seconds, start=start, command=told
    )
    channels = {}
    for channel, c in fine.channels.items():
        if c.hold:
            channels[channel] = c
        elif channel.endswith(".position"):
            value = c.value[::10]
            channels[channel] = Channel(
                time=c.time[::10], value=value + rng.normal(0.0, noise, len(value))
            )
    return replace(fine, channels=channels, name=name)


@pytest.fixture(scope="session")
def recorded() -> Recorded:
    """Makes recordings."""
    return _recorded
