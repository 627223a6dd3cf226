"""The force and the torque that a free link lacks, as arrows."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from morph.app.viewer.mismatch.arrows import scale_of, wrenches
from morph.app.viewer.mismatch.case import MismatchCase
from morph.app.viewer.mismatch.window import DESCRIBED, Ask
from morph.app.viewer.motion import RATE
from morph.body.load import load
from morph.sim.simulator import Simulator

SLED = """<mujoco model="sled"><option gravity="0 0 0"/><worldbody><body name="hull">
  <freejoint name="float"/><geom type="box" size="0.2 0.1 0.05" mass="4"/>
  <site name="bow" pos="0.2 0 0"/></body></worldbody>
  <actuator><motor name="screw" site="bow" gear="0 1 0 0 0 0"/></actuator></mujoco>"""


def test_what_a_free_link_lacks_is_an_arrow_of_force_and_one_of_torque(tmp_path: Path) -> None:
    path = tmp_path / "sled.xml"
    path.write_text(SLED)
    robot = load(path)
    # The screw gives 2 N across the bow, 0.2 m before the middle; the recording says none was told.
    run = Simulator(robot).run(seconds=4.0, command={"screw": 2.0})
    silent = replace(run.channel("screw.command"), value=np.zeros(len(run["screw.command"])))
    run = replace(run, channels={**run.channels, "screw.command": silent})
    case = MismatchCase(robot, (run,))
    take = case.take(Ask(horizon=None))
    scale = scale_of(case.figure, take)
    assert scale is not None
    arrows = wrenches(case.figure, take, DESCRIBED, scale)
    assert arrows.shape[1:] == (2, 2, 3)
    known = np.isfinite(arrows).all(axis=(1, 2, 3))
    force, torque = (arrows[known, :, 1] - arrows[known, :, 0]).transpose(1, 0, 2)
    # A second from the ends, where the filter of 3 Hz makes up a fortieth.
    inside = slice(int(RATE), -int(RATE))
    assert np.linalg.norm(force, axis=1)[inside] == pytest.approx(2.0 * scale.metres["N"], rel=0.05)
    assert torque[inside, 2] == pytest.approx(0.4 * scale.metres["N m"], rel=0.05)
    assert np.allclose(force[:, 2], 0.0, atol=1e-3 * scale.metres["N"])
