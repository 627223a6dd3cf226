from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from morph.body.load import load
from morph.physics.body.tether import Tether
from morph.sim.simulator import Simulator

FLOAT = """<mujoco model="float">
  <compiler angle="radian" inertiafromgeom="false"/>
  <option gravity="0 0 0"/>
  <worldbody>
    <body name="buoy" quat="0.5 0.5 0.5 0.5">
      <freejoint/>
      <inertial pos="0 0.2 0" mass="2" diaginertia="0.1 0.2 0.15"/>
    </body>
  </worldbody>
</mujoco>"""


def test_a_taut_cable_swings_its_load_in_and_lets_it_go_when_slack(tmp_path: Path) -> None:
    path = tmp_path / "float.xml"
    path.write_text(FLOAT)
    # The link's y is the world's z, so that its centre of mass is 0.2 m above its origin. It
    # begins 0.5 m beyond the cable's 1.5 m, along (2, 1, 2) / 3 from the anchor.
    along = np.array([2.0, 1.0, 2.0]) / 3.0
    anchor = np.array([0.4, -0.3, 0.1])
    origin = anchor + 2.0 * along - np.array([0.0, 0.0, 0.2])
    law = Tether(body="buoy", k=50.0, length=1.5, x=anchor[0], y=anchor[1], z=anchor[2], cy=0.2)
    start = {f"buoy.position.{axis}": float(x) for axis, x in zip("xyz", origin, strict=True)}
    start |= {f"buoy.orientation.{axis}": 0.5 for axis in "wxyz"}
    step = 0.001
    run = Simulator(load(path), (law,), step=step).run(seconds=0.6, start=start)
    time = run.channel("buoy.position.x").time
    moved = np.stack([run[f"buoy.position.{axis}"] for axis in "xyz"], axis=1) - origin
    # A quarter of a swing of sqrt(50 / 2) = 5 rad/s, then freely with 0.5 * 5 m/s.
    slack = 0.1 * np.pi
    due = np.where(time < slack, 0.5 * (1.0 - np.cos(5.0 * time)), 0.5 + 2.5 * (time - slack))
    # Half a step of 2.5 m/s for velocities that lag, and the step in which it becomes slack.
    assert moved @ along == pytest.approx(-due, abs=step * 2.5)
    across = moved - np.outer(moved @ along, along)
    assert np.abs(across).max() < 1e-12
