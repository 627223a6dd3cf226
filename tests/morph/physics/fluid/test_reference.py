"""The compiled fluid against its readable twin, and both against sums that know neither."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import mujoco
import numpy as np
import pytest

from morph.arrays import Array
from morph.physics.fluid import reference
from morph.physics.fluid.added_mass import AddedMass
from morph.physics.fluid.kernel import install
from morph.physics.fluid.numbers import ADDED, APART, FEWER, MARK, POINT, SCALE, WIDTH

Make = Callable[..., Any]
TREES = [(1, 0), (2, 12), (3, 2), (5, 3), (8, 4), (8, 5), (13, 6), (20, 7), (30, 8), (30, 9)]
"""Bodies and seed of each."""
EXACT = 1e-12
"""Rounding of sums of some hundred terms: 300 * 2.2e-16 = 7e-14, and some room."""

trees = pytest.mark.parametrize(("bodies", "seed"), TREES)


@pytest.fixture(autouse=True)
def _put_back() -> Iterator[None]:
    """Leave the compiled fluid installed."""
    install()
    yield
    mujoco.set_mjcb_passive(None)
    install()


def apart(one: Array, other: Array) -> float:
    """Return the greatest difference, as a part of the greatest value."""
    return float(np.abs(one - other).max() / np.abs(other).max())


def by_numpy(model: Any, data: Any) -> Any:
    """Return data at the same state, passed forward under the numpy fluid."""
    copy = mujoco.MjData(model)
    copy.qpos[:], copy.qvel[:] = data.qpos, data.qvel
    mujoco.set_mjcb_passive(reference.passive)
    mujoco.mj_forward(model, copy)
    return copy


def dried(model: Any) -> Any:
    """Return a copy of a model that feels no fluid."""
    dry = model.__copy__()
    dry.body_user[:, MARK] = 0.0
    return dry


@trees
def test_the_kernel_equals_its_readable_twin(
    grown: Make, moving: Make, bodies: int, seed: int
) -> None:
    model = grown(bodies, seed).compile()
    data = moving(model, seed)
    mujoco.mj_forward(model, data)
    twin = by_numpy(model, data)
    assert apart(data.M, twin.M) < EXACT
    assert apart(data.qfrc_passive, twin.qfrc_passive) < EXACT
    # Accelerations are solved for: rounding, 2.2e-16, times the condition of M, at most 2e5.
    assert apart(data.qacc, twin.qacc) < 5e-11


@trees
@pytest.mark.parametrize("roots", [1, 2])
def test_inertia_is_a_sum_over_the_bodies(
    grown: Make, moving: Make, dense: Make, bodies: int, seed: int, roots: int
) -> None:
    model = grown(bodies, seed, roots=roots).compile()
    data, still = moving(model, seed), moving(dried(model), seed)
    mujoco.mj_forward(model, data)
    mujoco.mj_forward(dried(model), still)
    whole = dense(model, still)
    for body in range(1, model.nbody):
        user, turned = model.body_user[body], data.xmat[body].reshape(3, 3)
        jacobian = np.zeros((6, model.nv))
        spot = data.xpos[body] + turned @ user[POINT]
        mujoco.mj_jac(model, data, jacobian[:3], jacobian[3:], spot, body)
        jacobian = np.kron(np.eye(2), turned.T) @ jacobian
        added = np.zeros((6, 6))
        added[np.triu_indices(6)] = user[ADDED]
        added = added + np.triu(added, 1).T
        whole += user[SCALE] * jacobian.T @ added @ jacobian
    assert apart(dense(model, data), whole) < EXACT


@trees
def test_inertia_counts_the_fluid_once_when_positions_are_kept(
    grown: Make, moving: Make, bodies: int, seed: int
) -> None:
    model = grown(bodies, seed).compile()
    data = moving(model, seed)
    mujoco.mj_forward(model, data)
    first = data.M.copy(), data.qLD.copy(), data.qacc.copy()
    for stage in (mujoco.mjtStage.mjSTAGE_POS, mujoco.mjtStage.mjSTAGE_VEL):
        mujoco.mj_forwardSkip(model, data, stage, 0)
        for held, again in zip(first, (data.M, data.qLD, data.qacc), strict=True):
            assert np.array_equal(held, again)


def test_a_dry_model_moves_as_if_there_were_no_fluid_to_the_last_bit(
    grown: Make, moving: Make
) -> None:
    model = dried(grown(12, 3).compile())
    under = moving(model, 3)
    mujoco.mj_step(model, under, 200)
    mujoco.set_mjcb_passive(None)
    alone = moving(model, 3)
    mujoco.mj_step(model, alone, 200)
    assert np.array_equal(under.qpos, alone.qpos)
    assert np.array_equal(under.qvel, alone.qvel)


def test_a_body_of_scale_zero_is_dry_to_the_last_bit(grown: Make, moving: Make) -> None:
    model = grown(12, 3).compile()
    model.body_user[4:, SCALE] = 0.0
    some = model.__copy__()
    some.body_user[4:, MARK] = 0.0
    ends = []
    for each in (model, some):
        data = moving(each, 3)
        mujoco.mj_step(each, data, 100)
        ends.append(data.qpos.copy())
    assert np.array_equal(ends[0], ends[1])


def test_half_a_scale_is_half_of_everything(grown: Make, moving: Make) -> None:
    model = grown(9, 4).compile()
    forces, inertias = [], []
    for scale in (0.0, 0.5, 1.0):
        model.body_user[1:, SCALE] = scale
        data = moving(model, 4)
        mujoco.mj_forward(model, data)
        forces.append(data.qfrc_passive.copy())
        inertias.append(data.M.copy())
    assert apart(forces[1], 0.5 * forces[2]) < EXACT
    assert apart(inertias[1] - inertias[0], 0.5 * (inertias[2] - inertias[0])) < EXACT


def test_two_trees_feel_nothing_of_each_other(grown: Make, moving: Make, dense: Make) -> None:
    model = grown(12, 5, roots=2).compile()
    data = moving(model, 5)
    mujoco.mj_forward(model, data)
    tree = model.body_treeid[model.dof_bodyid]
    assert set(tree.tolist()) == {0, 1}
    assert not dense(model, data)[np.ix_(tree == 0, tree == 1)].any()
    force = data.qfrc_passive.copy()
    data.qvel[tree == 1] *= 2.0
    mujoco.mj_forward(model, data)
    assert np.array_equal(data.qfrc_passive[tree == 0], force[tree == 0])
    assert not np.array_equal(data.qfrc_passive[tree == 1], force[tree == 1])


def test_a_wet_body_fixed_to_the_world_changes_nothing(grown: Make, moving: Make) -> None:
    spec = grown(6, 6, roots=2)
    spec.delete(next(iter(spec.body("b1").joints)))
    model = spec.compile()
    fixed = model.body("b1").id
    assert model.body_dofnum[fixed] == 0
    forces = []
    for mark in (model.body_user[fixed, MARK].copy(), 0.0):
        model.body_user[fixed, MARK] = mark
        data = moving(model, 6)
        mujoco.mj_forward(model, data)
        forces.append(np.concatenate([data.M, data.qfrc_passive, data.qacc]))
    assert np.array_equal(forces[0], forces[1])


def test_a_body_welded_to_another_adds_its_fluid_to_that_other(dense: Make) -> None:
    # A paddle of 2 kg of water along z, 0.5 m out along x: 2 kg, and 2 * 0.25 kg m2 about y.
    text = (
        '<mujoco><worldbody><body name="hull"><freejoint/><geom size="0.1" mass="1"/>'
        '<body name="paddle" pos="0.5 0 0"/></body></worldbody></mujoco>'
    )
    spec = mujoco.MjSpec.from_string(text)
    AddedMass(body="paddle", z=2.0).edit(spec)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    # A solid sphere: 2/5 m r^2.
    expected = np.diag([1.0, 1.0, 3.0, 0.004, 0.504, 0.004])
    expected[2, 4] = expected[4, 2] = -1.0
    assert dense(model, data) == pytest.approx(expected, abs=1e-15)


def test_a_file_of_version_01_has_both_drags_at_one_point(grown: Make, moving: Make) -> None:
    spec = grown(3, 2)
    for body in spec.bodies[1:]:
        kept = list(body.userdata)
        kept[APART] = [0.0] * 3
        body.userdata = kept
    new = spec.compile()
    spec.nuser_body = FEWER
    for body in spec.bodies[1:]:
        body.userdata = list(body.userdata)[:FEWER]
    old = spec.compile()
    assert (new.nuser_body, old.nuser_body) == (WIDTH, FEWER)
    data = moving(new, 2)
    mujoco.mj_forward(new, data)
    same = mujoco.MjData(old)
    same.qpos[:], same.qvel[:] = data.qpos, data.qvel
    mujoco.mj_forward(old, same)
    assert np.abs(same.qfrc_passive).max() > 0.1
    assert np.array_equal(same.qfrc_passive, data.qfrc_passive)
    assert apart(by_numpy(old, same).qfrc_passive, data.qfrc_passive) < EXACT
