from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from morph.arrays import Array
from morph.body.convert import FORMATS, convert
from morph.body.load import load
from morph.body.numbers import rotation
from morph.body.urdf_shapes import angles


@pytest.mark.parametrize("to", FORMATS)
def test_shapes_stay_where_they_are(to: str, tmp_path: Path) -> None:
    robot = load("quadruped_printed")
    before = mujoco.MjModel.from_xml_path(str(robot.source))
    path = convert(robot, to, tmp_path / "out").files[0]
    after = mujoco.MjModel.from_xml_path(str(path))
    one, other = corners(before), corners(after)
    assert one.keys() <= other.keys()
    # Mesh files hold float32: 6e-8 of lengths below 0.2 m.
    assert max(np.abs(one[name] - other[name]).max() for name in one) < 1e-7


def corners(model: Any) -> dict[str, Array]:
    """Return the box, in the world, around each link's shapes, shape (2, 3)."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    signs = np.array(np.meshgrid((-1, 1), (-1, 1), (-1, 1))).reshape(3, -1).T
    points: dict[str, list[Array]] = {}
    for geom in range(model.ngeom):
        turn = data.geom_xmat[geom].reshape(3, 3)
        if model.geom_type[geom] == 7:
            mesh = model.geom_dataid[geom]
            first = model.mesh_vertadr[mesh]
            inner = model.mesh_vert[first : first + model.mesh_vertnum[mesh]]
        else:
            inner = model.geom_aabb[geom, :3] + signs * model.geom_aabb[geom, 3:]
        name = model.body(model.geom_bodyid[geom]).name
        points.setdefault(name, []).append(inner @ turn.T + data.geom_xpos[geom])
    stacked = {name: np.concatenate(held) for name, held in points.items()}
    return {name: np.array([all_.min(axis=0), all_.max(axis=0)]) for name, all_ in stacked.items()}


@pytest.mark.parametrize("away", [0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3, 1.0])
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_angles_are_those_of_the_same_rotation(away: float, sign: float) -> None:
    rng = np.random.default_rng(8)
    for roll, yaw in rng.uniform(-3, 3, size=(20, 2)):
        turn = Rotation.from_euler("xyz", (roll, sign * (np.pi / 2 - away), yaw)).as_matrix()
        # One rounding of each product: a few times 2.2e-16, however near to straight up.
        assert np.abs(rotation(*angles(turn)) - turn).max() < 3e-15
