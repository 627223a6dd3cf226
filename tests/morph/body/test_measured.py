"""Weighed masses come before those of the description."""

from __future__ import annotations

from pathlib import Path

import pytest

from morph.body.agreement import disagreement
from morph.body.load import load
from morph.errors import RobotError

URDF = """<robot name="lever"><link name="base"/><link name="arm"><inertial><mass value="2"/>
<inertia ixx="1" iyy="2" izz="2.5" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hinge" type="continuous"><parent link="base"/><child link="arm"/></joint></robot>"""

MJCF = """<mujoco model="lever"><worldbody><body name="arm"><joint name="hinge"/>
<geom type="box" size="0.1 0.2 0.3" density="1000"/></body></worldbody></mujoco>"""


def lever(folder: Path, description: str, text: str, card: str) -> Path:
    (folder / "lever").mkdir()
    (folder / "lever" / description).write_text(text)
    (folder / "lever" / "card.toml").write_text(
        'schema = "morph.card/1"\nname = "lever"\ntitle = "Lever"\n'
        f'description = "{description}"\nbase = "fixed"\nsource = []\n'
        f'licence = "Apache-2.0"\n{card}'
    )
    return folder / "lever"


def weighed(link: str, mass: float) -> str:
    return f'[[measured]]\nlink = "{link}"\nmass_kg = {mass}\n'


def test_a_weighed_link_keeps_the_form_of_its_inertia(tmp_path: Path) -> None:
    link = load(lever(tmp_path, "a.urdf", URDF, weighed("arm", 3.0))).link("arm")
    assert link.mass == 3.0
    assert disagreement(load(tmp_path / "lever")) == []
    # Half as much again of everything: 1.5, 3.0, 3.75 kg m2.
    assert link.inertia == pytest.approx((1.5, 3.0, 3.75, 0, 0, 0), abs=1e-12)
    assert link.inertia_from == "measured"


def test_a_weighed_link_without_inertia_takes_the_form_of_its_shape(tmp_path: Path) -> None:
    box = '<collision><geometry><box size="0.1 0.2 0.3"/></geometry></collision></link>'
    bare = f'<robot name="lever"><link name="base"/><link name="arm">{box}'
    text = bare + URDF[URDF.index("<joint") :]
    robot = load(lever(tmp_path, "a.urdf", text, weighed("arm", 6.0)))
    # 6 kg: xx = 6 / 12 (0.2^2 + 0.3^2) = 0.065 kg m2.
    assert robot.link("arm").mass == 6.0
    assert robot.link("arm").inertia[0] == pytest.approx(0.065, abs=1e-12)
    assert robot.link("arm").inertia_from == "measured"
    assert "mass-missing" not in {finding.code for finding in robot.findings}


def test_a_weighed_body_of_mjcf_too(tmp_path: Path) -> None:
    # The box weighs 48 kg by its density, and 2.08 kg m2 about x.
    link = load(lever(tmp_path, "a.xml", MJCF, weighed("arm", 24.0))).link("arm")
    assert link.mass == pytest.approx(24.0, abs=1e-12)
    assert link.inertia[0] == pytest.approx(1.04, abs=1e-12)
    assert link.inertia_from == "measured"


def test_without_a_scale_the_description_counts(tmp_path: Path) -> None:
    assert load(lever(tmp_path, "a.urdf", URDF, "")).link("arm").inertia_from == "description"


@pytest.mark.parametrize(
    ("card", "message"),
    [
        (weighed("leg", 3.0), "its card weighs the link 'leg', and it has base, arm"),
        (weighed("arm", 0.0), "its card says that 'arm' weighs 0 kg"),
        (weighed("arm", -1.0), "its card says that 'arm' weighs -1 kg"),
    ],
)
def test_what_no_scale_shows_is_refused(tmp_path: Path, card: str, message: str) -> None:
    with pytest.raises(RobotError, match=message):
        load(lever(tmp_path, "a.urdf", URDF, card))
