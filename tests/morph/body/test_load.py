"""What loads, and what is refused with one clear message."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from morph.body import shelf
from morph.body.load import load
from morph.body.spec import spec_of
from morph.errors import RobotError

MJCF = """<mujoco model="lever"><worldbody><body name="lever"><joint name="hinge"/>
<geom type="box" size="0.1 0.2 0.3" density="1000"/></body></worldbody></mujoco>"""

URDF = """<robot name="lever"><link name="world"/>
<link name="lever"><inertial><mass value="2"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hinge" type="continuous"><parent link="world"/><child link="lever"/></joint></robot>"""


def lever(folder: Path, *, card: str = "", description: str = MJCF) -> Path:
    """Return a folder `lever` with a description and a card with more keys."""
    (folder / "lever").mkdir()
    (folder / "lever" / "robot.xml").write_text(description)
    (folder / "lever" / "card.toml").write_text(
        'schema = "morph.card/1"\nname = "lever"\ntitle = "Lever"\ndescription = "robot.xml"\n'
        f'base = "fixed"\nsource = []\nlicence = "Apache-2.0"\n{card}'
    )
    return folder / "lever"


@pytest.mark.parametrize("name", shelf.names())
def test_every_robot_on_the_shelf_is_what_its_card_says(name: str) -> None:
    robot = load(name)
    assert robot.name == name
    assert robot.card is not None
    assert robot.card.checks.mass_kg == pytest.approx(robot.mass, abs=1e-9)
    assert [motor.actuator for motor in robot.card.motor] == [
        actuator.name for actuator in robot.actuators
    ]
    assert robot.card.source
    assert len(robot.sha256) == 64


def test_the_shelf_holds_the_first_five_robots() -> None:
    first = {"pendulum", "cartpole", "double_pendulum", "double_pendulum_a0", "so101"}
    assert first <= set(shelf.names())


def test_a_shelf_of_ones_own_is_searched(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    lever(tmp_path)
    monkeypatch.setenv("MORPH_SHELF", str(tmp_path))
    assert "lever" in shelf.names()
    assert load("lever").name == "lever"


def test_mass_and_inertia_of_a_box_come_from_its_shape(tmp_path: Path) -> None:
    # 0.2 * 0.4 * 0.6 m3 * 1000 kg/m3 = 48 kg; xx = m (0.4^2 + 0.6^2) / 12 = 2.08,
    # yy = m (0.2^2 + 0.6^2) / 12 = 1.6, zz = m (0.2^2 + 0.4^2) / 12 = 0.8 kg m2.
    link = load(lever(tmp_path, card="checks = { mass_kg = 48.0, dof = 1 }\n")).link("lever")
    assert link.mass == pytest.approx(48.0, abs=1e-12)
    assert link.inertia == pytest.approx((2.08, 1.6, 0.8, 0.0, 0.0, 0.0), abs=1e-12)


def test_an_xml_file_without_a_card_loads_under_its_models_name(tmp_path: Path) -> None:
    path = tmp_path / "corrected.xml"
    path.write_text(load("double_pendulum").mjcf)
    again = load(path)
    assert again.name == "double_pendulum"
    assert again.card is None
    assert again.links == load("double_pendulum").links
    assert again.mjcf == load("double_pendulum").mjcf


def test_the_card_beside_a_file_is_used_if_it_names_the_file(tmp_path: Path) -> None:
    folder = lever(tmp_path)
    shutil.copy(folder / "robot.xml", folder / "other.xml")
    assert load(folder / "robot.xml").card is not None
    assert load(folder / "other.xml").card is None


def test_a_urdf_without_a_card_has_a_motor_per_joint(tmp_path: Path) -> None:
    path = tmp_path / "lever.urdf"
    path.write_text(URDF)
    robot = load(path)
    assert [(a.name, a.joint, a.kind) for a in robot.actuators] == [("hinge", "hinge", "motor")]


def test_a_urdf_has_the_servo_that_its_card_names(tmp_path: Path) -> None:
    folder = lever(tmp_path, card='[[motor]]\nactuator = "hinge"\nmodel = "STS3215"\n')
    (folder / "robot.urdf").write_text(URDF)
    card = folder / "card.toml"
    card.write_text(card.read_text().replace("robot.xml", "robot.urdf"))
    assert load(folder).actuator("hinge").kind == "position"


@pytest.mark.parametrize(
    ("motor", "message"),
    [
        ('actuator = "wheel"', "the motor 'wheel' names no moving joint; there are hinge"),
        ('actuator = "hinge"\nmodel = "X1"', "no motor model is called 'X1'"),
    ],
)
def test_a_motor_that_a_urdf_cannot_have_is_refused(
    tmp_path: Path, motor: str, message: str
) -> None:
    folder = lever(tmp_path, card=f"[[motor]]\n{motor}\n")
    (folder / "robot.urdf").write_text(URDF)
    card = folder / "card.toml"
    card.write_text(card.read_text().replace("robot.xml", "robot.urdf"))
    with pytest.raises(RobotError, match=message):
        load(folder)


def test_a_floating_urdf_falls_freely(tmp_path: Path) -> None:
    folder = lever(tmp_path, card="checks = { mass_kg = 3.0, dof = 7 }\n")
    inertial = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" '
    inertial += 'ixy="0" ixz="0" iyz="0"/></inertial>'
    text = URDF.replace('<link name="world"/>', f'<link name="hull">{inertial}</link>')
    (folder / "robot.urdf").write_text(text.replace('parent link="world"', 'parent link="hull"'))
    card = folder / "card.toml"
    text = card.read_text().replace("robot.xml", "robot.urdf").replace("fixed", "floating")
    card.write_text(text)
    assert [joint.kind for joint in load(folder).joints] == ["free", "hinge"]


def test_the_hash_changes_with_the_card(tmp_path: Path) -> None:
    folder = lever(tmp_path)
    before = load(folder).sha256
    card = folder / "card.toml"
    card.write_text(card.read_text().replace("Lever", "Crowbar"))
    assert load(folder).sha256 != before


def test_a_mesh_travels_with_the_robot(tmp_path: Path) -> None:
    # A tetrahedron on three unit edges has a volume of 1/6 m3.
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "wedge.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    )
    path = tmp_path / "wedge.xml"
    path.write_text(
        '<mujoco><compiler meshdir="meshes"/><asset><mesh name="wedge" file="wedge.obj"/></asset>'
        '<worldbody><body name="wedge"><joint/><geom type="mesh" mesh="wedge" density="6"/></body>'
        "</worldbody></mujoco>"
    )
    robot = load(path)
    shutil.rmtree(tmp_path / "meshes")
    assert robot.mass == pytest.approx(1.0, abs=1e-9)
    assert spec_of(robot).compile().body_mass[1] == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("missing.xml", None, "cannot be read: No such file"),
        ("arm.stl", b"solid", r"files that end in '\.stl' cannot be read"),
        ("arm.xml", b"", "is empty"),
        ("arm.urdf", b" \n", "is empty"),
        ("arm.xml", b"\x80\x81", "is binary"),
        ("arm.xml", b"<mujoco>\0</mujoco>", "is binary"),
        ("arm.xml", b"<mujoco>", r"arm.xml:1: is not XML: no element found"),
        ("arm.urdf", b"<robot>", r"arm.urdf:1: is not XML: no element found"),
        ("arm.xml", b"<mujoco><wurldbody/></mujoco>", "MuJoCo cannot use it: .*wurldbody"),
        (
            "arm.xml",
            b"<mujoco><worldbody><body><joint/></body></worldbody></mujoco>",
            "MuJoCo cannot use it: .*mass and inertia",
        ),
        (
            "arm.xml",
            b'<mujoco><asset><mesh name="m" file="gone.stl"/></asset></mujoco>',
            "holds no body",
        ),
    ],
)
def test_a_file_that_cannot_be_used_is_named(
    tmp_path: Path, name: str, content: bytes | None, message: str
) -> None:
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(RobotError, match=message) as caught:
        load(path)
    assert str(path) in caught.value.where
    assert caught.value.fix


def test_an_unknown_name_is_answered_with_the_nearest() -> None:
    with pytest.raises(RobotError, match="no robot is called 'pendulm'; nearest: pendulum"):
        load("pendulm")


def test_a_folder_without_a_card_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RobotError, match=r"no card\.toml that says which"):
        load(tmp_path)


@pytest.mark.parametrize(
    ("card", "message"),
    [
        ("checks = { mass_kg = 47.9 }\n", "it weighs 48 kg, and its card says 47.9 kg"),
        ("checks = { dof = 2 }\n", "it has 1 degrees of freedom, and its card says 2"),
        ('[[motor]]\nactuator = "wheel"\n', "names an actuator 'wheel', and it has none"),
    ],
)
def test_a_robot_that_is_not_what_its_card_says_is_refused(
    tmp_path: Path, card: str, message: str
) -> None:
    with pytest.raises(RobotError, match=message):
        load(lever(tmp_path, card=card))


@pytest.mark.parametrize(
    ("operation", "link", "message"),
    [
        ("scael", "lever", "names the operation 'scael', which is not there; nearest: scale"),
        ("scale", "levre", "names the link 'levre', which is not there; nearest: lever"),
    ],
)
def test_a_parameter_that_varies_nothing_is_refused(
    tmp_path: Path, operation: str, link: str, message: str
) -> None:
    card = f'[[parameter]]\nname = "length"\noperation = "{operation}"\nlink = "{link}"\n'
    with pytest.raises(RobotError, match=message):
        load(lever(tmp_path, card=card + "low = 0.5\nhigh = 2.0\n"))
