"""Effects on actuators that drive no joint, in closed form."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from morph.body.load import load
from morph.body.robot import Robot
from morph.errors import RobotError, SimulationFailed
from morph.physics.actuator.back_emf import BackEmf
from morph.physics.actuator.dead_zone import DeadZone
from morph.physics.actuator.speed_torque_limit import SpeedTorqueLimit
from morph.physics.actuator.thermal_derating import ThermalDerating
from morph.physics.actuator.torque_saturation import TorqueSaturation
from morph.physics.actuator.torque_scale import TorqueScale
from morph.physics.actuator.voltage_sag import VoltageSag
from morph.physics.effect import Effect
from morph.sim.simulator import Simulator

SLED = """<mujoco model="sled"><option gravity="0 0 0"/><worldbody>
  <body name="hull"><freejoint name="float"/><geom type="box" size="0.2 0.1 0.05" mass="4"/>
    <site name="stern" pos="-0.2 0 0"/><site name="bow" pos="0.2 0 0"/></body></worldbody>
  <actuator><motor name="back" site="stern" gear="0.5 0 0 0 0 0"%s/>
    <motor name="front" site="bow" gear="1 0 0 0 0 0"/></actuator></mujoco>"""


def sled(tmp_path: Path, limits: str = "") -> Robot:
    path = tmp_path / "sled.xml"
    path.write_text(SLED % limits)
    return load(path)


def travelled(robot: Robot, back: float, *effects: Effect) -> float:
    """Return how far the sled comes along its axis in 1 s from rest, the rear screw told so."""
    found = Simulator(robot, effects=effects, step=0.002).run(
        seconds=1.0,
        command={"back": lambda t: back + 0.0 * t, "front": lambda t: 2.0 + 0.0 * t},
    )
    return float(found["hull.position.x"][-1])


def test_its_actuators_are_said_to_act_on_sites(tmp_path: Path) -> None:
    robot = sled(tmp_path, ' forcerange="-3 5"')
    assert [each.part for each in robot.actuators] == ["site stern", "site bow"]
    assert [each.joint for each in robot.actuators] == [None, None]
    assert [each.limit for each in robot.actuators] == [2.5, None]
    assert [each.effort_unit for each in robot.actuators] == ["N", "N"]
    assert robot.driven == ()


@pytest.mark.parametrize(
    ("effect", "force"),
    [
        # Told 6 and 2 N, of the first of which the gear lets half act: 3 and 2 N.
        (DeadZone(actuator="back", threshold=0.7), 2.3 + 2.0),
        (TorqueSaturation(actuator="back", limit=1.9), 1.9 + 2.0),
        (TorqueScale(actuator="back", gain=0.7), 2.1 + 2.0),
        (VoltageSag(actuator="front", k=0.05), 5.0 / (1.0 + 0.05 * 5.0)),
    ],
    ids=lambda each: getattr(each, "name", ""),
)
def test_a_law_changes_what_a_thruster_pushes_with(
    tmp_path: Path, effect: Effect, force: float
) -> None:
    robot = sled(tmp_path)
    # At rest under a constant force every integrator's way is in proportion to it.
    ratio = travelled(robot, 6.0, effect) / travelled(robot, 6.0)
    assert ratio == pytest.approx(force / 5.0, rel=1e-9)


def test_a_law_acts_behind_the_limit_of_the_force(tmp_path: Path) -> None:
    free, limited = sled(tmp_path), sled(tmp_path, ' forcerange="-3 3"')
    lost = DeadZone(actuator="back", threshold=0.5)
    # The limit leaves 1.5 N of 3, and the dead zone 1 of these: as of half without a limit.
    assert travelled(limited, 6.0, lost) == pytest.approx(travelled(free, 3.0, lost), rel=1e-9)


def test_a_hot_thruster_ends_at_its_floor(tmp_path: Path) -> None:
    robot = sled(tmp_path)
    hot = ThermalDerating(actuator="back", floor=0.4, rate=1e3, level=3.0)
    # At 1000 /s it is hot after some steps of 2 ms: 0.4 of 3 N, the first steps more.
    ratio = travelled(robot, 6.0, hot) / travelled(robot, 6.0)
    assert ratio == pytest.approx((1.2 + 2.0) / 5.0, rel=0.01)


def test_laws_of_a_joint_s_speed_have_no_place_on_it(tmp_path: Path) -> None:
    robot = sled(tmp_path)
    assert not BackEmf.places(robot)
    assert not SpeedTorqueLimit.places(robot)
    with pytest.raises(SimulationFailed, match="there is no actuator 'back'"):
        travelled(robot, 6.0, BackEmf(actuator="back", k=0.1))


def test_a_servo_on_a_site_under_a_law_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "sled.xml"
    servo = '<position name="back" site="stern" refsite="bow" kp="3" gear="1 0 0 0 0 0"/>'
    text = (SLED % "").replace('<motor name="back" site="stern" gear="0.5 0 0 0 0 0"/>', servo)
    path.write_text(text)
    with pytest.raises(SimulationFailed, match="the torque of back follows from more"):
        travelled(load(path), 0.1, DeadZone(actuator="back", threshold=0.1))


def test_an_actuator_of_three_forces_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "ball.xml"
    path.write_text(
        '<mujoco><worldbody><body name="b"><joint name="j" type="ball"/><geom size="0.1"/></body>'
        '</worldbody><actuator><orientation name="o" joint="j" kp="1"/></actuator></mujoco>'
    )
    with pytest.raises(RobotError, match="the actuator 'o' turns an orientation by three forces"):
        load(path)


def test_way_is_what_newton_says(tmp_path: Path) -> None:
    # 5 N on 4 kg for 1 s: 0.625 m; a semi-implicit step of 2 ms is ahead by half a step, 0.2 %.
    assert travelled(sled(tmp_path), 6.0) == pytest.approx(0.625, rel=2.5e-3)
    assert np.isfinite(travelled(sled(tmp_path), -6.0))
