"""How servos sit that are drawn as boxes."""

from __future__ import annotations

import numpy as np
import pytest

from morph.body.load import load
from morph.fabrication.drawing import drawing
from morph.fabrication.off_the_shelf_parts import Item, items


def seats(name: str) -> dict[str, Item]:
    found, _ = items(drawing(load(name)))
    return {item.entry.joint: item for item in found if item.seated is not None}


def test_a_servo_of_the_printed_quadruped_looks_up_with_its_axis_on_the_hip() -> None:
    item = seats("quadruped_printed")["front_left_hip"]
    assert item.seated is not None
    pose = item.seated.pose
    # Its box is 22.5 mm high about z = -3.15 mm; the hip is at (35, 35) mm, and the box's
    # middle nearer to the robot's: its far end points inward.
    assert pose[:3, 3] == pytest.approx([35.0, 35.0, -3.15 + 11.25], abs=1e-6)
    assert pose[:3, 2] == pytest.approx([0.0, 0.0, 1.0], abs=1e-6)
    assert pose[:3, 0] == pytest.approx([-np.sqrt(0.5), -np.sqrt(0.5), 0.0], abs=1e-6)


@pytest.mark.parametrize("name", ["so101", "quadruped_printed"])
def test_every_servo_of_a_body_that_was_designed_is_on_its_joint(name: str) -> None:
    body = drawing(load(name))
    for joint, item in seats(name).items():
        assert item.seated is not None
        assert item.seated.fits, joint
        at = body.model.joint(joint).id
        pose = body.world(item.entry.link) @ item.seated.pose
        assert np.linalg.det(pose[:3, :3]) == pytest.approx(1.0)
        assert abs(float(pose[:3, 2] @ body.data.xaxis[at])) == pytest.approx(1.0, abs=1e-6)
        away = pose[:3, 3] - 1e3 * body.data.xanchor[at]
        assert np.linalg.norm(np.cross(away, body.data.xaxis[at])) < 1e-6, joint


def test_a_horn_is_on_the_joints_axis_even_where_the_servo_is_drawn_beside_it() -> None:
    body = drawing(load("humanoid"))
    for joint, item in seats("humanoid").items():
        assert item.seated is not None
        assert not item.seated.fits, joint
        at = body.model.joint(joint).id
        horn = body.world(item.entry.link) @ item.seated.horn
        away = horn[:3, 3] - 1e3 * body.data.xanchor[at]
        assert np.linalg.norm(np.cross(away, body.data.xaxis[at])) < 1e-6, joint
        assert abs(float(horn[:3, 2] @ body.data.xaxis[at])) == pytest.approx(1.0)


def test_left_and_right_servos_of_the_humanoids_hips_are_mirrored() -> None:
    body, found = drawing(load("humanoid")), seats("humanoid")
    left, right = (found[f"{side}_hip_z"] for side in "lr")
    assert left.seated is not None
    assert right.seated is not None
    here = body.world("left_hip") @ left.seated.pose
    there = body.world("right_hip") @ right.seated.pose
    # A servo is like its own mirror image, so its y is turned back.
    mirrored = np.diag([1.0, -1.0, 1.0, 1.0]) @ here @ np.diag([1.0, -1.0, 1.0, 1.0])
    assert mirrored == pytest.approx(there, abs=1e-9)
