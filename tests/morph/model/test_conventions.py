"""Signs and units of readings, against simulated robots of which they are known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.robot import Robot
from morph.errors import DiagnosisError
from morph.model.conventions import check_signs, check_units
from morph.model.episodes import episode
from morph.model.measurement import Measurement
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.physics.joint.viscous_friction import ViscousFriction
from morph.record.recording import Channel, Recording

Recorded = Callable[..., Recording]
BRICK = """
<mujoco model="brick"><worldbody><body name="brick"><freejoint name="free"/>
  <inertial pos="0 0 0" mass="1" diaginertia="0.01 0.01 0.01"/></body></worldbody></mujoco>
"""


@pytest.mark.parametrize(
    "wrong", ["shoulder.position", "elbow.position", "elbow_motor.command", ""]
)
def test_an_encoder_that_counts_the_wrong_way_is_refused_and_no_other(
    arm: Callable[..., Robot], recorded: Recorded, wrong: str
) -> None:
    robot = arm()
    run = recorded(robot, start={"shoulder": 0.7}, command=lambda t: 2.0 * np.sin(3.0 * t))
    channels = {
        name: replace(each, value=-each.value) if name == wrong else each
        for name, each in run.channels.items()
    }
    runs = [episode(replace(run, channels=channels), robot, 0.004)]
    if not wrong.endswith("position"):
        check_signs(runs, robot)  # A motor that turns the other way is a finding.
        return
    with pytest.raises(DiagnosisError, match=f"the sign of {wrong} is wrong") as caught:
        check_signs(runs, robot)
    assert "scale = -1" in caught.value.fix


def test_a_body_that_falls_alone_has_no_sign_to_turn(body: Callable[[str], Robot]) -> None:
    robot, time = body(BRICK), np.linspace(0.0, 1.0, 201)
    measurement = Measurement.of(robot)
    channels = dict.fromkeys(measurement.needed, 0.0 * time)
    channels[measurement.recorded[2]] = -4.905 * time**2
    channels[measurement.quaternions[0][0]] = 1.0 + 0.0 * time
    run = Recording(
        name="falls", channels={k: Channel(time=time, value=v) for k, v in channels.items()}
    )
    check_signs([episode(run, robot, 0.005)], robot)


def in_degrees(run: Recording, name: str) -> Recording:
    """Return a run whose positions are in degrees."""
    channels = {
        channel: replace(each, value=np.degrees(each.value)) if "position" in channel else each
        for channel, each in run.channels.items()
    }
    return replace(run, channels=channels, name=name)


@pytest.mark.parametrize("driven", [True, False])
def test_the_run_whose_angles_are_in_degrees_is_named(
    arm: Callable[..., Robot], recorded: Recorded, driven: bool
) -> None:
    robot = arm()

    def command(time: Array) -> Array:
        return 3.0 * driven * np.sin(3.0 * time)

    # Friction that the description lacks is missing force in both units.
    rubs = CoulombFriction(joint="elbow", c=0.3)
    start = {"shoulder": 1.2, "elbow": -0.5}
    good = recorded(robot, rubs, start=start, command=command, name="good")
    runs = [episode(run, robot, 0.004) for run in (good, in_degrees(good, "bad"))]
    check_units(runs[:1], robot)
    with pytest.raises(DiagnosisError, match="angles are in degrees") as caught:
        check_units(runs, robot)
    assert caught.value.where == "recording bad"
    assert '"elbow.position" = { column = "elbow.position", unit = "deg" }' in caught.value.fix


def test_small_swings_without_a_drive_are_not_taken_for_degrees(
    arm: Callable[..., Robot], recorded: Recorded
) -> None:
    robot = arm()
    # Forces are linear in the angles: with these all fall by 57.
    rubs = ViscousFriction(joint="elbow", b=0.5)
    run = recorded(robot, rubs, start={"shoulder": 1.67, "elbow": -0.1}, noise=0.0)
    check_units([episode(run, robot, 0.004)], robot)
