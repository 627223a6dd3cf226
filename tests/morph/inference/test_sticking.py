"""Dry friction along a smoothed motion, against a wheel that a few lines integrate exactly."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.inference.columns import Columns
from morph.inference.observed import Observed, settled
from morph.inference.refit import refitted, seen
from morph.inference.sticking import sensed
from morph.model.episodes import episode
from morph.model.hypothesis import Hypothesis
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.record.recording import Channel, Recording
from tests.morph.inference.dry_wheel import posed

STEP, FINE, NOISE = 0.004, 32, 2e-4
INERTIA, LEVEL = 0.02, 0.3
WHEEL = f"""
<mujoco model="wheel">
  <option gravity="0 0 0"/>
  <worldbody>
    <body name="wheel">
      <joint name="hinge" axis="0 0 1"/>
      <inertial pos="0 0 0" mass="1" diaginertia="0.01 0.01 {INERTIA}"/>
    </body>
  </worldbody>
  <actuator><motor name="motor" joint="hinge"/></actuator>
</mujoco>
"""


@pytest.fixture
def wheel(tmp_path: Path) -> Robot:
    (tmp_path / "wheel.xml").write_text(WHEEL)
    return load(tmp_path / "wheel.xml")


def turned(torque: Array) -> Array:
    """Return the wheel's angle at each sample: soft thresholding of its velocity in fine steps."""
    angle, rate, angles = 0.0, 0.0, []
    for now in torque.tolist():
        angles.append(angle)
        for _ in range(FINE):
            rate += STEP / FINE * now / INERTIA
            rate = np.sign(rate) * max(0.0, abs(rate) - STEP / FINE * LEVEL / INERTIA)
            angle += STEP / FINE * rate
    return np.array(angles)


def recorded(angle: Array, torque: Array) -> Recording:
    time = STEP * np.arange(len(angle))
    noise = NOISE * np.random.default_rng(0).normal(size=len(angle))
    return Recording(
        name="run",
        channels={
            "hinge.position": Channel(time=time, value=angle + noise),
            "motor.command": Channel(time=time, value=torque, hold=True),
        },
    )


def along(wheel: Robot, torque: Array, *, rounds: int) -> tuple[Observed, Observed]:
    """Return a run smoothed without friction, and with it."""
    run = [episode(recorded(turned(torque), torque), wheel, STEP)]
    nominal = Hypothesis(robot=wheel, step=STEP, knobs=())
    rubbed = replace(nominal, effects=(CoulombFriction(joint="hinge", c=LEVEL),))
    (before,) = seen(nominal, nominal.start, run)
    found = before
    for _ in range(rounds):
        found = settled(*seen(rubbed, rubbed.start, run, [found]))
    return before, found


def missing(found: Observed) -> float:
    """Return the force that the model and its friction lack, RMS over the friction's level."""
    return float(np.std(found.about.force) / LEVEL)


def test_friction_holds_a_resting_joint_by_the_force_that_drives_it(wheel: Robot) -> None:
    torque = np.full(500, 0.4 * LEVEL)
    _, found = along(wheel, torque, rounds=3)
    senses = found.motion.sign("hinge")
    # Friction is minus its level times its sense: 0.4 of it holds the wheel against the torque.
    assert np.median(senses[50:-50]) == pytest.approx(0.4, abs=0.02)
    assert np.abs(senses[50:-50]).max() < 1.0


def test_friction_opposes_a_joint_that_slips(wheel: Robot) -> None:
    torque = np.full(500, 1.5 * LEVEL)
    _, found = along(wheel, torque, rounds=3)
    assert np.all(found.motion.sign("hinge")[50:] == 1.0)


@pytest.mark.parametrize("period", [0.7, 2.0])
def test_a_joint_that_sticks_and_slips_lacks_no_force(wheel: Robot, period: float) -> None:
    # From 0 to 2.5 times the friction: each reversal is a stop for a tenth of the period or more.
    time = STEP * np.arange(1500)
    torque = 2.5 * LEVEL * np.sin(2.0 * np.pi * time / period) * np.sin(0.5 * time)
    before, found = along(wheel, torque, rounds=3)
    assert missing(before) > 0.5
    assert missing(found) < 0.05 * missing(before)
    # The wheel stands still where soft thresholding of its velocity holds it.
    still = np.abs(np.diff(turned(torque))) < 1e-12
    sticks = np.abs(found.motion.sign("hinge")) < 1.0
    assert np.mean(sticks == still) > 0.95


def test_a_joint_that_sticks_hides_no_force(wheel: Robot) -> None:
    # Dry friction holds the wheel for 3 s against 0.6 of it, then lets go.
    time = STEP * np.arange(1500)
    torque = LEVEL * np.where(time < 3.0, 0.6, 4.0) * np.sin(2.0 * time)
    held = CoulombFriction(joint="hinge", c=0.0)
    run = [episode(recorded(turned(torque), torque), wheel, STEP)]
    nominal = Hypothesis(robot=wheel, step=STEP, knobs=(), effects=(held,))
    found = refitted(nominal, np.array([0.7 * LEVEL]), run, rounds=3)
    # The torque changes by 3 % of the friction in a step, and so does what a step may hide.
    assert found.point[0] == pytest.approx(LEVEL, rel=0.05)


def test_at_first_sight_the_missing_force_holds_a_joint(wheel: Robot) -> None:
    time = STEP * np.arange(1500)
    torque = 2.5 * LEVEL * np.sin(np.pi * time) * np.sin(0.5 * time)
    before, _ = along(wheel, torque, rounds=0)
    senses = sensed(["hinge"], before.motion, before.about).sign("hinge")
    angle = turned(torque)
    still, moves = (np.abs(np.diff(angle)) < 1e-12), np.abs(np.diff(angle)) > 0.5 * STEP
    # Friction balances the torque where the wheel rests, and opposes it where it moves.
    assert np.median(np.abs(senses - torque[:-1] / LEVEL)[still]) < 0.15
    assert np.all(senses[moves] == np.sign(np.diff(angle))[moves])


def test_more_friction_is_not_felt_where_it_holds(wheel: Robot) -> None:
    time = STEP * np.arange(1500)
    _, found = along(wheel, 2.5 * LEVEL * np.sin(np.pi * time) * np.sin(0.5 * time), rounds=2)
    nominal = Hypothesis(robot=wheel, step=STEP, knobs=())
    rubbed = replace(nominal, effects=(CoulombFriction(joint="hinge", c=LEVEL),))
    moved, _ = Columns.of(rubbed, rubbed.start).along(found)
    senses = found.motion.sign("hinge")
    sticks = np.abs(senses) < 1.0
    assert np.all(moved[sticks, 0, 1] == 0.0)
    # Elsewhere it turns the wheel by one over its inertia, but where it has only just come loose.
    felt = moved[~sticks, 0, 1] * -senses[~sticks] * INERTIA
    assert np.mean(np.abs(felt - 1.0) < 1e-6) > 0.99


def test_a_refit_that_misses_force_begins_again_from_little_of_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    task, begun = posed(tmp_path, 0.0), []

    def share(run: Observed) -> float:
        return float((run.about.disturbance.scale / run.about.inertial)[0])

    def noted(*given: Any) -> Any:
        begun.extend(share(run) for run in (given[3] if len(given) > 3 else ()))
        return seen(*given)

    monkeypatch.setattr("morph.inference.refit.seen", noted)
    found = refitted(task.nominal, task.nominal.start, task.episodes)
    missed = [share(run) for run in found.runs]
    # Without friction most of the force is missing, and where it is held little explains nothing.
    assert min(missed) > 0.05
    assert min(begun) == pytest.approx(0.01 * min(missed), rel=0.2)
