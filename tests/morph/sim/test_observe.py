from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from morph.body.load import load
from morph.body.robot import Robot
from morph.physics.fluid.buoyancy import Buoyancy
from morph.physics.joint.stribeck_friction import StribeckFriction
from morph.record.load import load_recordings
from morph.record.write import write
from morph.sim.simulator import Simulator

STEP = 0.002

RIG = """<mujoco model="rig"><worldbody>
  <geom name="ground" type="plane" size="1 1 1"/>
  <body name="arm" pos="0 0 1"><joint name="shoulder" axis="0 1 0" damping="0.02"/>
    <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.02" mass="0.4"/>
    <site name="imu" pos="0.2 0 0" euler="10 20 30"/>
    <body name="hand" pos="0.3 0 0"><site name="wrist"/>
      <geom type="box" size="0.03 0.03 0.03" mass="0.2"/></body></body>
  <body name="ball" pos="1 0 0.5"><freejoint/><geom size="0.1" mass="0.5"/>
    <site name="core"/></body>
</worldbody><sensor><accelerometer name="felt" site="imu"/><gyro name="turned" site="imu"/>
  <touch name="other" site="wrist"/><force name="carried" site="wrist"/>
  <accelerometer name="thrown" site="core"/></sensor>
<actuator><motor name="shoulder" joint="shoulder"/></actuator></mujoco>"""


@pytest.fixture(scope="module")
def rig(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    path = tmp_path_factory.mktemp("rig") / "rig.xml"
    path.write_text(RIG)
    return load(path)


def test_a_thrown_body_flies_a_parabola() -> None:
    run = Simulator(load("hexapod_swimmer"), step=STEP).run(
        seconds=1.0, speed={"hull.linear_velocity.x": 2.0, "hull.linear_velocity.z": 3.0}
    )
    time = run.channel("hull.position.x").time
    # Each step moves by the speed at its end, so that it falls g h t / 2 further than a parabola.
    fallen = 0.5 * 9.81 * time * (time + STEP)
    assert run["hull.position.x"] == pytest.approx(2.0 * time, abs=1e-9)
    assert run["hull.position.z"] == pytest.approx(3.0 * time - fallen, abs=1e-9)
    assert run["hull.linear_velocity.z"] == pytest.approx(3.0 - 9.81 * time, abs=1e-9)


def test_orientation_and_angular_velocity_are_those_of_a_steady_turn(rig: Robot) -> None:
    run = Simulator(rig, step=STEP).run(seconds=0.2, speed={"ball.angular_velocity.y": 4.0})
    time = run.channel("ball.orientation.w").time
    assert run["ball.orientation.w"] == pytest.approx(np.cos(2.0 * time), abs=1e-9)
    assert run["ball.orientation.y"] == pytest.approx(np.sin(2.0 * time), abs=1e-9)
    assert run["ball.angular_velocity.y"] == pytest.approx(np.full(len(time), 4.0), abs=1e-9)


def test_sensors_read_what_the_engine_itself_reads_while_it_steps(rig: Robot) -> None:
    # The ball falls 0.4 m onto the ground within 0.29 s, so contacts are felt too.
    simulator = Simulator(rig, step=STEP)
    run = simulator.run(seconds=0.6, command={"shoulder": 0.7})
    data = mujoco.MjData(simulator.model)
    data.ctrl[0] = 0.7
    read = []
    for _ in range(300):
        mujoco.mj_step(simulator.model, data)
        read.append(data.sensordata.copy())
    due = np.array(read)
    for part, first in (("imu.accelerometer", 0), ("imu.gyro", 3), ("core.accelerometer", 10)):
        for at, axis in enumerate("xyz"):
            found = run[f"{part}.{axis}"][:300]
            # Accelerations to 1e3 m/s2 come from differences of 1e-16 m/s over 2 ms.
            assert found == pytest.approx(due[:, first + at], abs=1e-9), (part, axis)
    for at, axis in enumerate("xyz"):
        assert run[f"wrist.force.{axis}"] == pytest.approx(due[:, 7 + at], abs=1e-9)
    assert "wrist.touch" not in " ".join(run.channels)


def test_a_body_at_rest_feels_its_weight_and_one_that_falls_feels_nothing(rig: Robot) -> None:
    run = Simulator(rig, step=STEP).run(seconds=2.0)
    falling = run.channel("core.accelerometer.z").time < 0.25
    assert np.abs(run["core.accelerometer.z"][falling]).max() < 1e-9
    # It lies still after 2 s; what bounces on is below a thousandth of its weight.
    assert run["core.accelerometer.z"][-1] == pytest.approx(9.81, rel=1e-3)


def test_what_an_effect_does_before_each_step_is_felt(rig: Robot) -> None:
    # Friction of 5 N m holds the arm, which weighs 0.4 * 0.15 * 9.81 + 0.2 * 0.3 * 9.81 = 1.18 N m.
    held = StribeckFriction(joint="shoulder", c=5.0, s=5.0)
    run = Simulator(rig, effects=(held,), step=STEP).run(seconds=0.2)
    felt = np.array([run[f"imu.accelerometer.{axis}"][-1] for axis in "xyz"])
    # Creep of a soft constraint is slower than a thousandth of gravity.
    assert np.linalg.norm(felt) == pytest.approx(9.81, rel=1e-3)
    free = Simulator(rig, step=STEP).run(seconds=0.2)
    assert np.linalg.norm([free[f"imu.accelerometer.{axis}"][0] for axis in "xyz"]) < 9.0


def test_what_was_recorded_is_read_back_by_its_names(rig: Robot, tmp_path: Path) -> None:
    run = Simulator(rig, step=STEP).run(seconds=0.1, command={"shoulder": 0.1})
    (again,) = load_recordings(write(run, tmp_path / "run.npz"), robot=rig)
    assert set(again.channels) == set(run.channels)
    for name, channel in run.channels.items():
        assert np.array_equal(again[name], channel.value)
        assert np.array_equal(again.channel(name).time, channel.time)


def test_a_force_sensor_that_knows_no_fluid_is_left_out_in_one(rig: Robot) -> None:
    # MuJoCo would say that a hand which floats hangs from its wrist by all its weight.
    afloat = Buoyancy(body="hand", volume=2e-4)
    run = Simulator(rig, (afloat,), step=STEP).run(seconds=0.01)
    assert not any(name.startswith("wrist.force") for name in run.channels)
    assert "imu.accelerometer.x" in run.channels
    assert "wrist.force.z" in Simulator(rig, step=STEP).run(seconds=0.01).channels
