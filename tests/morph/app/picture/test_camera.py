from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pytest

from morph.app.picture.camera import ASPECT, AZIMUTH, ELEVATION, framing
from morph.arrays import Array

BALL = """<mujoco><worldbody><geom type="plane" size="0 0 1"/><body><freejoint/>
<geom type="box" size="0.1 0.2 0.05"/></body></worldbody></mujoco>"""


@pytest.fixture(scope="module")
def model() -> Any:
    return mujoco.MjModel.from_xml_string(BALL)


def flight(where: Array) -> Array:
    """Return a flight upright along places (pictures, 3)."""
    return np.concatenate([where, np.tile([1.0, 0.0, 0.0, 0.0], (len(where), 1))], axis=1)


def in_picture(model: Any, lookat: Array, distance: float, where: Array) -> tuple[float, float]:
    """Return the farthest corner of the box from the middle, as shares of half a picture."""
    azimuth, elevation = np.deg2rad(AZIMUTH), np.deg2rad(ELEVATION)
    forward = np.array(
        [
            np.cos(elevation) * np.cos(azimuth),
            np.cos(elevation) * np.sin(azimuth),
            np.sin(elevation),
        ]
    )
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    eye = lookat - distance * forward
    half = np.array([0.1, 0.2, 0.05])
    signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, 8).T
    seen = where + signs * half - eye
    depth = seen @ forward
    tangent = np.tan(np.deg2rad(0.5 * model.vis.global_.fovy))
    aside = np.abs(seen @ right) / depth / (tangent * ASPECT)
    above = np.abs(seen @ up) / depth / tangent
    return float(aside.max()), float(above.max())


@pytest.mark.parametrize(
    "far", [np.zeros(3), np.array([0.1, 0.2, 0.1]), np.array([50.0, 3.0, -9.0])]
)
def test_all_of_a_robot_is_in_every_picture_and_fills_it(model: Any, far: Array) -> None:
    where = np.linspace(0.0, 1.0, 90)[:, None] * far + np.array([1.0, 2.0, 3.0])
    look = framing(model, flight(where), 30.0)
    shares = [
        max(in_picture(model, look.lookat[at], look.distance, where[at]))
        for at in range(len(where))
    ]
    assert max(shares) < 1.0
    assert max(shares) > 0.5
    assert look.lowest == pytest.approx(where[:, 2].min() - 0.05)


def test_the_camera_follows_only_what_goes_far(model: Any) -> None:
    steps = np.linspace(0.0, 1.0, 90)[:, None]
    near = framing(model, flight(steps * [0.3, 0.0, 0.0]), 30.0)
    assert np.ptp(near.lookat, axis=0).max() == 0.0
    far = framing(model, flight(steps * [30.0, 0.0, 0.0]), 30.0)
    # At a steady speed there is nothing to smooth: the camera goes along exactly.
    assert far.lookat[:, 0] == pytest.approx(30.0 * steps[:, 0], abs=1e-9)


def test_a_shaken_robot_does_not_shake_the_camera(model: Any) -> None:
    time = np.arange(300) / 30.0
    where = np.stack([3.0 * time, 0.0 * time, 0.05 * np.sin(2 * np.pi * 3.0 * time)], axis=1)
    look = framing(model, flight(where), 30.0)
    # A Gaussian of 0.35 s passes e^(-(2 pi 3 0.35)^2 / 2) = 4e-10 of a shake at 3 Hz; that it
    # is cut off at three times its width, beyond which lies 0.27 % of it, passes 1.4e-4 m.
    assert np.abs(look.lookat[40:-40, 2]).max() < 1.4e-4


def test_what_does_not_move_at_all_is_framed(model: Any) -> None:
    look = framing(model, flight(np.zeros((1, 3))), 30.0)
    assert look.lookat.tolist() == [[0.0, 0.0, 0.0]]
    assert 0.2 < look.distance < 2.0
