"""The fluid goes wherever a model goes: copies, files, batches, rollouts, single simulations."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from mujoco import rollout as mujoco_rollout
from mujoco.batch import Batch

from morph.arrays import Array
from morph.body.fulltext import fulltext
from morph.body.robot import Robot
from morph.physics.fluid.added_mass import AddedMass
from morph.physics.fluid.numbers import SCALE
from morph.physics.fluid.quadratic_drag import QuadraticDrag
from morph.physics.fluid.reference import wet_bodies
from morph.physics.fluid.settle import settle
from morph.sim.rollout import rollout
from morph.sim.simulator import Simulator

Make = Callable[..., Any]
STEPS = 50


def alone(model: Any, position: Array, velocity: Array) -> Array:
    """Return where a single simulation ends, (nq + nv,)."""
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = position, velocity
    mujoco.mj_step(model, data, STEPS)
    return np.concatenate([data.qpos, data.qvel])


@pytest.fixture
def model(grown: Make) -> Any:
    spec = grown(9, 7)
    spec.option.timestep = 0.005
    return settle(spec.compile())


@pytest.fixture
def starts(model: Any, moving: Make) -> tuple[Array, Array]:
    states = [moving(model, seed, 0.3) for seed in range(4)]
    return np.array([each.qpos for each in states]), np.array([each.qvel for each in states])


def test_a_copy_of_data_goes_on_to_the_last_bit(model: Any, moving: Make) -> None:
    first = moving(model, 0, 0.3)
    mujoco.mj_step(model, first, 7)
    second = first.__copy__()
    mujoco.mj_step(model, first, STEPS)
    mujoco.mj_step(model, second, STEPS)
    assert np.array_equal(first.qpos, second.qpos)
    assert np.array_equal(first.qvel, second.qvel)


def test_a_batch_moves_each_row_as_it_would_move_alone(
    model: Any, starts: tuple[Array, Array]
) -> None:
    q, v = starts
    batch = Batch(model, len(q), 2)
    batch.reset(stage=mujoco.mjtStage.mjSTAGE_NONE.value)
    batch.bind("qpos")[:], batch.bind("qvel")[:] = q, v
    for _ in range(STEPS):
        batch.step()
    ends = np.concatenate([batch.bind("qpos"), batch.bind("qvel")], axis=1)
    for row, end in enumerate(ends):
        assert np.array_equal(end, alone(model, q[row], v[row]))


def test_each_row_of_a_batch_has_a_fluid_of_its_own(
    model: Any, starts: tuple[Array, Array]
) -> None:
    q, v = starts
    scales = (0.0, 0.3, 1.0, 2.0)
    batch = Batch(model, len(q), 2)
    batch.reset(stage=mujoco.mjtStage.mjSTAGE_NONE.value)
    batch.expand("body_user")[:, 1:, SCALE.start] = np.array(scales)[:, None]
    batch.bind("qpos")[:], batch.bind("qvel")[:] = q, v
    out = batch.rollout(STEPS, record=("qpos", "qvel"))
    for row, scale in enumerate(scales):
        model.body_user[1:, SCALE] = scale
        end = np.concatenate([out["qpos"][row, -1], out["qvel"][row, -1]])
        assert np.array_equal(end, alone(model, q[row], v[row]))


def test_mujocos_rollout_moves_each_row_as_it_would_move_alone(
    model: Any, starts: tuple[Array, Array]
) -> None:
    q, v = starts
    states = np.concatenate([np.zeros((len(q), 1)), q, v], axis=1)
    found, _ = mujoco_rollout.rollout(
        [model] * len(q), [mujoco.MjData(model) for _ in range(2)], states, nstep=STEPS
    )
    for row, state in enumerate(found[:, -1]):
        assert np.array_equal(state[1:], alone(model, q[row], v[row]))


def test_mjcf_at_full_precision_keeps_the_fluid_to_the_last_bit(
    grown: Make, starts: tuple[Array, Array]
) -> None:
    spec = grown(9, 7)
    spec.option.timestep = 0.005
    model = spec.compile()
    again = mujoco.MjSpec.from_string(fulltext(spec)).compile()
    assert np.array_equal(again.body_user, model.body_user)
    assert not again.body_simple[1:].any()
    # Frames are quaternions that are normalized again, 1e-16; 50 steps of rounding.
    q, v = starts[0][0], starts[1][0]
    assert alone(again, q, v) == pytest.approx(alone(model, q, v), abs=1e-10)


def test_mjcf_as_mujoco_writes_it_keeps_six_digits_of_the_fluid(grown: Make) -> None:
    spec = grown(9, 7)
    model = spec.compile()
    again = mujoco.MjSpec.from_string(spec.to_xml()).compile()
    assert list(wet_bodies(again)) == list(wet_bodies(model)) != []
    assert again.body_user == pytest.approx(model.body_user, rel=5e-6, abs=0.0)


def test_a_binary_file_keeps_the_fluid_to_the_last_bit(
    model: Any, starts: tuple[Array, Array], tmp_path: Path
) -> None:
    mujoco.mj_saveModel(model, str(tmp_path / "model.mjb"))
    again = mujoco.MjModel.from_binary_path(str(tmp_path / "model.mjb"))
    q, v = starts[0][0], starts[1][0]
    assert np.array_equal(alone(again, q, v), alone(model, q, v))


def test_variants_of_a_robot_in_different_fluids_share_a_rollout(
    written: Callable[[str], Robot],
) -> None:
    robot = written(
        '<worldbody><body name="hull"><freejoint/><inertial pos="0 0 0" mass="2" '
        'diaginertia="0.1 0.2 0.3"/></body></worldbody>'
    )
    fluids = [
        (AddedMass(body="hull", x=x, z=2.0 * x), QuadraticDrag(body="hull", z=3.0 * x))
        for x in (0.0, 0.5, 4.0)
    ]
    simulators = [Simulator(robot, each) for each in fluids]
    q = np.tile(simulators[0].model.qpos0, (3, 1))
    v = np.tile([0.5, 0.0, -0.2, 0.3, -0.7, 0.1], (3, 1))
    which, told = np.array([2, 0, 1]), np.zeros((3, STEPS, 0))
    places, speeds = rollout([s._variant for s in simulators], which, q, v, told)
    for row, index in enumerate(which):
        end = np.concatenate([places[row, -1], speeds[row, -1]])
        assert np.array_equal(end, alone(simulators[index].model, q[row], v[row]))
