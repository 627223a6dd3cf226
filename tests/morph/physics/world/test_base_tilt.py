from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from morph.body.load import load
from morph.physics.world.base_tilt import BaseTilt
from morph.sim.simulator import Simulator

POLE = """<mujoco model="pole">
  <compiler angle="radian" inertiafromgeom="false"/>
  <worldbody>
    <body name="first">
      <inertial pos="0 0 -0.5" mass="1" diaginertia="0.01 0.01 0.01"/>
      <joint name="about_y" axis="0 1 0"/>
    </body>
    <body name="second" pos="3 0 0">
      <inertial pos="0 0 -0.5" mass="1" diaginertia="0.01 0.01 0.01"/>
      <joint name="about_x" axis="1 0 0"/>
    </body>
  </worldbody>
</mujoco>"""


@pytest.mark.parametrize(
    ("roll", "pitch"), [(0.3, 0.0), (0.0, 0.4), (-0.2, -0.5), (0.25, 0.1), (0.0, 0.0)]
)
def test_a_plumb_hangs_where_the_lean_of_its_base_puts_it(
    tmp_path: Path, roll: float, pitch: float
) -> None:
    path = tmp_path / "pole.xml"
    path.write_text(POLE)
    # A spirit level on the base: turned by roll about x and then by pitch about y, up is this.
    up = np.array([np.sin(pitch) * np.cos(roll), -np.sin(roll), np.cos(pitch) * np.cos(roll)])
    # Seen from the base down is R' (0, 0, -1): the last row of R = Ry Rx, with a minus.
    down = -np.array([-np.sin(pitch), np.cos(pitch) * np.sin(roll), up[2]])
    # Ry(q) (0, 0, -1) = (-sin q, 0, -cos q), and Rx(q) (0, 0, -1) = (0, sin q, -cos q).
    rest = {
        "about_y": float(np.arctan2(-down[0], -down[2])),
        "about_x": float(np.arctan2(down[1], -down[2])),
    }
    simulator = Simulator(load(path), (BaseTilt(roll=roll, pitch=pitch),))
    run = simulator.run(seconds=1.0, start=rest)
    for joint, angle in rest.items():
        # Roundoff of gravity's 9.81 m/s2 for 1 s, grown by a swing of 4 rad/s.
        assert np.abs(run[f"{joint}.position"] - angle).max() < 1e-13
    # A bolted base that sinks towards +x lets its plumb hang towards +x.
    assert np.sign(down[0]) == np.sign(pitch)
    assert np.linalg.norm(simulator.model.opt.gravity) == pytest.approx(9.81, rel=1e-15)
