"""A four-bar that a URDF cannot hold, closed by its card."""

from __future__ import annotations

import math
from pathlib import Path

import mujoco
import numpy as np
import pytest

from morph.body.load import load
from morph.body.mesh import Mesh, as_stl
from morph.body.spec import spec_of
from morph.errors import RobotError

# A parallelogram: ground 0.1 m along x, cranks of 0.05 m standing up, a coupler of 0.1 m.
LINK = (
    '<link name="{name}"><inertial><origin xyz="{com}"/><mass value="0.01"/>'
    '<inertia ixx="1e-5" iyy="1e-5" izz="1e-5" ixy="0" ixz="0" iyz="0"/></inertial>{shape}</link>'
)
JOINT = (
    '<joint name="{child}" type="continuous"><parent link="{parent}"/><child link="{child}"/>'
    '<origin xyz="{at}"/><axis xyz="0 1 0"/></joint>'
)
VISUAL = (
    '<visual><geometry><mesh filename="bar.stl" scale="0.001 0.001 0.001"/></geometry></visual>'
)
URDF = (
    '<robot name="gate"><link name="ground"/>'
    + LINK.format(name="crank", com="0 0 0.025", shape=VISUAL)
    + LINK.format(name="coupler", com="0.05 0 0", shape="")
    + LINK.format(name="rocker", com="0 0 0.025", shape=VISUAL)
    + JOINT.format(parent="ground", child="crank", at="0 0 0")
    + JOINT.format(parent="crank", child="coupler", at="0 0 0.05")
    + JOINT.format(parent="ground", child="rocker", at="0.1 0 0")
    + "</robot>"
)


def gate(folder: Path, closure: str) -> Path:
    (folder / "gate").mkdir()
    corners = np.array([(0, 0, 0), (4.0, 0, 0), (0, 4.0, 0), (0, 0, 50.0)])
    bar = Mesh(vertices=corners, faces=np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]))
    (folder / "gate" / "bar.stl").write_bytes(as_stl(bar))
    (folder / "gate" / "gate.urdf").write_text(URDF)
    (folder / "gate" / "card.toml").write_text(
        'schema = "morph.card/1"\nname = "gate"\ntitle = "Gate"\ndescription = "gate.urdf"\n'
        f'base = "fixed"\nsource = []\nlicence = "Apache-2.0"\n{closure}'
    )
    return folder / "gate"


CLOSED = """[[motor]]
actuator = "crank"
[[closure]]
kind = "four-bar"
bodies = ["rocker", "crank", "coupler"]
pin = [0.1, 0.0, 0.0]
pin_on_first = [0.0, 0.0, 0.05]
"""


def test_a_card_closes_the_four_bar_that_its_urdf_leaves_open(tmp_path: Path) -> None:
    robot = load(gate(tmp_path, CLOSED))
    assert [loop.links for loop in robot.loops] == [("coupler", "rocker")]
    assert [actuator.name for actuator in robot.actuators] == ["crank"]
    model = spec_of(robot).compile()
    data = mujoco.MjData(model)
    data.ctrl[0] = 0.002
    for _ in range(500):
        mujoco.mj_step(model, data)
    crank, coupler, rocker = (
        data.qpos[model.joint(name).qposadr[0]] for name in ("crank", "coupler", "rocker")
    )
    assert abs(crank) > 0.3
    # A parallelogram: the rocker turns as the crank does, the coupler stays level. The pin is a
    # stiff spring, whose gap was measured at some micrometres on bars of 50 mm: 1e-3 rad.
    assert math.isclose(rocker, crank, abs_tol=1e-3)
    assert math.isclose(coupler, -crank, abs_tol=1e-3)


def test_a_pin_whose_ends_do_not_meet_is_refused(tmp_path: Path) -> None:
    wrong = CLOSED.replace("pin = [0.1, 0.0, 0.0]", "pin = [0.12, 0.0, 0.0]")
    with pytest.raises(RobotError, match="are 20 mm apart"):
        load(gate(tmp_path, wrong))


def test_a_closure_of_links_that_are_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RobotError, match="lever"):
        load(gate(tmp_path, CLOSED.replace('"rocker", "crank"', '"lever", "crank"')))


def test_an_mjcf_closes_its_own_chains(tmp_path: Path) -> None:
    folder = gate(tmp_path, CLOSED)
    (folder / "gate.xml").write_text(load(folder).mjcf)
    card = folder / "card.toml"
    card.write_text(card.read_text().replace("gate.urdf", "gate.xml"))
    with pytest.raises(RobotError, match="which an MJCF does itself"):
        load(folder)
