"""Forces of actuators, on joints and on none, against MuJoCo's own and against Jacobians."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from morph.arrays import Array
from morph.physics.drives import Transmission, actuator_forces

BODIES = """<mujoco><option gravity="0 0 0"/><worldbody>
  <body name="hull"><freejoint/><geom type="box" size="0.2 0.1 0.05" mass="3"/>
    <site name="stern" pos="-0.2 0.05 0.02" euler="10 20 30"/>
    <body name="arm" pos="0.2 0 0"><joint name="a" axis="0 1 0"/>
      <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.02" mass="0.5"/>
      <site name="tip" pos="0.3 0 0"/>
      <body name="hand" pos="0.3 0 0"><joint name="b" axis="0 0 1"/>
        <geom size="0.05" mass="0.2"/><site name="nail" pos="0 0.1 0"/></body></body></body>
  </worldbody>
  <tendon><fixed name="both"><joint joint="a" coef="0.7"/><joint joint="b" coef="-0.4"/></fixed>
    <spatial name="cord"><site site="stern"/><site site="nail"/></spatial></tendon>
  <actuator>%s</actuator></mujoco>"""
FREE = (
    '<motor name="screw" site="stern" gear="1 2 -0.5 0.1 0.3 -0.2"/>'
    '<motor name="winch" tendon="cord" gear="3"/>'
    '<position name="pair" tendon="both" kp="5" kv="0.6" gear="2"/>'
)
JOINTED = '<motor name="a" joint="a" gear="-3"/><position name="b" joint="b" kp="7" kv="0.4"/>'


def states(model: mujoco.MjModel) -> tuple[Array, Array, Array]:
    """Return 15 states, with unit quaternions, and commands."""
    rng = np.random.default_rng(3)
    pose = rng.normal(size=(15, model.nq))
    pose[:, 3:7] /= np.linalg.norm(pose[:, 3:7], axis=1, keepdims=True)
    return pose, rng.normal(size=(15, model.nv)), rng.normal(size=(15, model.nu))


@pytest.mark.parametrize("actuators", [FREE, JOINTED, FREE + JOINTED])
def test_generalized_forces_are_mujocos(actuators: str) -> None:
    model = mujoco.MjModel.from_xml_string(BODIES % actuators)
    data = mujoco.MjData(model)
    pose, velocity, command = states(model)
    found = Transmission.along(model, pose)
    force = found.forces(actuator_forces(model, found, velocity, command))
    for k in range(len(pose)):
        data.qpos, data.qvel, data.ctrl = pose[k], velocity[k], command[k]
        mujoco.mj_forward(model, data)
        # The same sums in another order: 1e-13 of some 10 N.
        assert np.allclose(force[k], data.qfrc_actuator, rtol=0.0, atol=1e-12)
        assert np.allclose(found.length[k], data.actuator_length, rtol=0.0, atol=1e-12)


def test_the_moment_of_a_thruster_is_its_wrench_by_the_jacobian_of_its_site() -> None:
    model = mujoco.MjModel.from_xml_string(BODIES % FREE)
    data, site = mujoco.MjData(model), model.site("stern").id
    pose, _, _ = states(model)
    moment = Transmission.along(model, pose).moment[:, 0]
    linear, angular = np.zeros((2, 3, model.nv))
    for k in range(len(pose)):
        data.qpos = pose[k]
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_jacSite(model, data, linear, angular, site)
        axes = data.site_xmat[site].reshape(3, 3)
        due = linear.T @ axes @ [1.0, 2.0, -0.5] + angular.T @ axes @ [0.1, 0.3, -0.2]
        assert np.allclose(moment[k], due, rtol=0.0, atol=1e-12)
