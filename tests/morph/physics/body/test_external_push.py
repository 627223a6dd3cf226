from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from morph.body.load import load
from morph.body.robot import Robot
from morph.physics.body.external_push import ExternalPush
from morph.sim.simulator import Simulator

BRICK = """<mujoco model="brick">
  <compiler angle="radian" inertiafromgeom="false"/>
  <option gravity="0 0 0"/>
  <worldbody>
    <body name="brick" quat="0.8 0.2 0.4 0.4">
      <freejoint/>
      <inertial pos="0.1 0.2 0.3" mass="2" diaginertia="0.1 0.2 0.15"/>
    </body>
  </worldbody>
</mujoco>"""

IMPULSE = np.array([0.3, -0.7, 0.4])


@pytest.fixture
def brick(tmp_path: Path) -> Robot:
    path = tmp_path / "brick.xml"
    path.write_text(BRICK)
    return load(path)


# Edges that fall between steps, on steps, within one step, and an end before the start.
@pytest.mark.parametrize(
    ("start", "end"), [(0.1013, 0.2027), (0.1, 0.2), (0.1003, 0.1011), (0.15, 0.1)]
)
def test_a_push_adds_its_impulse_evenly_and_turns_nothing(
    brick: Robot, start: float, end: float
) -> None:
    push = ExternalPush(
        body="brick", start=start, end=end, x=IMPULSE[0], y=IMPULSE[1], z=IMPULSE[2]
    )
    run = Simulator(brick, (push,), step=0.002).run(seconds=0.3)
    time = run.channel("brick.linear_velocity.x").time
    # One that is shorter than a step is spread over a step.
    share = np.clip((time - start) / (max(end, start + 0.002) - start), 0.0, 1.0)
    for axis, impulse in zip("xyz", IMPULSE, strict=True):
        # The frame moves as the centre of mass, for nothing turns: roundoff of 150 steps.
        got = run[f"brick.linear_velocity.{axis}"]
        assert got == pytest.approx(impulse / 2.0 * share, abs=1e-13)
        assert np.abs(run[f"brick.angular_velocity.{axis}"]).max() < 1e-13


def test_two_pushes_on_one_link_add_up(brick: Robot) -> None:
    pushes = tuple(ExternalPush(body="brick", end=0.1, x=x) for x in (0.2, -0.5))
    run = Simulator(brick, pushes).run(seconds=0.2)
    assert run["brick.linear_velocity.x"][-1] == pytest.approx(-0.15, abs=1e-13)
