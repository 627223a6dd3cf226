"""Laws of sensors tried by rollouts, beside a set of effects that does not explain them."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from morph.body.load import load
from morph.inference.by_rollouts import to_rollouts, with_sensors
from morph.inference.effect_selection import EffectSelection
from morph.inference.finalist import Finalist, labels
from morph.inference.search import Prior
from morph.inference.validate import Validation
from morph.model.deadline import NEVER
from morph.model.episodes import episode
from morph.model.hypothesis import Hypothesis
from morph.physics.joint.viscous_friction import ViscousFriction
from morph.physics.sensor.timestamp_offset import TimestampOffset
from morph.record.recording import Channel, Recording

INERTIA, FRICTION, NOISE, LATE = 0.02, 0.02, 2e-4, 0.03
DISC = f"""
<mujoco model="disc"><option gravity="0 0 0"/><worldbody><body name="disc">
  <joint name="axle" axis="0 0 1"/>
  <inertial pos="0 0 0" mass="1" diaginertia="{INERTIA} {INERTIA} {INERTIA}"/></body></worldbody>
  <actuator><motor name="motor" joint="axle"/></actuator>
</mujoco>
"""


def turned(seed: int, late: float, dry: float) -> Recording:
    """Return 3 s of a disc with viscous and dry friction, by Euler steps of 0.1 ms."""
    rng = np.random.default_rng(seed)
    torques = np.repeat(rng.uniform(-0.2, 0.2, 10), 60)
    place, speed, read = 0.0, 0.0, []
    for torque in torques:
        read.append(place + NOISE * rng.normal())
        for _ in range(50):
            speed += 1e-4 * (torque - FRICTION * speed - dry * math.tanh(speed / 0.01)) / INERTIA
            place += 1e-4 * speed
    time = 0.005 * np.arange(len(torques))
    return Recording(
        name=f"run_{seed}",
        channels={
            "axle.position": Channel(time=time + late, value=np.array(read)),
            "motor.command": Channel(time=time, value=torques, hold=True),
        },
    )


def found(folder: Path, late: float, dry: float) -> tuple[Finalist, Finalist]:
    """Return viscous friction refitted, which lacks the dry one, and what is said of sensors."""
    path = folder / "disc.xml"
    path.write_text(DISC)
    robot = load(path)
    runs = [episode(turned(seed, late, dry), robot, 0.0025) for seed in range(4)]
    task = EffectSelection(
        nominal=Hypothesis(robot=robot, step=0.0025, knobs=()),
        episodes=runs,
        known=(),
        validation=Validation.of(runs),
        prior=Prior(alone={}),
        deadline=NEVER,
    )
    viscous = replace(task.nominal, effects=(ViscousFriction(joint="axle", b=FRICTION),))
    base = to_rollouts(task, task.refitted(viscous, viscous.start))
    return base, with_sensors(task, base)


def test_a_late_sensor_is_found_by_rollouts_though_friction_is_missing(tmp_path: Path) -> None:
    base, best = found(tmp_path, LATE, 0.01)
    late = [effect for effect in best.effects if isinstance(effect, TimestampOffset)]
    assert [each.T for each in late] == [pytest.approx(LATE, abs=0.004)]
    assert labels(best.effects) - labels(base.effects) == {"timestamp_offset@axle.position"}


def test_friction_that_is_missing_is_not_taken_for_a_sensor(tmp_path: Path) -> None:
    """A clock 1.4 ms early surely lowers the error, by .07 nats a stretch."""
    base, best = found(tmp_path, 0.0, 0.02)
    assert best is base
