"""Any file becomes a robot or a refusal with findings, whatever it is called and holds."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import mujoco
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from morph.body.description import BASES, ENDINGS, read_description
from morph.body.finding import CODES, DescriptionFinding
from morph.body.load import load
from morph.body.spec import spec_of
from morph.errors import DescriptionRefused, RobotError

BOX = '<geom type="box" size="0.1 0.2 0.3" density="1000"/>'
BODY = f'<body name="a"><joint name="j"/>{BOX}</body>'
MJCF = f'<mujoco model="m"><worldbody>{BODY}</worldbody></mujoco>'
URDF = (
    '<robot name="u"><link name="a"><inertial><mass value="2"/>'
    '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>'
)


def write(folder: Path, name: str, content: str | bytes) -> Path:
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def refused(path: Path, **more: Any) -> tuple[DescriptionFinding, ...]:
    """Return the findings of a refusal."""
    with pytest.raises(DescriptionRefused) as caught:
        read_description(path, **more)
    assert caught.value.what
    assert caught.value.fix
    findings: tuple[DescriptionFinding, ...] = caught.value.findings
    assert any(finding.severity == "refused" for finding in findings)
    assert all(finding.code in CODES and finding.fix for finding in findings)
    return findings


@pytest.mark.parametrize("ending", [".urdf", ".URDF", ".xml", ".mjcf"])
@pytest.mark.parametrize(("text", "mass"), [(MJCF, 48.0), (URDF, 2.0)])
def test_what_a_file_is_follows_from_its_root_and_not_from_its_ending(
    tmp_path: Path, ending: str, text: str, mass: float
) -> None:
    # A box of 0.2 x 0.4 x 0.6 m of water weighs 48 kg.
    robot = read_description(write(tmp_path, f"robot{ending}", text), base="fixed")
    assert robot.mass == pytest.approx(mass, rel=1e-12)


@pytest.mark.parametrize("ending", ["", ".txt", ".stl", ".sdf", ".urdf.bak", ".urd", ".zip"])
def test_an_ending_that_no_description_has_is_refused_with_those_that_some_have(
    tmp_path: Path, ending: str
) -> None:
    (finding,) = refused(write(tmp_path, f"robot{ending}", URDF))
    assert (finding.code, finding.where.kind) == ("file-refused", "file")
    assert all(known in finding.fix for known in ENDINGS)


@pytest.mark.parametrize(
    "root", ["sdf", "html", "svg", "package", "Robot", "robots", "mjcf", "x:robot"]
)
def test_a_root_that_no_description_has_is_refused_by_its_name(tmp_path: Path, root: str) -> None:
    (finding,) = refused(write(tmp_path, "robot.urdf", f"\n<{root}/>"))
    assert finding.code == "file-refused"
    assert f"<{root}>" in finding.what
    assert finding.where.line == 2


@pytest.mark.parametrize("text", ["<robot/>", "<mujoco/>", "<mujoco><worldbody/></mujoco>"])
def test_a_description_of_nothing_is_refused(tmp_path: Path, text: str) -> None:
    assert [finding.severity for finding in refused(write(tmp_path, "robot.xml", text))] == [
        "refused"
    ]


def test_a_file_that_is_not_there_or_is_none_is_refused(tmp_path: Path) -> None:
    (tmp_path / "folder.urdf").mkdir()
    (tmp_path / "broken.urdf").symlink_to("nothing.urdf")
    (tmp_path / "circle.urdf").symlink_to("circle.urdf")
    for name in ("missing.urdf", "folder.urdf", "broken.urdf", "circle.urdf"):
        (finding,) = refused(tmp_path / name)
        assert finding.code == "file-refused"


def test_a_name_without_a_robot_takes_that_of_its_file(tmp_path: Path) -> None:
    text = URDF.replace(' name="u"', "")
    assert read_description(write(tmp_path, "arm.urdf", text), base="fixed").name == "arm"


def dof(robot: Any) -> int:
    return int(spec_of(robot).compile().nv)


@pytest.mark.parametrize("world", [False, True])
@pytest.mark.parametrize(("base", "freedoms"), [("fixed", 0), ("floating", 6), ("board", 1)])
def test_a_base_stands_as_it_is_told_and_its_mass_counts(
    bench: Any, base: str, freedoms: int, world: bool
) -> None:
    elements = [bench.link("trunk", mass=3.0), bench.link("arm"), bench.joint("j", "trunk", "arm")]
    if world:
        elements += ['<link name="world"/>', bench.joint("foot", "world", "trunk", "fixed")]
    reading = bench.read(*elements, base=base)
    assert reading.findings == ()
    assert dof(reading.robot) == freedoms + 1
    model = spec_of(reading.robot).compile()
    assert model.body_mass.sum() == 4.0 == reading.robot.mass


def test_a_base_that_nobody_decided_is_bolted_and_it_is_said(bench: Any) -> None:
    reading = bench.read(bench.link("trunk", mass=3.0), base=None)
    finding = reading.the("base-assumed")
    assert (finding.severity, finding.where.kind, finding.where.name) == ("info", "robot", "robot")
    assert "'trunk'" in finding.what
    assert reading.robot.mass == 3.0
    assert dof(reading.robot) == 0


def test_a_base_that_the_description_ties_to_the_world_needs_no_word(bench: Any) -> None:
    tied = bench.joint("foot", "world", "trunk", "fixed")
    assert bench.read('<link name="world"/>', bench.link("trunk"), tied, base=None).findings == ()


def test_a_board_slides_along_x_and_holds_all_else(bench: Any) -> None:
    model = spec_of(bench.read(bench.link("trunk"), base="board").robot).compile()
    assert model.jnt_type[0] == mujoco.mjtJoint.mjJNT_SLIDE
    assert model.jnt_axis[0] == pytest.approx([1, 0, 0])


def test_the_flag_comes_before_the_card(bench: Any) -> None:
    path = bench.write(bench.link("trunk"))
    (path.parent / "card.toml").write_text(
        'schema = "morph.card/1"\nname = "bench"\ntitle = "R"\ndescription = "robot.urdf"\n'
        'base = "floating"\nsource = []\nlicence = "Apache-2.0"\n'
    )
    assert dof(load(path)) == 6
    assert dof(load(path, base="fixed")) == 0


@pytest.mark.parametrize("base", ["", "flying", "Fixed"])
def test_a_base_that_there_is_not_is_an_error_with_those_that_there_are(
    bench: Any, base: str
) -> None:
    path = bench.write(bench.link("trunk"))
    if base == "":
        assert read_description(path, base=base).findings[0].code == "base-assumed"
        return
    with pytest.raises(RobotError, match=", ".join(BASES)):
        read_description(path, base=base)


@pytest.mark.parametrize("name", ["root", "board", "p_x", "world", "trunk"])
@pytest.mark.parametrize("base", BASES)
def test_names_that_morph_and_mujoco_use_themselves_may_be_used(
    bench: Any, name: str, base: str
) -> None:
    reading = bench.read(
        *(bench.link(link) for link in ("trunk", "leg", "board", "root")),
        bench.joint("p", "trunk", "leg", "planar"),
        bench.joint(name, "leg", "board"),
        bench.joint("last", "board", "root", "floating"),
        base=base,
    )
    assert reading.findings == ()
    assert reading.robot.joint(name).link == "board"
    assert reading.robot.mass == 4.0


def test_a_refusal_tells_everything_that_is_wrong_and_not_the_first_only(bench: Any) -> None:
    reading = bench.read(
        bench.link("a"),
        bench.link("b"),
        bench.joint("one", "a", "nobody"),
        bench.joint("two", "nothing", "b"),
        bench.joint("three", "a", "b", axis="0 0 0"),
    )
    told = {(finding.code, finding.where.name) for finding in reading.findings}
    assert {("dangling-joint", "one"), ("dangling-joint", "two"), ("joint-axis", "three")} <= told


def test_findings_are_json_with_the_keys_of_the_schema(bench: Any) -> None:
    reading = bench.read(bench.link("a", bench.mesh("gone.stl")), bench.link("b"), base=None)
    told = json.loads(json.dumps([finding.as_json() for finding in reading.findings]))
    assert told
    for finding in told:
        assert finding.keys() == {"code", "severity", "where", "what", "done", "fix"}
        assert finding["where"].keys() == {"kind", "name", "file", "line"}


NAMES = st.sampled_from(["a", "b", "c", "world", "root", ""])
NUMBERS = st.sampled_from(["0", "1", "-1", "1e-300", "1e300", "nan", "inf", "x", "", "0.1 0.2 0.3"])
KINDS = st.sampled_from(["revolute", "continuous", "prismatic", "fixed", "floating", "planar", "x"])


@st.composite
def wild(draw: st.DrawFn) -> str:
    """Draw a URDF with every element in it, right or wrong."""
    links = [
        f'<link name="{draw(NAMES)}"><inertial><origin xyz="{draw(NUMBERS)}"/>'
        f'<mass value="{draw(NUMBERS)}"/><inertia ixx="{draw(NUMBERS)}" iyy="{draw(NUMBERS)}" '
        f'izz="{draw(NUMBERS)}" ixy="{draw(NUMBERS)}"/></inertial><collision><geometry>'
        f"<{draw(st.sampled_from(['box', 'sphere', 'cylinder', 'capsule', 'mesh']))} "
        f'size="{draw(NUMBERS)}" radius="{draw(NUMBERS)}" length="{draw(NUMBERS)}" '
        f'filename="{draw(NUMBERS)}"/></geometry></collision></link>'
        for _ in range(draw(st.integers(0, 4)))
    ]
    joints = [
        f'<joint name="{draw(NAMES)}" type="{draw(KINDS)}"><parent link="{draw(NAMES)}"/>'
        f'<child link="{draw(NAMES)}"/><axis xyz="{draw(NUMBERS)}"/><limit lower="{draw(NUMBERS)}" '
        f'upper="{draw(NUMBERS)}" effort="{draw(NUMBERS)}" velocity="{draw(NUMBERS)}"/>'
        f'<mimic joint="{draw(NAMES)}" multiplier="{draw(NUMBERS)}"/>'
        f'<dynamics damping="{draw(NUMBERS)}"/></joint>'
        for _ in range(draw(st.integers(0, 3)))
    ]
    return "<robot>" + "".join(draw(st.permutations([*links, *joints]))) + "</robot>"


@settings(
    deadline=None, max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(text=wild(), base=st.sampled_from(BASES))
def test_any_structure_is_a_robot_or_a_refusal_and_never_a_traceback(
    tmp_path: Path, text: str, base: str
) -> None:
    path = write(tmp_path, "wild.urdf", text)
    try:
        robot = read_description(path, base=base)
    except DescriptionRefused as error:
        told = error.findings
        assert any(finding.severity == "refused" for finding in told)
    else:
        told = robot.findings
        assert all(finding.severity != "refused" for finding in told)
        assert spec_of(robot).compile().body_mass.sum() == pytest.approx(robot.mass)
    assert all(finding.where.name is not None and finding.fix for finding in told)
