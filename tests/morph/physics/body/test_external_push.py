from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.model.corrected import split
from morph.physics.body.external_push import ExternalPush
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.physics.motion import Motion
from morph.sim.simulator import Simulator

BRICK = """<mujoco model="brick">
  <compiler angle="radian" inertiafromgeom="false"/>
  <option gravity="0 0 0"/>
  <worldbody>
    <body name="brick" quat="0.8 0.2 0.4 0.4">
      <freejoint/>
      <inertial pos="0.1 0.2 0.3" mass="2" diaginertia="0.1 0.2 0.15"/>
    </body>
  </worldbody>
</mujoco>"""

IMPULSE = np.array([0.3, -0.7, 0.4])


@pytest.fixture
def brick(tmp_path: Path) -> Robot:
    path = tmp_path / "brick.xml"
    path.write_text(BRICK)
    return load(path)


# Edges that fall between steps, on steps, within one step, and an end before the start.
@pytest.mark.parametrize(
    ("start", "end"), [(0.1013, 0.2027), (0.1, 0.2), (0.1003, 0.1011), (0.15, 0.1)]
)
def test_a_push_adds_its_impulse_evenly_and_turns_nothing(
    brick: Robot, start: float, end: float
) -> None:
    push = ExternalPush(
        body="brick", start=start, end=end, x=IMPULSE[0], y=IMPULSE[1], z=IMPULSE[2]
    )
    run = Simulator(brick, (push,), step=0.002).run(seconds=0.3)
    time = run.channel("brick.linear_velocity.x").time
    # One that is shorter than a step is spread over a step.
    share = np.clip((time - start) / (max(end, start + 0.002) - start), 0.0, 1.0)
    for axis, impulse in zip("xyz", IMPULSE, strict=True):
        # The frame moves as the centre of mass, for nothing turns: roundoff of 150 steps.
        got = run[f"brick.linear_velocity.{axis}"]
        assert got == pytest.approx(impulse / 2.0 * share, abs=1e-13)
        assert np.abs(run[f"brick.angular_velocity.{axis}"]).max() < 1e-13


def test_two_pushes_on_one_link_add_up(brick: Robot) -> None:
    pushes = tuple(ExternalPush(body="brick", end=0.1, x=x) for x in (0.2, -0.5))
    run = Simulator(brick, pushes).run(seconds=0.2)
    assert run["brick.linear_velocity.x"][-1] == pytest.approx(-0.15, abs=1e-13)


def moving(missing: Array) -> Motion:
    """Return a motion of which only the missing force matters, at 250 Hz."""
    none = np.zeros((len(missing), 0))
    return Motion(
        position=none,
        velocity=none,
        acceleration=none,
        drive=none,
        drive_rate=none,
        stiffness=none,
        joints={},
        actuators={},
        time=0.004 * np.arange(len(missing)),
        run="second",
        missing=missing,
    )


def test_a_push_is_looked_for_where_one_missing_force_stands_out() -> None:
    noise = np.random.default_rng(0).normal(size=(1500, 2))
    noise[:, 0] += 5.0 * np.sin(np.arange(1500) * 0.004)
    push = ExternalPush(body="brick")
    assert push.shapes(moving(noise)) == ()
    noise[700:730, 1] += 20.0
    shapes = push.shapes(moving(noise))
    assert {shape.run for shape in shapes} == {"second"}
    # From 2.8 to 2.92 s, known to a sample or two: pushes before, in and after it, short and long.
    assert [0.5 * (s.start + s.end) for s in shapes] == pytest.approx(
        [2.8, 2.8, 2.86, 2.86, 2.92, 2.92], abs=0.01
    )
    assert [s.end - s.start for s in shapes] == pytest.approx([0.072, 0.144] * 3, abs=0.02)
    assert push.shapes(moving(noise[680:])) == ()
    # Twice the same is no event.
    noise[1100:1130, 1] += 20.0
    assert push.shapes(moving(noise)) == ()


def test_a_push_of_one_run_is_no_part_of_a_robot(brick: Robot) -> None:
    push = ExternalPush(body="brick", run="second", end=0.1, x=0.2)
    run = Simulator(brick, (push,)).run(seconds=0.2)
    assert np.abs(run["brick.linear_velocity.x"]).max() == 0.0
    beside, _ = split(spec_of(brick), [push, ExternalPush(body="brick", end=0.1, x=0.2)])
    assert [effect.run for effect in beside if isinstance(effect, ExternalPush)] == [""]


def test_a_push_of_a_part_of_a_run_is_told_in_times_of_the_whole() -> None:
    push = ExternalPush(body="arm", run="r1 from 30 s", start=1.0, end=1.2, y=0.3)
    assert push.within("r1", 30.0) == ExternalPush(
        body="arm", run="r1", start=31.0, end=31.2, y=0.3
    )


def test_a_run_has_one_push_and_two_runs_have_two() -> None:
    push = ExternalPush(body="arm", run="r1", y=0.3)
    assert not push.beside(ExternalPush(body="hand", run="r1", z=0.1))
    assert push.beside(ExternalPush(body="hand", run="r2", z=0.1))
    assert push.beside(CoulombFriction(joint="hinge", c=0.1))
