"""A vehicle with two thrusters that floats freely."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.inference.diagnose import diagnose
from morph.inference.dictionary import dictionary
from morph.inference.observed import observed
from morph.model.diagnosis import Diagnosis
from morph.model.episodes import episode
from morph.physics.actuator.torque_saturation import TorqueSaturation
from morph.physics.body.payload import Payload
from morph.physics.effect import Effect
from morph.record.recording import Channel, Recording
from morph.sim.simulator import Simulator

VEHICLE = """<mujoco model="vehicle"><option gravity="0 0 0"/><worldbody>
  <body name="hull"><freejoint name="float"/>
    <geom type="box" size="0.3 0.2 0.1" mass="8"/>
    <site name="left" pos="-0.3 0.15 0"/><site name="right" pos="-0.3 -0.15 0"/></body></worldbody>
  <actuator><motor name="left" site="left" gear="2 0 0 0 0 0"/>
    <motor name="right" site="right" gear="2 0 0 0 0 0"/></actuator></mujoco>"""


@pytest.fixture(scope="module")
def vehicle(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    path = tmp_path_factory.mktemp("vehicle") / "vehicle.xml"
    path.write_text(VEHICLE)
    return load(path)


def run(vehicle: Robot, number: int, *effects: Effect) -> Recording:
    """Return 5 s, read at 50 Hz to 0.5 mm and 0.5 mrad."""
    rng = np.random.default_rng(number)

    def told(phase: Array) -> Callable[[Array], Array]:
        return lambda t: 2.0 * np.sin(1.5 * t + phase[0]) + 1.5 * np.sin(4.0 * t + phase[1])

    phases = rng.uniform(0.0, 2.0 * np.pi, (2, 2))
    found = Simulator(vehicle, effects=effects, step=0.001).run(
        seconds=5.0,
        command={"left": told(phases[0]), "right": told(phases[1])},
    )
    channels = {}
    for name, channel in found.channels.items():
        if channel.hold:
            channels[name] = channel
        elif ".position." in name or ".orientation." in name:
            value = channel.value[::20]
            size = 5e-4 if "position" in name else 2.5e-4
            noisy = value + rng.normal(0.0, size, len(value))
            channels[name] = Channel(time=channel.time[::20], value=noisy)
    return replace(found, channels=channels, name=f"run_{number}")


def diagnosed(vehicle: Robot, *effects: Effect) -> Diagnosis:
    return diagnose(vehicle, [run(vehicle, number, *effects) for number in range(3)])


def test_a_thruster_that_saturates_is_found(vehicle: Robot) -> None:
    found = diagnosed(vehicle, TorqueSaturation(actuator="left", limit=4.0))
    assert [each.effect.label for each in found.findings] == ["torque_saturation@left"]
    limit = found.findings[0].parameters["limit"]
    assert limit.value == pytest.approx(4.0, rel=0.05)
    assert limit.unit == "N"


def test_a_welded_link_has_no_laws_of_its_own(tmp_path: Path) -> None:
    path = tmp_path / "vehicle.xml"
    foam = '<body name="foam"><geom size="0.05" mass="0.5"/></body></body></worldbody>'
    path.write_text(VEHICLE.replace("</body></worldbody>", foam))
    robot = load(path)
    step = 0.004
    laid = episode(run(robot, 0), robot, step)
    seen = observed(spec_of(robot, timestep=step).compile(), robot, laid)
    links = {grid[0].where for grid in dictionary(robot, [seen], ()) if grid[0].kind == "body"}
    assert links == {"hull"}
    known = (Payload(body="foam"),)
    told = {grid[0].label for grid in dictionary(robot, [seen], known)}
    assert "payload@foam" in told


def test_nothing_is_said_of_a_vehicle_as_described(vehicle: Robot) -> None:
    assert diagnosed(vehicle).verdict == "consistent"
