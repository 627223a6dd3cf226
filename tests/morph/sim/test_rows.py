"""What effects see of a batch, against MuJoCo's own parameters."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from mujoco.batch import Batch

from morph.arrays import Array
from morph.errors import SimulationFailed
from morph.physics.effect import Simulations
from morph.sim.rows import Rows

ARM = """<mujoco>
  <compiler angle="radian" inertiafromgeom="false"/>
  <option timestep="0.002" integrator="implicitfast"/>
  <worldbody>
    <body name="a">
      <inertial pos="0 0 -0.2" mass="%g" diaginertia="0.02 0.03 0.02"/>
      <joint name="j" axis="0 1 0" armature="%g" frictionloss="%g"/>
      <body name="b" pos="0 0 -0.4">
        <inertial pos="0 0 -0.15" mass="0.7" diaginertia="0.01 0.012 0.01"/>
        <joint name="k" axis="0 1 0" actuatorfrcrange="-0.9 1.1"/>
      </body>
    </body>
    <body name="c"><inertial pos="0 0 0" mass="1" diaginertia="0.1 0.1 0.1"/>
      <joint name="alone" axis="0 0 1" armature="%g"/></body>
  </worldbody>
  <actuator>%s</actuator>
</mujoco>"""

ACTUATORS = (
    '<motor name="u" joint="j" gear="-3"/>',
    '<motor name="u" joint="j" gear="2" ctrlrange="-0.5 0.3" forcerange="-0.4 0.2"/>',
    '<position name="u" joint="k" kp="7" kv="0.4" gear="1.5"/>',
    '<position name="u" joint="k" kp="7" forcerange="-1 2"/>',
    '<velocity name="u" joint="k" kv="0.8"/>',
    '<general name="u" joint="j" gaintype="affine" gainprm="1 0.3 -0.2" biastype="affine"'
    ' biasprm="0.1 -0.4 0.05"/>',
)


def model(
    actuator: str = "", mass: float = 1.2, armature: float = 0.1, dry: float = 0.0
) -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(ARM % (mass, armature, dry, armature, actuator))


@pytest.mark.parametrize("actuator", ACTUATORS)
def test_the_torque_of_an_actuator_is_mujocos(actuator: str) -> None:
    made = model(actuator)
    batch = Batch(made, 20, 1)
    rows = Rows(batch, 0.002)
    rng = np.random.default_rng(0)
    q, v, u = rng.normal(size=(3, 20, 3))
    batch.bind("qpos")[:], batch.bind("qvel")[:], batch.bind("ctrl")[:] = q, v, u[:, :1]
    data = mujoco.MjData(made)
    due = np.empty(20)
    for k in range(20):
        data.qpos, data.qvel, data.ctrl = q[k], v[k], u[k, :1]
        mujoco.mj_forward(made, data)
        # One joint is driven: the sum is its part.
        due[k] = data.qfrc_actuator.sum()
    assert rows.effort("u") == pytest.approx(due, abs=1e-14)
    assert np.abs(due).max() > 0.1


def test_an_actuator_with_a_state_of_its_own_is_refused() -> None:
    made = model('<general name="u" joint="j" dyntype="filter" dynprm="0.1"/>')
    with pytest.raises(SimulationFailed, match="follows from more than command") as caught:
        Rows(Batch(made, 1, 1), 0.002).effort("u")
    assert "actuator u" in caught.value.where
    assert "motor or a servo" in caught.value.fix


class Heavier:
    """An effect that adds a rotor and friction, on every joint another."""

    kind = "joint"

    def before_step(self, simulations: Simulations, state: Array) -> Array:
        for at, joint in enumerate(("j", "alone")):
            simulations.armature(joint)[:] += 0.05 * (at + 1)
            simulations.friction(joint)[:] += state
        return state


def test_rotors_and_friction_of_rows_are_as_if_they_were_described() -> None:
    # Rows of two variants, which differ in what no effect touches too.
    ways = [(1.2, 0.0), (0.8, 0.3)]
    variants = [model(mass=mass, dry=dry) for mass, dry in ways]
    batch = Batch(variants[0], 4, 1)
    batch.set_models([variants[at] for at in (0, 1, 1, 0)])
    batch.reset(stage=0)
    start, added = np.array([0.5, -1.0, 2.0]), np.array([0.0, 0.1, 0.2, 0.3])
    batch.bind("qvel")[:] = start
    rows, states = Rows(batch, 0.002), [added]
    for _ in range(50):
        rows.act([Heavier()], states)  # type: ignore[list-item]
        batch.step()
    for row, at in enumerate((0, 1, 1, 0)):
        mass, dry = ways[at]
        text = ARM % (mass, 0.15, dry + added[row], 0.2, "")
        text = text.replace('armature="0.2"', f'armature="0.2" frictionloss="{added[row]}"')
        due = mujoco.MjModel.from_xml_string(text)
        # Inertias at rest scale the softness of friction and are those of the batch's models:
        # 1e-4 of 0.6 N m / 0.1 kg m2 for 0.1 s.
        data = mujoco.MjData(due)
        data.qvel = start
        for _ in range(50):
            mujoco.mj_step(due, data)
        assert batch.bind("qvel")[row] == pytest.approx(data.qvel, abs=1e-4)
    # Neither rotors nor friction are left behind.
    rows.act([], [])
    assert np.array_equal(batch.expanded("dof_armature"), np.tile([0.1, 0.0, 0.1], (4, 1)))
    assert np.array_equal(batch.expanded("dof_frictionloss")[:, 0], [0.0, 0.3, 0.3, 0.0])
