"""The publisher's model of the rig, against MuJoCo, energy and the rig itself."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from experiments.dfki import DESIGNS, FOLDER
from experiments.dfki_published import (
    PUBLISHED,
    Published,
    acceleration,
    by_its_equations,
    with_friction,
)
from experiments.openloop import Model, bound, errors, laid
from morph.arrays import Array
from morph.body.load import load as load_robot
from morph.model.score import rmse
from morph.model.segments import scored_segments
from morph.sim.simulator import Simulator

FREE = Published(
    mass=(0.6, 0.5),
    length=0.25,
    centre=(0.2, 0.15),
    inertia=(0.03, 0.02),
    rotor=0.0,
    coulomb=(0.0, 0.0),
    viscous=0.0,
)
"""Two rods without rotors and friction, whose inertias a body can have."""


def drawn(rows: int) -> tuple[Array, Array, Array]:
    rng = np.random.default_rng(0)
    return rng.uniform(-3, 3, (rows, 2)), rng.uniform(-6, 6, (rows, 2)), rng.normal(size=(rows, 2))


def test_without_rotors_and_friction_the_published_equations_are_mujocos() -> None:
    (m1, m2), (r1, r2), (i1, i2) = FREE.mass, FREE.centre, FREE.inertia
    at1, at2 = i1 - m1 * r1**2, i2 - m2 * r2**2
    model = mujoco.MjModel.from_xml_string(f"""<mujoco><compiler inertiafromgeom="false"/>
      <worldbody><body><joint axis="0 -1 0"/>
        <inertial pos="0 0 {-r1}" mass="{m1}" diaginertia="{at1} {at1} 1e-3"/>
        <body pos="0 0 {-FREE.length}"><joint axis="0 -1 0"/>
          <inertial pos="0 0 {-r2}" mass="{m2}" diaginertia="{at2} {at2} 1e-3"/>
      </body></body></worldbody></mujoco>""")
    data = mujoco.MjData(model)
    q, v, torque = drawn(20)
    for row, found in enumerate(acceleration(FREE, q, v, torque)):
        data.qpos, data.qvel, data.qfrc_applied = q[row], v[row], torque[row]
        mujoco.mj_forward(model, data)
        assert found == pytest.approx(data.qacc, rel=1e-9, abs=1e-9)


def test_with_rotors_power_in_is_the_growth_of_energy() -> None:
    rig = replace(FREE, rotor=1e-4)
    (m1, m2), (r1, r2), (i1, i2) = rig.mass, rig.centre, rig.inertia

    def energy(q: Array, v: Array) -> Array:
        across = i2 + m2 * rig.length * r2 * np.cos(q[:, 1])
        first = i1 + 2.0 * across - i2 + m2 * rig.length**2
        kinetic = 0.5 * first * v[:, 0] ** 2 + across * v[:, 0] * v[:, 1] + 0.5 * i2 * v[:, 1] ** 2
        # Each rotor turns six times as fast as its joint; the elbow's rides on the first link,
        # turning against it.
        spin = 0.5 * rig.rotor * ((6.0 * v[:, 0]) ** 2 + (v[:, 0] - 6.0 * v[:, 1]) ** 2)
        high = -m1 * r1 * np.cos(q[:, 0]) - m2 * rig.length * np.cos(q[:, 0])
        return kinetic + spin + 9.81 * (high - m2 * r2 * np.cos(q.sum(axis=1)))

    q, v, torque = drawn(50)
    a, h = acceleration(rig, q, v, torque), 1e-5
    growth = (energy(q + h * v, v + h * a) - energy(q - h * v, v - h * a)) / (2.0 * h)
    # The central difference errs by h^2 times a third derivative of some 1e4 W/s2.
    assert growth == pytest.approx((torque * v).sum(axis=1), abs=1e-5)


@pytest.mark.parametrize("rig", PUBLISHED.values(), ids=PUBLISHED)
def test_published_friction_at_speed_is_its_factor_times_half_of_pi(rig: Published) -> None:
    assert rig.level == pytest.approx((0.14608, 0.12252), abs=1e-5)
    bare = replace(rig, coulomb=(0.0, 0.0), viscous=0.0)
    q, torque = np.zeros((1, 2)), np.zeros((1, 2))
    m12 = rig.inertia[1] + rig.mass[1] * rig.length * rig.centre[1] - 6.0 * rig.rotor
    m22 = rig.inertia[1] + 36.0 * rig.rotor
    v = np.array([[5.0, -5.0]])
    loss = acceleration(bare, q, v, torque) - acceleration(rig, q, v, torque)
    # The second row of M a = F: friction of the elbow. arctan(500) = pi / 2 - 0.002, and
    # viscous friction adds 0.001 * 5.
    elbow = float(m12 * loss[0, 0] + m22 * loss[0, 1])
    assert elbow == pytest.approx(-(rig.coulomb[1] * (math.pi / 2.0 - 0.002) + 0.005), rel=1e-5)


def test_published_friction_is_written_at_its_joint_and_nowhere_else() -> None:
    robot = load_robot("double_pendulum")
    before = Simulator(robot).model
    after = Simulator(with_friction(robot, (0.146, 0.123), 0.001).robot).model
    assert list(after.dof_frictionloss) == pytest.approx([0.146, 0.123])
    assert np.ravel(after.dof_damping)[:2] == pytest.approx([0.001, 0.001])
    assert np.array_equal(after.body_mass, before.body_mass)
    assert np.array_equal(after.dof_armature, before.dof_armature)


def test_on_the_rig_the_publisher_s_model_is_better_the_more_of_it_is_taken(
    recordings: Path,
) -> None:
    design, rig = DESIGNS["C.0"], PUBLISHED["C.0"]
    robot = load_robot(design.robot)
    runs = laid(bound(design.binding, FOLDER, robot, ("run_03",), root=recordings), robot)
    left_out = errors(Model(robot=robot), runs, 1.0)
    factors = errors(with_friction(robot, rig.coulomb, rig.viscous), runs, 1.0)
    levels = errors(with_friction(robot, rig.level, rig.viscous), runs, 1.0)
    segments = scored_segments(runs, 1.0)
    own = rmse(segments, by_its_equations(rig, segments))
    for index, joint in enumerate(left_out):
        assert left_out[joint] > factors[joint] > levels[joint] > own[index]


def test_the_publisher_s_rollouts_converge(
    recordings: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    design, rig = DESIGNS["C.0"], PUBLISHED["C.0"]
    robot = load_robot(design.robot)
    runs = laid(bound(design.binding, FOLDER, robot, ("run_03",), root=recordings), robot)
    segments = scored_segments(runs, 1.0)
    coarse = rmse(segments, by_its_equations(rig, segments))
    monkeypatch.setattr("experiments.dfki_published.SUBSTEPS", 32)
    # What is reported has three digits.
    assert rmse(segments, by_its_equations(rig, segments)) == pytest.approx(coarse, rel=1e-3)
