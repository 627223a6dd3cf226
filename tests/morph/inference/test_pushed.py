"""A push in one of four runs of an arm that a few lines integrate."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.inference.rank import ranked
from morph.model.episodes import episode
from morph.model.hypothesis import Hypothesis
from morph.physics.actuator.torque_saturation import TorqueSaturation
from morph.physics.body.external_push import ExternalPush
from morph.physics.effect import Effect
from morph.record.recording import Channel, Recording

STEP, FINE, NOISE, SAMPLES = 0.004, 16, 2e-4, 1000
INERTIA, ARM = 0.02, 0.1
IMPULSE, FROM, UNTIL = 0.4, 2.0, 2.1
LIMIT = 0.2
"""N m: more than all runs command but for some tenths of a second of one."""
LEVEL_ARM = f"""
<mujoco model="arm">
  <option gravity="0 0 0"/>
  <worldbody>
    <body name="arm">
      <joint name="hinge" axis="0 0 1"/>
      <inertial pos="{ARM} 0 0" mass="1" diaginertia="0.01 0.01 {INERTIA - ARM**2}"/>
    </body>
  </worldbody>
  <actuator><motor name="motor" joint="hinge"/></actuator>
</mujoco>
"""


def turned(torque: Array, *, pushed: bool) -> Array:
    """Return the arm's angle at each sample, pushed along the world's y for a while or not."""
    angle, rate, angles = 0.0, 0.0, []
    for at, now in enumerate(torque.tolist()):
        angles.append(angle)
        for part in range(FINE):
            time = STEP * (at + part / FINE)
            force = IMPULSE / (UNTIL - FROM) if pushed and FROM <= time < UNTIL else 0.0
            slope = (now + force * ARM * np.cos(angle)) / INERTIA
            angle += STEP / FINE * (rate + 0.5 * STEP / FINE * slope)
            rate += STEP / FINE * slope
    return np.array(angles)


def found_in(folder: Path, *, pushed: str = "", weak: str = "") -> tuple[Effect, ...]:
    """Return what is found in four runs, one of them pushed, or one in which the motor is weak."""
    (folder / "arm.xml").write_text(LEVEL_ARM)
    robot = load(folder / "arm.xml")
    rng, time = np.random.default_rng(0), STEP * np.arange(SAMPLES)
    runs = []
    for name, rate in (("calm", 5.0), ("slow", 4.0), ("fast", 7.0), ("last", 6.0)):
        torque = 0.1 * np.cos(rate * time) + 0.05 * np.cos(11.0 * time)
        if name == weak:
            torque += 3.0 * LIMIT * np.exp(-(((time - FROM) / 0.1) ** 2))
        angle = turned(np.minimum(torque, LIMIT), pushed=name == pushed)
        channels = {
            "hinge.position": Channel(time=time, value=angle + NOISE * rng.normal(size=SAMPLES)),
            "motor.command": Channel(time=time, value=torque, hold=True),
        }
        runs.append(episode(Recording(name=name, channels=channels), robot, STEP))
    return ranked(Hypothesis(robot=robot, step=STEP, knobs=()), runs).best.effects


def test_a_limit_that_is_reached_once_is_no_push(tmp_path: Path) -> None:
    (limit,) = found_in(tmp_path, weak="last")
    assert isinstance(limit, TorqueSaturation)
    # A torque of 3 % more for 0.1 s turns the arm 0.003 rad in the next 0.2 s: 15 times the noise.
    assert limit.limit == pytest.approx(LIMIT, rel=0.01)


def test_a_push_is_found_in_its_run(tmp_path: Path) -> None:
    (push,) = found_in(tmp_path, pushed="last")
    assert isinstance(push, ExternalPush)
    assert push.run == "last"
    # Noise of 2e-4 rad in each of 25 readings during the push tells its ends to a sample or two.
    assert (push.start, push.end) == pytest.approx((FROM, UNTIL), abs=0.01)
    # They share the impulse: 1 % of it for each 1e-3 s.
    assert push.y == pytest.approx(IMPULSE, rel=0.05)


def test_no_refit_lets_a_push_end_before_it_starts(tmp_path: Path) -> None:
    (tmp_path / "arm.xml").write_text(LEVEL_ARM)
    push = ExternalPush(body="arm", run="last", start=1.0, end=1.2, y=0.1)
    model = Hypothesis(robot=load(tmp_path / "arm.xml"), step=STEP, knobs=(), effects=(push,))
    names = [known.name for known in push.free()]
    point = model.start.copy()
    point[[names.index("start"), names.index("end")]] = 1.3, 0.9
    (moved,) = model.effects_at(point)
    assert isinstance(moved, ExternalPush)
    assert (moved.start, moved.end) == pytest.approx((1.1, 1.1))
