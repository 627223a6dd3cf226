"""Bodies of any kind led along sines, and what is logged of them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np

from experiments.needs import need_robots
from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.errors import SimulationFailed
from morph.physics.effect import Effect
from morph.physics.worlds import on_floor
from morph.record.recording import Channel, Recording
from morph.sim.closed_loop import closed_loop
from morph.sim.simulator import Simulator, Trajectory
from morph.sim.start import started

STEP, PERIOD = 0.00025, 0.002
"""Seconds a step of the simulation, which damps to first order, and between two commands."""
LOWEST, HIGHEST, WAVES = 0.1, 1.5, 5
"""Hz: the band of the sines, and how many are added."""
REACH, FREE = 0.25, 0.6
"""Share of a joint's range that sines take either way of its middle, and how far they go without a
range, rad or m."""
EFFORT = 0.3
"""Share of an actuator's limit that it is told where it drives no joint of its own."""
QUICKNESS = 12.0
"""Natural frequency of the controller of a joint that is driven by effort, rad/s."""
FLOOR = "hard_floor"
"""Under bodies that would fall without end."""
UPRIGHT = 0.9
"""Least vertical part of an axis along which a link would fall."""
SECONDS, RATE, NOISE = 8.0, 100.0, 5e-4
"""Length of a run in s, readings a second and their standard deviation, rad or m."""


def loaded(body: str) -> Robot:
    """Return a body; one that would fall without end stands on a floor."""
    robot = load(body if "/" not in body else need_robots() / body)
    wet = robot.card is not None and robot.card.water is not None
    return on_floor(robot, FLOOR) if not wet and _falls(robot) else robot


def _falls(robot: Robot) -> bool:
    """Return whether a link floats, or slides upright with no drive."""
    model = spec_of(robot).compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    upright = [
        joint.name not in robot.driven and abs(float(data.joint(joint.name).xaxis[2])) > UPRIGHT
        for joint in robot.joints
        if joint.kind == "slide"
    ]
    return any(upright) or any(joint.kind == "free" for joint in robot.joints)


def moved_along_sines(
    robot: Robot, effects: tuple[Effect, ...], rng: np.random.Generator
) -> Trajectory:
    """Return a motion along sines, as commanded as a robot of its kind would be."""
    simulator = Simulator(robot, effects=effects, step=STEP)
    act, start = _controller(robot, Simulator(robot, step=STEP).model, rng)
    still = np.zeros(simulator.model.nv)
    loop = closed_loop(simulator, act, start[None], still[None], period=PERIOD, seconds=SECONDS)
    if not loop.stable[0]:
        raise SimulationFailed("it diverges", where=f"robot {robot.name}", fix="draw another seed")
    told = loop.command[0, :-1]
    return Trajectory(
        time=loop.time,
        position=loop.position[0],
        velocity=loop.velocity[0],
        command={each.name: told[:, at] for at, each in enumerate(robot.actuators)},
    )


def _controller(robot: Robot, model: Any, rng: np.random.Generator) -> tuple[Any, Array]:
    """Return what commands a robot by its state and the time, and where it starts."""
    home, _ = started(robot, model)
    data = mujoco.MjData(model)
    data.qpos[:] = home
    mujoco.mj_forward(model, data)
    inertia = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, inertia)
    frequency = rng.uniform(LOWEST, HIGHEST, (model.nu, WAVES))
    phase = rng.uniform(0.0, 2.0 * np.pi, (model.nu, WAVES))
    parts = list(_drives(robot, model, home, inertia))

    def act(q: Array, v: Array, t: float) -> Array:
        # From rest, and smoothly.
        wave = np.sin(2.0 * np.pi * frequency * t + phase).sum(axis=1) / np.sqrt(WAVES)
        wave *= min(1.0, t / 1.0)
        told = np.empty((len(q), model.nu))
        for at, (middle, reach, place, dof, stiff, damp, low, high) in enumerate(parts):
            wanted = middle + reach * wave[at]
            if stiff is not None:
                wanted = stiff * (wanted - q[:, place]) - damp * v[:, dof]
            told[:, at] = np.clip(wanted, low, high)
        return told

    return act, home


def _drives(robot: Robot, model: Any, home: Array, inertia: Array) -> Iterator[tuple[Any, ...]]:
    """Yield by actuator the middle and reach of its sines, what it drives, gains and limits."""
    for at, each in enumerate(robot.actuators):
        low, high = -np.inf, np.inf
        if model.actuator_ctrllimited[at]:
            low, high = model.actuator_ctrlrange[at]
        if each.joint is None:
            most = min(abs(high), abs(low), 10.0 if each.limit is None else each.limit)
            yield 0.0, EFFORT * most, 0, 0, None, 0.0, low, high
            continue
        joint = model.joint(each.joint)
        place, dof = int(joint.qposadr[0]), int(joint.dofadr[0])
        middle, reach = float(home[place]), FREE
        if model.jnt_limited[joint.id]:
            bottom, top = model.jnt_range[joint.id]
            reach = min(REACH * (top - bottom), FREE)
            middle = float(np.clip(middle, bottom + reach, top - reach))
        gear = float(model.actuator_gear[at, 0])
        if each.kind == "position":
            yield gear * middle, gear * reach, place, dof, None, 0.0, low, high
            continue
        gain = float(model.actuator_gainprm[at, 0]) * gear
        stiff = inertia[dof, dof] * QUICKNESS**2 / gain
        damp = 2.0 * inertia[dof, dof] * QUICKNESS / gain
        yield middle, reach, place, dof, stiff, damp, low, high


def read(
    robot: Robot,
    effects: tuple[Effect, ...],
    moved: Trajectory,
    rng: np.random.Generator,
    name: str,
) -> Recording:
    """Return a motion as it is logged."""
    made = Simulator(robot, effects=effects, step=STEP).recorded(moved, name)
    every, channels = round(1.0 / (RATE * PERIOD)), {}
    for channel, each in made.channels.items():
        if each.hold:
            channels[channel] = each
        elif ".position" in channel or ".orientation" in channel:
            value = each.value[::every]
            value = value + rng.normal(0.0, NOISE, len(value))
            channels[channel] = Channel(time=each.time[::every], value=value)
    return replace(made, channels=channels)
