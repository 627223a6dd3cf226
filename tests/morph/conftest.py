"""Small bodies whose figures are known in closed form."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.native.compilers import compilers
from morph.physics.effect import Effect
from morph.record.recording import Channel, Recording
from morph.sim.simulator import Simulator

Recorded = Callable[..., Recording]

ARM = """
<mujoco model="arm">
  <compiler angle="radian"/>
  <worldbody>
    <body name="upper" pos="0 0 1">
      <joint name="shoulder" axis="0 1 0" {shoulder}/>
      <geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.001" mass="0"/>
      <inertial pos="0.2 0 0" mass="2" diaginertia="0.01 0.01 0.01"/>
      <body name="lower" pos="0.4 0 0">
        <joint name="elbow" axis="0 1 0" {elbow}/>
        <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.001" mass="0"/>
        <inertial pos="0.1 0 0" mass="1" diaginertia="0.01 0.01 0.01"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <motor name="shoulder_motor" joint="shoulder" ctrllimited="true" ctrlrange="-20 20"/>
    <motor name="elbow_motor" joint="elbow" ctrllimited="true" ctrlrange="-4 4"/>
  </actuator>
</mujoco>
"""
"""Two links of 0.4 m and 0.3 m in a vertical plane, 2 kg at 0.2 m and 1 kg at 0.1 m."""

FOUR_BAR = """
<mujoco model="four_bar">
  <compiler angle="radian"/>
  <worldbody>
    <body name="crank">
      <joint name="drive" axis="0 1 0"/>
      <inertial pos="0.03 0 0" mass="1" diaginertia="0.001 0.001 0.001"/>
      <geom type="capsule" fromto="0 0 0 0.06 0 0" size="0.002" mass="0"/>
      <body name="coupler" pos="0.06 0 0">
        <joint name="pin" axis="0 1 0"/>
        <inertial pos="0.07 0 0" mass="0.5" diaginertia="0.001 0.001 0.001"/>
        <geom type="capsule" fromto="0 0 0 {across} 0 {down}" size="0.002" mass="0"/>
      </body>
    </body>
    <body name="rocker" pos="0.16 0 0">
      <joint name="swing" axis="0 1 0" {swing}/>
      <inertial pos="0 0 0.04" mass="0.7" diaginertia="0.001 0.001 0.001"/>
      <geom type="capsule" fromto="0 0 0 0 0 0.1" size="0.002" mass="0"/>
    </body>
  </worldbody>
  <equality>
    <connect body1="coupler" body2="rocker" anchor="{across} 0 {down}"/>
  </equality>
  <actuator>
    <motor name="motor" joint="drive" ctrllimited="true" ctrlrange="-2 2"/>
  </actuator>
</mujoco>
"""
"""Ground 0.16 m, crank 0.06 m along the ground, rocker 0.1 m upright: they meet at the pin."""

FOLLOWING = """
<mujoco model="gripper">
  <compiler angle="radian"/>
  <worldbody>
    <body name="palm">
      <freejoint name="root"/>
      <geom size="0.05" mass="1"/>
      <body name="left_finger" pos="0.1 0 0">
        <joint name="left" axis="0 1 0" limited="true" range="-1 1"/>
        <geom size="0.02" mass="0.1"/>
      </body>
      <body name="right_finger" pos="-0.1 0 0">
        <joint name="right" axis="0 1 0"/>
        <geom size="0.02" mass="0.1"/>
      </body>
      <body name="slider" pos="0 0.1 0">
        <joint name="rail" type="slide" axis="0 1 0"/>
        <geom size="0.02" mass="0.1"/>
      </body>
    </body>
  </worldbody>
  <equality>
    <joint joint1="right" joint2="left" polycoef="0.1 -2 0 0 0"/>
  </equality>
</mujoco>
"""
"""A finger that follows the other as 0.1 - 2 x, on a palm that floats."""


def snake(joints: int) -> str:
    """Return a chain of many joints."""
    open_ = "".join(
        f'<body name="link_{at}" pos="0.1 0 0"><joint name="joint_{at}" axis="0 {at % 2} '
        f'{1 - at % 2}" limited="true" range="-1 1"/>'
        f'<geom type="capsule" fromto="0 0 0 0.1 0 0" size="0.01" mass="0.1"/>'
        for at in range(joints)
    )
    return (
        '<mujoco model="snake"><compiler angle="radian"/><worldbody>'
        + open_
        + "</body>" * joints
        + "</worldbody></mujoco>"
    )


@pytest.fixture
def body(tmp_path: Path) -> Callable[[str], Robot]:
    """Reads a body from MJCF text."""

    def read(text: str) -> Robot:
        place = tmp_path / "body.xml"
        place.write_text(text)
        return load(place)

    return read


@pytest.fixture
def arm(body: Callable[[str], Robot]) -> Callable[..., Robot]:
    """Makes the arm with two links, its joints with other attributes."""
    return lambda shoulder="", elbow="": body(ARM.format(shoulder=shoulder, elbow=elbow))


@pytest.fixture
def four_bar(body: Callable[[str], Robot]) -> Callable[..., Robot]:
    """Makes the four-bar."""
    return lambda swing="": body(FOUR_BAR.format(swing=swing, across=0.1, down=0.1))


@pytest.fixture
def gripper(body: Callable[[str], Robot]) -> Robot:
    """The fingers of which one follows."""
    return body(FOLLOWING)


@pytest.fixture
def long_snake(body: Callable[[str], Robot]) -> Robot:
    """A body with 48 joints."""
    return body(snake(48))


@pytest.fixture
def compiler() -> tuple[str, ...]:
    """A C compiler."""
    if not compilers():
        pytest.skip("there is no C compiler")
    return compilers()[0]


@pytest.fixture(scope="session")
def pendulum() -> Robot:
    return load("pendulum")


@pytest.fixture(scope="session")
def cartpole() -> Robot:
    return load("cartpole")


def _recorded(
    robot: Robot,
    *effects: Effect,
    seconds: float = 4.0,
    noise: float = 2e-4,
    seed: int = 0,
    name: str = "run",
    start: Mapping[str, float] | None = None,
    command: Callable[[Array], Array] | None = None,
) -> Recording:
    """Return a recording at 200 Hz of a run simulated at 2 kHz, every actuator told alike."""
    rng = np.random.default_rng(seed)
    told = {a.name: command or (lambda times: 0.0 * times) for a in robot.actuators}
    fine = Simulator(robot, effects=effects, step=0.0005).run(
        seconds=seconds, start=start, command=told
    )
    channels = {}
    for channel, c in fine.channels.items():
        if c.hold:
            channels[channel] = c
        elif channel.endswith(".position"):
            value = c.value[::10]
            channels[channel] = Channel(
                time=c.time[::10], value=value + rng.normal(0.0, noise, len(value))
            )
    return replace(fine, channels=channels, name=name)


@pytest.fixture(scope="session")
def recorded() -> Recorded:
    """Makes recordings."""
    return _recorded
