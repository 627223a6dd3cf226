"""Where the floor is, and how it leans."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from morph.body.load import load
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.physics.world.ground import Ground
from morph.physics.world.ground_slope import GroundSlope
from morph.sim.simulator import Simulator


@pytest.fixture(scope="module")
def ball(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    path = tmp_path_factory.mktemp("ball") / "ball.xml"
    path.write_text(
        '<mujoco model="ball"><default><geom contype="4" conaffinity="0"/></default><worldbody>'
        '<body name="ball" pos="0 0 1"><freejoint/><geom size="0.05" mass="1"/></body>'
        "</worldbody></mujoco>"
    )
    return load(path)


@pytest.mark.parametrize("height", [-0.5, 0.0, 0.8])
def test_a_ball_comes_to_rest_on_the_floor_whatever_its_collision_mask(
    ball: Robot, height: float
) -> None:
    run = Simulator(ball, (Ground(height=height),)).run(seconds=2.0)
    # At rest (1 - d) g T^2 deep with T = 0.02 s, and d from 0.9 up: 0.39 mm at most.
    assert run["ball.position.z"][-1] == pytest.approx(height + 0.05, abs=0.4e-3)


@pytest.mark.parametrize(("roll", "pitch"), [(0.3, 0.0), (0.0, 0.3), (0.4, -0.2)])
def test_the_floor_leans_as_roll_and_then_pitch_turn_it(
    ball: Robot, roll: float, pitch: float
) -> None:
    model = Simulator(ball, (Ground(), GroundSlope(roll=roll, pitch=pitch))).model
    about_x = np.array(
        [
            [1.0, 0.0, 0.0],
            [0.0, math.cos(roll), -math.sin(roll)],
            [0.0, math.sin(roll), math.cos(roll)],
        ]
    )
    about_y = np.array(
        [
            [math.cos(pitch), 0.0, math.sin(pitch)],
            [0.0, 1.0, 0.0],
            [-math.sin(pitch), 0.0, math.cos(pitch)],
        ]
    )
    w, x, y, z = model.geom("floor").quat
    normal = [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]
    assert normal == pytest.approx((about_y @ about_x)[:, 2], abs=1e-12)


def test_the_way_down_is_towards_x_where_pitch_is_positive(ball: Robot) -> None:
    run = Simulator(ball, (Ground(), GroundSlope(pitch=0.2))).run(seconds=1.5)
    assert run["ball.position.x"][-1] > 0.1


def test_a_floor_of_the_description_is_moved_not_doubled(tmp_path: Path) -> None:
    path = tmp_path / "own.xml"
    path.write_text(
        '<mujoco><worldbody><geom name="floor" type="plane" size="0 0 1" pos="1 2 3"/>'
        '<body name="a" pos="0 0 9"><freejoint/><geom size="0.1" mass="1"/></body>'
        "</worldbody></mujoco>"
    )
    robot = load(path)
    untouched, moved = spec_of(robot), spec_of(robot)
    Ground(height=-1000.0).edit(untouched)
    Ground(height=5.0).edit(moved)
    assert list(untouched.geom("floor").pos) == [1.0, 2.0, 3.0]
    assert list(moved.geom("floor").pos) == [1.0, 2.0, 5.0]
    assert len(moved.geoms) == 2
