"""Where links are in a run, beside MuJoCo's own kinematics."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.body.spec import spec_of
from morph.task.moved import Moved

JOINTS = """<mujoco><worldbody><body pos=".1 .2 .3" euler="10 20 30"><freejoint/>
<geom size=".1"/><body pos="0 .1 0" euler="0 40 5"><joint type="ball" pos=".1 0 .2"/>
<geom size=".1"/><body pos=".2 0 0"><joint type="slide" axis="1 2 0" ref=".1"/>
<joint axis="0 1 1" pos="0 .1 0" ref="20"/><joint axis="1 0 0" pos=".1 0 0"/><geom size=".1"/>
</body></body></body></worldbody></mujoco>"""


def runs(model: Any, position: Array) -> Moved:
    """States at given positions, shape (rows, samples, nq)."""
    shape = position.shape[:-1]
    return Moved(
        robot=load("pendulum"), model=model, time=np.arange(float(shape[1])), position=position,
        velocity=np.zeros((*shape, model.nv)), command=np.zeros((*shape, model.nu)),
    )  # fmt: skip


@pytest.mark.parametrize("body", ["cart_three_links", "quadruped_printed", "every joint"])
def test_poses_of_links_are_those_that_mujoco_gives_one_by_one(body: str) -> None:
    every = body == "every joint"
    model: Any = mujoco.MjModel.from_xml_string(JOINTS) if every else spec_of(load(body)).compile()
    # Quaternions are of any length: MuJoCo makes units of them.
    q = np.random.default_rng(1).normal(size=(3, 4, model.nq))
    moved = runs(model, q)
    data: Any = mujoco.MjData(model)
    for row in range(3):
        for sample in range(4):
            data.qpos[:] = q[row, sample]
            mujoco.mj_kinematics(model, data)
            for each in range(model.nbody):
                pose = moved.pose(each)
                # A chain of ten rotations, each rounded to 2e-16, and lengths of metres.
                np.testing.assert_allclose(pose.position[row, sample], data.xpos[each], atol=1e-13)
                np.testing.assert_allclose(
                    pose.rotation[row, sample].ravel(), data.xmat[each], atol=1e-13
                )


def test_a_link_is_nowhere_where_any_position_is_no_number() -> None:
    model = spec_of(load("cart_three_links")).compile()
    q = np.zeros((1, 3, 4))
    q[0, 1, 3] = np.nan
    position = runs(model, q).pose(1).position
    assert np.isfinite(position[0, [0, 2]]).all()
    assert np.isnan(position[0, 1]).all()
