from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from morph.app.picture.scene import FLOOR, rounded, scene_model, settle
from morph.body import shelf
from morph.body.load import load
from morph.physics.contact.contact_friction import ContactFriction
from morph.physics.world.ground import Ground
from morph.sim.simulator import Simulator

OWN = """<mujoco><asset><material name="own" rgba="1 0 0 1"/></asset><worldbody>
<light name="own" pos="0 0 3"/><geom name="ground" type="plane" size="1 1 1" material="own"/>
<body name="a" pos="0 0 1"><freejoint/><geom size="0.1"/></body></worldbody></mujoco>"""


@pytest.mark.parametrize("name", shelf.names())
def test_the_scene_changes_nothing_that_moves(name: str) -> None:
    robot = load(name)
    plain, drawn = Simulator(robot).model, scene_model(robot, (), (640, 360))
    assert (drawn.nq, drawn.nv, drawn.nbody) == (plain.nq, plain.nv, plain.nbody)
    assert np.array_equal(drawn.body_mass, plain.body_mass)
    assert drawn.geom(FLOOR).contype[0] == drawn.geom(FLOOR).conaffinity[0] == 0


def test_what_a_description_has_of_its_own_is_kept(tmp_path: Path) -> None:
    (tmp_path / "own.xml").write_text(OWN)
    model = scene_model(load(tmp_path / "own.xml"), (), (640, 360))
    assert model.nlight == 1
    assert [model.geom(index).name for index in range(model.ngeom)].count(FLOOR) == 0
    assert model.mat(int(model.geom("ground").matid[0])).name == "own"


def test_a_ground_that_acts_is_the_floor_that_is_seen() -> None:
    swimmer = load("hexapod_swimmer")
    there = scene_model(swimmer, (Ground(height=0.3),), (640, 360))
    assert [there.geom(index).name for index in range(there.ngeom)].count(FLOOR) == 0
    settle(there, -5.0, 1.0, wet=False)
    assert there.geom("floor").pos[2] == 0.3
    assert there.mat(int(there.geom("floor").matid[0])).name == FLOOR
    # A floor that is out of reach is none: one is drawn where the robot is.
    away = scene_model(swimmer, (ContactFriction(contact="any+floor", mu=0.4),), (640, 360))
    settle(away, -5.0, 1.0, wet=False)
    assert away.geom(FLOOR).pos[2] == -5.0


@pytest.mark.parametrize("wet", [False, True])
def test_the_floor_lies_below_all_that_moves(wet: bool) -> None:
    model = scene_model(load("pendulum"), (), (640, 360))
    settle(model, -0.55, 0.6, wet=wet)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    # In the water it lies deeper, by 0.6 of the radius.
    due = -0.55 - 0.36 * wet
    assert data.geom_xpos[model.geom(FLOOR).id] == pytest.approx([0.0, 0.0, due])


@pytest.mark.parametrize(
    ("length", "due"), [(0.3, 0.2), (0.5, 0.5), (1.0, 1.0), (0.09, 0.05), (19.0, 10.0)]
)
def test_tiles_have_a_round_width(length: float, due: float) -> None:
    assert rounded(length) == pytest.approx(due)
