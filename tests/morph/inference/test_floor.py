"""A puck that slides to rest on a floor, by Coulomb's law alone, without MuJoCo or morph."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.inference.contact import at_stops, touches
from morph.inference.diagnose import diagnose
from morph.model.episodes import episode
from morph.model.hypothesis import Hypothesis
from morph.physics.body.com_offset import ComOffset
from morph.record.recording import Channel, Recording
from morph.sim.simulator import Simulator

HALF, GRAVITY, FRICTION = 0.03, 9.81, 0.26
"""Half of the puck's height, m; m/s2; its sliding friction."""
RATE, SECONDS = 200.0, 0.8


def description(height: float = 0.0, friction: float = 1.0) -> str:
    """Return the puck and a floor at a height, m."""
    return f"""
<mujoco model="puck"><option cone="elliptic"/><default><geom friction="{friction} 0 0"/></default>
 <worldbody><geom name="floor" type="plane" size="0 0 1" pos="0 0 {height}"/>
 <body name="puck"><freejoint/><inertial pos="0 0 0" mass="0.2" diaginertia="4e-4 4e-4 8e-4"/>
 <geom type="box" size="0.1 0.1 {HALF}"/></body></worldbody></mujoco>
"""


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    path: Path = tmp_path_factory.mktemp("puck") / "puck.xml"
    path.write_text(description())
    return load(path)


def slid(number: int) -> Recording:
    """Return a run in which the puck is pushed off and comes to rest, flat and without turning."""
    rng, time = np.random.default_rng(number), np.arange(0.0, SECONDS, 1.0 / RATE)
    speed, heading = rng.uniform(0.8, 1.8), rng.uniform(0.0, 2.0 * np.pi)
    braked = FRICTION * GRAVITY
    moving = np.minimum(time, speed / braked)
    path = speed * moving - 0.5 * braked * moving**2
    places = {"x": path * np.cos(heading), "y": path * np.sin(heading), "z": HALF + 0.0 * time}
    turned = {"w": 1.0 + 0.0 * time, **dict.fromkeys("xyz", 0.0 * time)}

    def read(value: Array) -> Channel:
        return Channel(time=time, value=value + 2e-4 * rng.normal(size=len(time)))

    channels = {f"puck.position.{axis}": read(value) for axis, value in places.items()}
    channels |= {f"puck.orientation.{axis}": read(value) for axis, value in turned.items()}
    return Recording(name=f"push_{number}", channels=channels)


def test_friction_of_the_floor_is_named_from_how_a_puck_slides(robot: Robot) -> None:
    found = diagnose(
        robot, [slid(number) for number in range(6)], held_out=[slid(6), slid(7)], horizon=0.6
    )
    (finding,) = found.findings
    assert (finding.effect.name, finding.effect.where) == ("contact_friction", "any+floor")
    assert finding.probability > 0.5
    # A step of the search, a tenth, after it was narrowed 7 times by the power 0.7; in 0.8 s the
    # way to rest is read to 0.2 mm of 0.3 m.
    assert finding.parameters["mu"].value == pytest.approx(FRICTION, rel=0.06)
    errors = found.held_out_rmse
    assert errors["corrected"]["puck.position.x"] < 0.1 * errors["nominal"]["puck.position.x"]


def test_a_puck_that_slides_as_described_is_consistent(tmp_path: Path) -> None:
    path = tmp_path / "true.xml"
    path.write_text(description(friction=FRICTION))
    found = diagnose(
        load(path), [slid(number) for number in range(6)], held_out=[slid(6), slid(7)], horizon=0.6
    )
    assert (found.verdict, found.findings) == ("consistent", ())
    assert found.unexplained.contact


def test_models_of_one_fit_have_one_layout(robot: Robot) -> None:
    # Of a centre of mass at its origin MuJoCo has a shorter one, and batches take one alone.
    own = Hypothesis(robot=robot, step=0.002, knobs=())
    moved = own.adding(ComOffset(body="puck", x=0.01))
    for hypothesis in (own, moved):
        assert not hypothesis.at(hypothesis.start).model.body_simple[1:].any()


def test_contact_is_seen_where_shapes_touch_as_recorded(robot: Robot, tmp_path: Path) -> None:
    # A base that overlaps the link on it is no floor.
    base = '<geom type="box" size="9 9 0.2"/>'
    above = tmp_path / "base.xml"
    above.write_text(description(height=-0.5).replace("<worldbody>", "<worldbody>" + base))
    below = tmp_path / "below.xml"
    below.write_text(description(height=-0.5))
    run = [episode(slid(0), robot, 0.005)]
    assert touches(robot, run)
    assert not touches(load(below), run)
    assert not touches(load(above), run)


STOPPED = """<mujoco model="flap"><compiler angle="radian"/><worldbody>
 <body><joint name="hinge" axis="0 1 0" range="-0.4 0.4" limited="true" damping="0.02"/>
  <geom type="capsule" fromto="0 0 0 0 0 -0.2" size="0.02" mass="0.3"/></body></worldbody>
 <actuator><motor name="motor" joint="hinge" ctrlrange="-2 2"/></actuator></mujoco>"""


def pressed(robot: Robot, number: int, most: float) -> Recording:
    """Return 6 s under a sine of torque that presses a flap to its ends, or not, at 100 Hz."""
    rng = np.random.default_rng(number)
    hertz, phase = rng.uniform(0.2, 0.6), rng.uniform(0.0, 2.0 * np.pi)
    made = Simulator(robot, step=0.0005).run(
        seconds=6.0, command={"motor": lambda t: most * np.sin(2.0 * np.pi * hertz * t + phase)}
    )
    read = made.channel("hinge.position")
    value = read.value[::20] + 5e-4 * rng.normal(size=len(read.value[::20]))
    channels = {
        "hinge.position": Channel(time=read.time[::20], value=value),
        "motor.command": made.channel("motor.command"),
    }
    return Recording(name=f"run_{number}", channels=channels)


def test_described_ends_of_joints_are_not_missing_physics(tmp_path: Path) -> None:
    path = tmp_path / "flap.xml"
    path.write_text(STOPPED)
    flap = load(path)
    # Gravity holds with m g l sin(0.4) = 0.3 * 9.81 * 0.1 * 0.39 = 0.11 N m at the end.
    for most, there in ((0.5, True), (0.05, False)):
        runs = [pressed(flap, number, most) for number in range(4)]
        laid = [episode(run, flap, 0.004) for run in runs]
        assert at_stops(flap, laid) is there
        found = diagnose(flap, runs)
        assert (found.findings, found.verdict) == ((), "consistent")
        assert found.unexplained.contact is there
