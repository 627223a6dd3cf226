"""Forces of other figures of a description against MuJoCo's inverse dynamics."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from morph.inference.figures import forces_between
from morph.physics.body_motion import body_motions
from morph.physics.motion import Motion

ARM = """
<mujoco><compiler angle="radian"/><worldbody><body name="base" pos="0 0 1" quat="0.9 0.1 0.3 0.2">
  <joint name="a" axis="0 1 0" damping="{damping}" stiffness="{stiffness}" springref="0.3"/>
  <inertial pos="0.1 0 {com}" mass="{mass}" fullinertia="0.02 0.03 0.04 0.001 0.002 -0.003"/>
  <body name="tip" pos="0.2 0 0.4"><joint name="b" axis="1 0.5 0" armature="{armature}"/>
    <inertial pos="0 0.1 0.2" quat="0.7 0.1 0.6 0.2" mass="1.2" diaginertia="{turn} 0.01 0.015"/>
    <body name="slider" pos="0 0 0.5"><joint name="c" type="slide" axis="0 0.2 1"/>
      <inertial pos="0 0 0" mass="0.7" diaginertia="0.01 0.01 0.01"/></body></body></body>
</worldbody>
<actuator>
  <position name="servo" joint="a" kp="{kp}" kv="2" gear="1.5" forcerange="-30 30"/>
  <general name="motor" joint="b" gainprm="{gain}" ctrlrange="-0.8 0.8" gear="-3"/>
</actuator></mujoco>"""
PLAIN = {
    "damping": 0.3, "stiffness": 2.0, "com": 0.3, "mass": 2.0, "armature": 0.1, "turn": 0.012,
    "kp": 20.0, "gain": 2.0,
}  # fmt: skip


def model(**figures: float) -> mujoco.MjModel:
    """Return the arm with some figures changed."""
    return mujoco.MjModel.from_xml_string(ARM.format(**(PLAIN | figures)))


def supplied(robot: mujoco.MjModel, motion: Motion) -> np.ndarray:
    """Return forces of the actuators less those that the motion needs, by MuJoCo."""
    data, found = mujoco.MjData(robot), np.empty_like(motion.position)
    for t in range(len(found)):
        data.qpos[:], data.qvel[:] = motion.position[t], motion.velocity[t]
        data.qacc[:], data.ctrl[:] = motion.acceleration[t], motion.command[t]
        mujoco.mj_inverse(robot, data)
        mujoco.mj_fwdActuation(robot, data)
        found[t] = data.qfrc_actuator - data.qfrc_inverse
    return found


@pytest.fixture(scope="module")
def motion() -> Motion:
    """States, accelerations and commands drawn at random; some reach the actuators' limits."""
    rng, samples = np.random.default_rng(0), 40
    position, velocity, acceleration = rng.normal(size=(3, samples, 3))
    robot, none = model(), np.zeros((samples, 0, 3))
    names = ["base", "tip", "slider"]
    return Motion(
        position=position, velocity=velocity, acceleration=acceleration,
        command=1.5 * rng.normal(size=(samples, 2)), time=0.01 * np.arange(samples),
        bodies=body_motions(robot, names, position, velocity, acceleration),
        drive=none, drive_rate=none, stiffness=np.zeros((samples, 3, 3)), joints={}, actuators={},
    )  # fmt: skip


@pytest.mark.parametrize("figure", PLAIN)
def test_a_figure_changes_the_force_as_in_another_library(figure: str, motion: Motion) -> None:
    other = model(**{figure: 1.1 * PLAIN[figure]})
    exact = supplied(other, motion) - supplied(model(), motion)
    assert np.abs(exact).max() > 1e-4
    found = forces_between(model(), [model(), other], motion)[:, :, 1]
    # Sums of about a hundred terms near 100 N m, each rounded to 1e-16 of itself.
    assert found == pytest.approx(exact, abs=1e-11)


def test_the_limits_of_actuators_are_reached(motion: Motion) -> None:
    found = forces_between(model(), [model(kp=25.0)], motion)[:, 0, 0]
    assert 0 < np.count_nonzero(np.abs(found) < 1e-12) < len(found)
