"""A hinged arm with a propeller at its end: an actuator that drives no joint."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from morph.arrays import Array
from morph.body.load import load
from morph.inference.diagnose import diagnose
from morph.physics.actuator.dead_zone import DeadZone
from morph.record.recording import Recording

ARM = """<mujoco model="arm"><worldbody><body name="beam"><joint name="pivot" axis="0 1 0"/>
  <geom type="capsule" fromto="-0.1 0 0 0.4 0 0" size="0.01" mass="0.3"/>
  <site name="hub" pos="0.4 0 0" euler="0 90 0"/></body></worldbody>
  <actuator><motor name="propeller" site="hub" gear="-1 0 0 0 0 0"/></actuator></mujoco>"""


def test_the_dead_zone_of_a_propeller_is_found(
    tmp_path: Path, recorded: Callable[..., Recording]
) -> None:
    path = tmp_path / "arm.xml"
    path.write_text(ARM)
    robot = load(path)

    def told(k: int) -> Callable[[Array], Array]:
        return lambda t: 0.9 + 0.5 * np.sin((2.0 + k) * t) + 0.6 * np.sin(7.0 * t)

    hidden = DeadZone(actuator="propeller", threshold=0.25)
    runs = [recorded(robot, hidden, command=told(k), seed=k, name=f"r{k}") for k in range(3)]
    found = diagnose(robot, runs)
    assert [each.effect.label for each in found.findings] == ["dead_zone@propeller"]
    threshold = found.findings[0].parameters["threshold"]
    assert threshold.unit == "N"
    # Of 90 % intervals one in ten misses the truth: three times as wide it would be one in 1e6.
    assert abs(threshold.value - 0.25) < 3.0 * 0.5 * (threshold.high90 - threshold.low90) < 0.01
    # A quarter of a newton at 0.4 m on 0.013 kg m2 moves the beam by radians within 1 s.
    corrected, nominal = (found.held_out_rmse[kind] for kind in ("corrected", "nominal"))
    assert corrected["pivot.position"] < 0.1 * nominal["pivot.position"]
