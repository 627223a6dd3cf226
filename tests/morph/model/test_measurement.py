"""What is read of links that move freely, against rotations in closed form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from morph.body.load import load
from morph.body.robot import Robot
from morph.errors import DiagnosisError
from morph.model.episodes import episode
from morph.model.measurement import Measurement, deviation
from morph.model.pieces import part
from morph.record.quantities import WXYZ, XYZ
from morph.record.recording import Channel, Recording


@pytest.fixture
def floating() -> Robot:
    """A body that moves freely."""
    return load("hexapod_swimmer")


def wxyz(turn: Rotation) -> np.ndarray:
    return np.roll(turn.as_quat(), 1, axis=-1)


def test_a_joint_has_one_channel_and_a_free_one_six(floating: Robot) -> None:
    found = Measurement.of(floating)
    (free,) = [joint for joint in floating.joints if joint.kind == "free"]
    assert found.channels[:6] == (
        *(f"{free.link}.position.{axis}" for axis in XYZ),
        *(f"{free.link}.rotation.{axis}" for axis in XYZ),
    )
    assert found.units[:6] == ("m",) * 3 + ("rad",) * 3
    assert len(found.channels) == len(floating.joints) + 5 == found.coordinates.dofs
    assert found.needed[-4:] == tuple(f"{free.link}.orientation.{axis}" for axis in WXYZ)


def test_a_ball_joint_is_read_by_its_own_orientation(floating: Robot) -> None:
    *others, last = floating.joints
    ball = replace(last, kind="ball", name="shoulder")
    found = Measurement.of(replace(floating, joints=(*others, ball)))
    assert found.needed[-4:] == tuple(f"shoulder.orientation.{axis}" for axis in WXYZ)
    assert found.channels[-3:] == tuple(f"shoulder.rotation.{axis}" for axis in "xyz")
    assert found.units[-3:] == ("rad",) * 3
    assert found.coordinates.balls[-1][1] == found.coordinates.dofs - 3


def test_a_ball_joint_that_is_named_as_a_link_is_refused(floating: Robot) -> None:
    ball = replace(floating.joints[-1], kind="ball", name=floating.links[0].name)
    with pytest.raises(DiagnosisError, match="and a link have one name"):
        Measurement.of(replace(floating, joints=(*floating.joints[:-1], ball)))


def test_a_steady_spin_has_its_rate_in_the_body_s_axes_whatever_signs_were_logged(
    floating: Robot,
) -> None:
    found, rng = Measurement.of(floating), np.random.default_rng(0)
    spin, time = np.array([0.3, -0.4, 1.2]), np.linspace(0.0, 2.0, 201)
    turn = Rotation.from_rotvec([0.2, 0.1, -0.3]) * Rotation.from_rotvec(time[:, None] * spin)
    quaternion = wxyz(turn)
    signs = rng.choice([-1.0, 1.0], (201, 1))
    values = {name: np.zeros(201) for name in found.recorded}
    values |= dict(zip(found.quaternions[0], (signs * quaternion).T, strict=True))
    channels = {name: Channel(time=time, value=each) for name, each in values.items()}
    tracks = found.tracks(Recording(name="spin", channels=channels))
    value = np.stack([track.value for track in tracks], axis=1)
    slope = np.gradient(value, time, axis=0)
    position, velocity, _ = found.motion(value, slope, np.gradient(slope, time, axis=0))
    ((at, dof),) = found.coordinates.balls
    # Central differences err by (w h)^2 / 24 of w = 1.3 rad/s over 0.01 s: 7e-6.
    assert velocity[1:-1, dof : dof + 3] == pytest.approx(np.tile(spin, (199, 1)), abs=1e-4)
    same = np.abs(np.sum(position[:, at : at + 4] * quaternion, axis=1))
    assert same == pytest.approx(np.ones(201), abs=1e-12)


@pytest.mark.parametrize("bad", [[60], [60, 62], [30, 60, 90]])
def test_readings_far_off_turn_no_sign_of_those_after_them(floating: Robot, bad: list[int]) -> None:
    # A heading about pi that was averaged over its wrap: at some readings of 120 it is about 0.
    found, time, rng = Measurement.of(floating), 0.2 * np.arange(120), np.random.default_rng(0)
    for _ in range(20):
        heading = np.pi + 0.05 * (time - time[60]) + 0.01 * rng.normal(size=120)
        heading[bad] = 0.05 * rng.normal(size=len(bad))
        quaternion = wxyz(Rotation.from_rotvec(heading[:, None] * np.array([0.0, 0.0, 1.0])))
        logged = rng.choice([-1.0, 1.0], (120, 1)) * quaternion
        values = {name: np.zeros(120) for name in found.recorded}
        values |= dict(zip(found.quaternions[0], logged.T, strict=True))
        channels = {name: Channel(time=time, value=each) for name, each in values.items()}
        turns = found.tracks(Recording(name="turn", channels=channels))[-4:]
        # The readings are dropped; what is left moves by half of 0.05 rad/s over at most 0.6 s
        # and of five standard deviations of 0.014 rad.
        assert not np.isin(time[bad], turns[0].time).any()
        steps = np.abs(np.diff(np.stack([turn.value for turn in turns], axis=1), axis=0))
        assert steps.max() < 0.05


def test_a_part_of_a_spin_has_the_orientations_of_its_readings(floating: Robot) -> None:
    found, time = Measurement.of(floating), np.linspace(0.0, 4.0, 401)
    quaternion = wxyz(Rotation.from_rotvec(time[:, None] * np.array([0.3, -0.4, 1.2])))
    values = {name: np.zeros(401) for name in found.recorded}
    values |= dict(zip(found.quaternions[0], quaternion.T, strict=True))
    values |= {f"{actuator.name}.command": np.zeros(401) for actuator in floating.actuators}
    channels = {name: Channel(time=time, value=each) for name, each in values.items()}
    whole = episode(Recording(name="spin", channels=channels), floating, 0.01)
    half = part(whole, 2.0, 3.0)
    assert half.begin == 2.0
    assert half.time == pytest.approx(np.linspace(0.0, 0.99, 100), abs=1e-9)
    assert half.attitude == pytest.approx(whole.attitude[200:300], abs=1e-12)
    assert len(half.command) == len(half.unsure) == 101


def test_a_rotation_is_read_from_the_measured_orientation_along_the_world_s_axes() -> None:
    rng = np.random.default_rng(1)
    vectors = rng.uniform(-1.0, 1.0, (2, 7, 3))
    measured, error = Rotation.from_rotvec(vectors[0]), vectors[1]
    there = Rotation.from_rotvec(error) * measured
    assert deviation(wxyz(there), wxyz(measured)) == pytest.approx(error, abs=1e-12)
