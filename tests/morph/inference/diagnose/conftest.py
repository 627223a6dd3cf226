"""Recordings made by hand-written equations: nothing here moves by MuJoCo."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import pytest

from experiments.conceal.equations import Equations
from experiments.conceal.excite import free, on_rail
from experiments.conceal.laws import neutral
from experiments.conceal.march import Drive, Motion, march
from morph.arrays import Array
from morph.record.recording import Channel, Recording

STEP = 5e-4
RATE = 100.0
NOISE = 3e-4
"""Standard deviation of a reading, rad or m."""

Law = tuple[str, int, Mapping[str, float]]
"""An effect's name, the joint's place and its parameters."""
Push = Callable[[Array], Array]
"""From times, s, to a torque on the first joint that no command tells of."""


class Truth:
    """Runs of one mechanism, as they were and as they were read."""

    def __init__(self, equations: Equations, motion: Motion, recordings: list[Recording]) -> None:
        self.equations = equations
        self.motion = motion
        self.recordings = recordings

    def state(self, run: int, when: float) -> tuple[Array, Array]:
        """Return true positions and velocities of a run at a time on the grid of the readings."""
        at = round(when / self.motion.every)
        return self.motion.q[at, :, run], self.motion.v[at, :, run]


def record(
    equations: Equations,
    laws: Sequence[Law] = (),
    *,
    seeds: Sequence[int],
    seconds: float = 4.0,
    push: Sequence[Push] | None = None,
    **figures: float,
) -> Truth:
    """Return runs of a mechanism under effects, one a seed.

    Args:
        equations: The mechanism.
        laws: What the description leaves out.
        seeds: Of commands, starts and noise.
        seconds: Length of each run.
        push: A torque for each run that is in no recording.
        figures: True figures that are not as described.
    """
    joints, rows = len(equations.joints), len(seeds)
    felt = neutral(joints, rows)
    for name, joint, parameters in laws:
        felt = felt.put(name, joint, slice(None), dict(parameters))
    ticks = np.arange(0.0, seconds + 1e-9, 1.0 / RATE)
    commands, starts = [], []
    for seed in seeds:
        rng = np.random.default_rng(seed)
        command, start = np.zeros((joints, len(ticks))), np.zeros(joints)
        for joint, name in enumerate(equations.joints):
            reach = equations.reach[joint]
            turning = equations.kinds[joint] == "hinge"
            if name in equations.actuators:
                shape = free if turning else on_rail
                command[joint] = (reach.effort * shape("multisine", ticks, rng)).round(6)
            if turning:
                start[joint] = rng.uniform(-0.7, 0.7)
        commands.append(command)
        starts.append(start)
    drive = Drive(ticks=(ticks,) * rows, commands=tuple(commands))
    torque = drive.produced(felt, np.zeros(rows), round(seconds / STEP), STEP)
    middle = (np.arange(len(torque)) + 0.5) * STEP
    for row, pushed in enumerate(push or ()):
        torque[:, 0, row] += pushed(middle)
    true = {**equations.nominal(), **figures}
    motion = march(
        equations,
        {name: np.full(rows, value) for name, value in true.items()},
        felt,
        torque,
        np.array(starts).T,
        np.zeros((joints, rows)),
        step=STEP,
        keep=1.0 / RATE,
    )
    return Truth(equations, motion, [_read(equations, motion, commands, ticks, *each)
                                     for each in enumerate(seeds)])  # fmt: skip


def _read(
    equations: Equations, motion: Motion, commands: list[Array], ticks: Array, row: int, seed: int
) -> Recording:
    rng = np.random.default_rng([seed, 1])
    channels = {}
    for joint, name in enumerate(equations.joints):
        # The last sum of steps may be short of the last reading by rounding.
        value = motion.q[: len(ticks), joint, row] + rng.normal(0.0, NOISE, len(ticks))
        channels[f"{name}.position"] = Channel(time=ticks, value=value)
        if name in equations.actuators:
            told = Channel(time=ticks, value=commands[row][joint], hold=True)
            channels[f"{name}.command"] = told
    return Recording(name=f"run_{seed}", channels=channels)


@pytest.fixture(scope="session")
def recorded() -> Callable[..., Truth]:
    """Makes runs; see `record`."""
    return record
