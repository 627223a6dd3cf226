"""What of a robot water touches."""

from pathlib import Path

import numpy as np
import pytest

import morph
from morph.errors import RobotError
from morph.physics.fluid.wetted import every_shape, shapes_of

TWO = """
<mujoco model="two">
  <worldbody>
    <body name="carrier" pos="0 0 1">
      <freejoint/>
      <geom type="box" size="0.1 0.1 0.1" mass="1"/>
      <geom type="sphere" size="0.5" pos="0.3 0 0" contype="0" conaffinity="0" mass="0"/>
      <body name="fixed" pos="1 0 0" euler="0 0 90">
        <geom type="ellipsoid" size="0.3 0.2 0.1" pos="0.5 0 0" contype="0" conaffinity="0"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


@pytest.fixture
def two(tmp_path: Path) -> morph.body.robot.Robot:
    file = tmp_path / "two.xml"
    file.write_text(TWO)
    return morph.load(file)


def test_the_shapes_of_the_swimmer_displace_what_its_card_says() -> None:
    robot = morph.load("hexapod_swimmer")
    volume = sum(mesh.volume for meshes in every_shape(robot).values() for mesh in meshes)
    # Its hull, hips and paddles do not overlap; the card gives nine decimals.
    assert volume == pytest.approx(0.017043487, abs=5e-10)


def test_what_is_only_drawn_counts_where_nothing_collides(two: morph.body.robot.Robot) -> None:
    assert [len(shapes_of(two, link)) for link in ("carrier", "fixed")] == [1, 1]
    assert len(shapes_of(two, "carrier", drawn=True)[0].faces) == 1280


def test_a_link_without_a_joint_lies_in_the_frame_of_the_link_that_carries_it(
    two: morph.body.robot.Robot,
) -> None:
    box, ellipsoid = shapes_of(two, "carrier", rigid=True)
    # 0.5 m along the fixed link's x, which points along the carrier's y, 1 m ahead.
    assert np.allclose(ellipsoid.com, (1.0, 0.5, 0.0), atol=1e-9)
    # An icosahedron split three times has corners within half an edge, 3 %, of the poles.
    assert np.allclose(np.ptp(ellipsoid.vertices, axis=0), (0.4, 0.6, 0.2), rtol=0.03)
    assert box.volume == pytest.approx(0.008)
    assert shapes_of(two, "fixed", rigid=True) == ()


def test_a_link_that_is_not_there_is_named(two: morph.body.robot.Robot) -> None:
    with pytest.raises(RobotError, match="there is no link 'third'"):
        shapes_of(two, "third")
