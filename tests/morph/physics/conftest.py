from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from morph.body.load import load
from morph.body.robot import Robot

MOTOR = '<motor name="axle" joint="axle"/>'

WHEEL = """<mujoco model="wheel">
  <compiler angle="radian" inertiafromgeom="false"/>
  <option gravity="0 0 0"/>
  <worldbody>
    <body name="rim">
      <inertial pos="0 0 0" mass="1" diaginertia="0.2 0.25 0.2"/>
      <joint name="axle" axis="0 1 0" {joint}/>
    </body>
    <body name="other">
      <inertial pos="0 0 0" mass="1" diaginertia="0.2 0.25 0.2"/>
      <joint name="second" axis="0 1 0"/>
    </body>
  </worldbody>
  <actuator>{actuator}<motor name="second" joint="second"/></actuator>
</mujoco>"""
"""Two wheels of 0.25 kg m2 that turn by themselves, the first as it is told."""


@pytest.fixture
def wheels(tmp_path: Path) -> Callable[..., Robot]:
    """Return what makes two wheels: with attributes of the joint and an actuator of the first."""

    def make(joint: str = "", actuator: str = MOTOR) -> Robot:
        path = tmp_path / "wheels.xml"
        path.write_text(WHEEL.format(joint=joint, actuator=actuator))
        return load(path)

    return make
