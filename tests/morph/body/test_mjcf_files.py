from __future__ import annotations

import re
from pathlib import Path

import mujoco
import pytest

from morph.body.finding import DescriptionFinding
from morph.body.load import load
from morph.body.mesh import as_stl
from morph.body.robot import Robot
from morph.body.urdf_shapes import ellipsoid
from morph.errors import DescriptionRefused

STL = as_stl(ellipsoid(0.1, 0.2, 0.3))
INERTIAL = "<inertial pos='0 0 0' mass='2' diaginertia='1 1 1'/>"
BODY = f"<body name='a'><joint name='j'/>{INERTIAL}{{}}</body>"


def mjcf(folder: Path, body: str = BODY, *, top: str = "", name: str = "robot.xml") -> Path:
    """Write an MJCF of one body, with elements before it."""
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"<mujoco model='m'>\n{top}\n<worldbody>\n{body}\n</worldbody>\n</mujoco>")
    return path


def put(folder: Path, name: str, content: bytes = STL) -> Path:
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)
    return path


def codes(robot: Robot) -> list[tuple[str, str]]:
    return [(each.severity, each.code) for each in robot.findings if each.severity != "info"]


def refusal(path: Path) -> DescriptionFinding:
    """Return the one finding of severity `refused`."""
    with pytest.raises(DescriptionRefused) as refused:
        load(path)
    (found,) = [each for each in refused.value.findings if each.severity == "refused"]
    return found


def test_an_include_is_read_and_its_lines_are_its_own(tmp_path: Path) -> None:
    part = "<mujocoinclude>\n\n<body name='b'><joint/><inertial pos='0 0 0' mass='1' "
    part += "diaginertia='1 1 9'/></body></mujocoinclude>"
    put(tmp_path, "parts/leg.xml", part.encode())
    robot = load(mjcf(tmp_path, BODY.format("<include file='parts/leg.xml'/>")))
    assert [link.name for link in robot.links] == ["a", "b"]
    assert robot.mass == 3.0
    (broken,) = [each for each in robot.findings if each.code == "inertia-broken"]
    assert (broken.where.name, broken.where.line) == ("b", 3)
    assert broken.where.file == str((tmp_path / "parts" / "leg.xml").resolve())


def test_includes_are_as_mujoco_puts_them_together(tmp_path: Path) -> None:
    put(
        tmp_path,
        "sizes.xml",
        b"<mujocoinclude><default><geom size='0.3'/></default></mujocoinclude>",
    )
    put(tmp_path, "all.xml", b"<mujocoinclude><include file='sizes.xml'/></mujocoinclude>")
    text = "<body name='a'><joint/><geom/></body>"
    path = mjcf(tmp_path, text, top="<include file='all.xml'/>")
    direct = mujoco.MjModel.from_xml_path(str(path))
    # 4/3 pi 0.3^3 at the 1000 kg/m3 of water.
    assert direct.body_mass.sum() == pytest.approx(113.097, abs=1e-3)
    assert load(path).mass == pytest.approx(direct.body_mass.sum(), rel=1e-12)


@pytest.mark.parametrize(
    ("file", "why"),
    [
        ("gone.xml", "is not there"),
        ("../outside.xml", "lies outside its folder"),
        ("robot.xml", "is included twice"),
        ("loop.xml", "is included twice"),
        ("link.xml", "lies outside its folder|is not there"),
        ("", "is not there"),
    ],
)
def test_an_include_that_leads_nowhere_is_refused(file: str, why: str, tmp_path: Path) -> None:
    folder = tmp_path / "mine"
    put(tmp_path, "outside.xml", b"<mujocoinclude/>")
    put(folder, "loop.xml", b"<mujocoinclude><include file='loop.xml'/></mujocoinclude>")
    (folder / "link.xml").symlink_to(tmp_path / "outside.xml")
    found = refusal(mjcf(folder, top=f"<include file='{file}'/>"))
    assert re.search(why, found.what)
    assert found.code == "file-refused"


MESH = "<asset><mesh name='part' file='{}'/></asset>"
GEOM = "<geom name='g' type='mesh' mesh='part' mass='0'/>"


def test_a_missing_mesh_takes_its_geoms_and_nothing_else(tmp_path: Path) -> None:
    path = mjcf(tmp_path, BODY.format(f"{GEOM}<geom size='1'/>"), top=MESH.format("gone.stl"))
    robot = load(path)
    assert codes(robot) == [("repaired", "mesh-missing")]
    (found,) = [each for each in robot.findings if each.code == "mesh-missing"]
    assert (found.where.kind, found.where.name, found.where.line) == ("mesh", "part", 2)
    assert "gone.stl" in found.what
    assert robot.links[0].shapes == ("collision sphere",)
    assert robot.mass == 2.0


@pytest.mark.parametrize(
    ("inertial", "geom", "told"),
    [
        (INERTIAL, "", False),
        ("", "", True),
        ("", "mass='0'", False),
        ("", "density='0'", False),
        ("", "class='seen'", False),
        ("", "mass='1'", True),
    ],
    ids=["inertial", "by density", "massless", "no density", "class", "by mass"],
)
def test_mass_that_goes_with_a_mesh_is_not_lost_in_silence(
    inertial: str, geom: str, told: bool, tmp_path: Path
) -> None:
    body = f"<body name='a'><joint/>{inertial}<geom size='1' mass='4'/>"
    body += f"<geom type='mesh' mesh='part' {geom}/></body>"
    top = "<default><default class='seen'><geom density='0'/></default></default>"
    robot = load(mjcf(tmp_path, body, top=top + MESH.format("gone.stl")))
    assert robot.mass == (2.0 if inertial else 4.0)
    where = [each.where.name for each in robot.findings if each.code == "mass-missing"]
    assert where == (["a"] if told else [])


@pytest.mark.parametrize(
    ("compiler", "folder", "written"),
    [
        ("", "", "part.stl"),
        ("meshdir='meshes'", "meshes", "part.stl"),
        ("meshdir='meshes/'", "meshes", "part.stl"),
        ("assetdir='all'", "all", "part.stl"),
        ("meshdir='meshes' assetdir='all'", "meshes", "part.stl"),
        ("strippath='true' meshdir='meshes'", "meshes", "/far/away/part.stl"),
        ("meshdir='meshes'", "meshes/left", "left/part.stl"),
    ],
)
def test_a_mesh_is_found_where_the_compiler_says(
    compiler: str, folder: str, written: str, tmp_path: Path
) -> None:
    put(tmp_path, f"{folder}/part.stl".lstrip("/"))
    top = f"<compiler {compiler}/>" + MESH.format(written)
    robot = load(mjcf(tmp_path, BODY.format(GEOM), top=top))
    assert robot.links[0].shapes == ("collision mesh",)
    assert set(robot.assets.values()) == {STL}
    # A path that begins elsewhere is told, unless MuJoCo itself was to strip it.
    assert {code for _, code in codes(robot)} <= {"mesh-path"}


@pytest.mark.parametrize(
    ("there", "code"),
    [("Part.STL", "mesh-case"), ("deep/down/part.stl", "mesh-path")],
)
def test_a_mesh_elsewhere_is_taken_and_told(there: str, code: str, tmp_path: Path) -> None:
    put(tmp_path, there)
    robot = load(mjcf(tmp_path, BODY.format(GEOM), top=MESH.format("part.stl")))
    assert codes(robot) == [("repaired", code)]
    assert robot.links[0].shapes == ("collision mesh",)


@pytest.mark.parametrize("how", ["above", "absolute", "link"])
def test_a_mesh_outside_is_not_read(how: str, tmp_path: Path) -> None:
    outside, folder = put(tmp_path, "secret.stl"), tmp_path / "mine"
    folder.mkdir()
    (folder / "here.stl").symlink_to(outside)
    written = {"above": "../secret.stl", "absolute": str(outside), "link": "here.stl"}[how]
    robot = load(mjcf(folder, BODY.format(GEOM), top=MESH.format(written)))
    assert codes(robot) == [("repaired", "mesh-outside")]
    assert robot.assets == {}
    # What is printed helps.
    outer = robot.findings[0].fix.partition("--folder ")[2]
    assert codes(load(folder / "robot.xml", folder=outer)) == []


ASCII = b"""solid a
facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet
facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0 1 0\nvertex 0 0 1\nendloop\nendfacet
facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0 0 1\nvertex 1 0 0\nendloop\nendfacet
facet normal 0 0 1\nouter loop\nvertex 1 0 0\nvertex 0 0 1\nvertex 0 1 0\nendloop\nendfacet
endsolid a"""


def test_a_mesh_in_a_format_that_mujoco_lacks_is_written_anew(tmp_path: Path) -> None:
    put(tmp_path, "part.stl", ASCII)
    path = mjcf(tmp_path, BODY.format(GEOM), top=MESH.format("part.stl"))
    with pytest.raises(ValueError, match="STL"):
        mujoco.MjModel.from_xml_path(str(path))
    assert load(path).links[0].shapes == ("collision mesh",)


@pytest.mark.parametrize(
    ("content", "code"),
    [
        (b"", "mesh-empty"),
        (b"rubbish" * 50, "mesh-unreadable"),
        (b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n", "mesh-lfs-stub"),
    ],
)
def test_a_mesh_that_is_none_is_left_out(content: bytes, code: str, tmp_path: Path) -> None:
    put(tmp_path, "part.stl", content)
    robot = load(mjcf(tmp_path, BODY.format(GEOM), top=MESH.format("part.stl")))
    assert codes(robot) == [("repaired", code)]
    assert robot.links[0].shapes == ()


def test_a_mesh_without_a_name_that_is_missing_takes_no_default_with_it(tmp_path: Path) -> None:
    path = mjcf(tmp_path, top='<default><mesh name="" filename=""/></default>')
    assert [joint.name for joint in load(path).joints] == ["j"]
