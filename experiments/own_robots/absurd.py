"""What no robot does: energy from nothing, a leap without motors, a floor that is sunk into."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from morph.arrays import JSON
from morph.body.load import load
from morph.physics.worlds import world
from morph.record.load import load_recordings
from morph.sim.simulator import Simulator
from morph.sim.start import started

RISES, SINKS, GAINS = 1.0, 0.02, 0.02
"""Sizes by which the base of a robot without power rises, by which it is sunk into what it touches,
and share of the range of its kinetic or potential energy that it gains: more is absurd."""
SETTLED = 0.2
"""Seconds after the start in which parts that overlapped there come apart."""


def absurd_motion(
    path: Path, recording: Path, *, base: str | None, folder: str | None, floor: str | None
) -> list[str]:
    """Return what is absurd about a recorded motion in which every actuator was told zero."""
    robot = load(path, base=base, folder=folder)
    effects = () if floor is None else world(floor, robot).effects
    model: Any = Simulator(robot, effects).model
    (run,) = load_recordings(recording)
    states = _states(robot, model, run.channels)
    data, size = mujoco.MjData(model), max(float(model.stat.extent), 1e-6)
    if not all(np.isfinite(part).all() for part in states[1:]) or not len(states[0]):
        return ["a state is not finite"]
    heights, depths, energies = [], [], []
    model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    for position, velocity in zip(*states[1:], strict=True):
        data.qpos[:], data.qvel[:] = position, velocity
        mujoco.mj_forward(model, data)
        heights.append(float(data.subtree_com[0, 2]))
        depths.append(-min((float(each.dist) for each in data.contact), default=0.0))
        energies.append(data.energy.copy())
    found, later = [], states[0] > SETTLED
    passive = not any(each.kind == "position" for each in robot.actuators)
    if passive and heights and max(heights) - heights[0] > RISES * size:
        found.append(f"it rises by {max(heights) - heights[0]:.3g} m without power")
    if later.any() and max(np.array(depths)[later]) > SINKS * size:
        found.append(f"it is {max(np.array(depths)[later]):.3g} m deep in what it touches")
    energy = np.array(energies).reshape(-1, 2)
    whole, scale = energy.sum(axis=1), max(float(np.ptp(energy, axis=0).max()), 1e-9)
    gained = float(whole.max() - whole[0])
    if passive and gained > GAINS * scale:
        found.append(f"it gains {gained:.3g} J without power")
    return found


def absurd_policy(record: JSON) -> list[str]:
    """Return what is absurd about a learned policy: success that is worse than doing nothing."""
    nothing = record["controls"]["nothing"]["loss"]["mean"]
    mean = record["judged"]["loss"]["mean"]
    if record["succeeded"] and (mean is None or (nothing is not None and mean > nothing)):
        return [f"a policy of loss {mean} is called a success, and doing nothing has {nothing:.3g}"]
    return []


def _states(robot: Any, model: Any, channels: Mapping[str, Any]) -> tuple[Any, Any, Any]:
    """Return times, positions and velocities of a simulated recording."""
    parts = {each.link if each.kind == "free" else each.name for each in robot.joints}
    of_joints = [name for name in channels if name.partition(".")[0] in parts]
    names = [name for name in of_joints if ".position" in name or ".orientation" in name]
    rates = [name for name in of_joints if "velocity" in name]
    times = channels[names[0]].time
    position, velocity = np.empty((len(times), model.nq)), np.empty((len(times), model.nv))
    for at in range(len(times)):
        here, speed = (
            {name.removesuffix(ending): float(channels[name].value[at]) for name in each}
            for each, ending in ((names, ".position"), (rates, ".velocity"))
        )
        position[at], velocity[at] = started(robot, model, here, speed)
    return times, position, velocity
