"""A description that brings a plane of its own has one floor, not two."""

from __future__ import annotations

from pathlib import Path

import pytest

from morph.body.load import load
from morph.errors import EffectError
from morph.physics.contact.presets import surface
from morph.physics.world.ground import Ground
from morph.sim.simulator import Simulator

BOX = """<mujoco model="box">
  <worldbody>
    {planes}
    <body name="box" pos="0 0 0.06">
      <freejoint/>
      <geom name="box" type="box" size="0.05 0.05 0.05" mass="1"/>
    </body>
  </worldbody>
</mujoco>"""
PLANE = '<geom name="ground" type="plane" size="0 0 1"/>'


def written(folder: Path, planes: str) -> Path:
    path = folder / "box.xml"
    path.write_text(BOX.format(planes=planes))
    return path


def depth(folder: Path, planes: str) -> float:
    """Return how far a box sinks in that rests on its floor, m."""
    robot = load(written(folder, planes))
    run = Simulator(robot, surface("rubber_on_wood"), step=0.001).run(seconds=2.0)
    return float(0.05 - run["box.position.z"][-1])


@pytest.mark.parametrize("planes", [PLANE, PLANE.replace('name="ground"', "")])
def test_a_box_rests_as_deep_on_a_floor_of_its_description(tmp_path: Path, planes: str) -> None:
    # Some 0.1 to 0.25 mm: 9.81 N on 40 kN/m. Two floors in one place would bear it half as deep.
    ours = depth(tmp_path, "")
    assert ours > 1e-4
    assert abs(depth(tmp_path, planes) - ours) < 0.01 * ours


def test_of_two_planes_one_must_be_named(tmp_path: Path) -> None:
    robot = load(written(tmp_path, PLANE + PLANE.replace("ground", "shelf")))
    with pytest.raises(EffectError, match="2 planes, and none is named floor"):
        Simulator(robot, (Ground(),))
