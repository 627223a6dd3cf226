"""Meshes and a table of joints become a draft, and a robot; what is wrong is named by its line."""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from morph.body.cad import read_cad
from morph.body.description import read_description
from morph.body.mesh import Mesh, as_stl
from morph.errors import MeshError, RobotError

HEAD = 'schema = "morph.assembly/1"\nname = "crane"\nunit = "mm"\ndensity_kg_m3 = 1000.0\n'
BASE = '[[link]]\nname = "base"\nmesh = "base.stl"\n'
ARM = '[[link]]\nname = "arm"\nmesh = "meshes/arm.stl"\nmass_kg = 0.5\n'
HINGE = """[[joint]]
name = "hinge"
parent = "base"
child = "arm"
kind = "revolute"
origin = [0, 0, 40]
axis = [0, 2, 0]
limits_deg = [-90, 45]
effort = 2.5
"""


def box(size: tuple[float, ...], centre: tuple[float, ...]) -> bytes:
    """A closed box as STL, in millimetres."""
    corners = np.array(list(itertools.product((-0.5, 0.5), repeat=3))) * size + centre
    hull = Mesh(vertices=corners, faces=np.array([(0, 1, 2), (3, 4, 5), (6, 7, 0)])).hull
    return as_stl(hull)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A base of 60 x 40 x 20 mm and an arm of 100 x 10 x 10 mm that begins at its joint."""
    (tmp_path / "meshes").mkdir()
    (tmp_path / "base.stl").write_bytes(box((60, 40, 20), (0, 0, 10)))
    (tmp_path / "meshes" / "arm.stl").write_bytes(box((100, 10, 10), (50, 0, 0)))
    return tmp_path


def write(folder: Path, text: str) -> Path:
    path = folder / "assembly.toml"
    path.write_text(text)
    return path


def test_mass_is_density_times_volume_or_what_a_scale_showed(folder: Path) -> None:
    draft = read_cad(write(folder, HEAD + BASE + ARM + HINGE))
    base, arm = draft.link("base"), draft.link("arm")
    # 0.06 * 0.04 * 0.02 m3 = 4.8e-5 m3, at 1000 kg/m3. Corners are float32: 2^-24 of each.
    assert base.mass == pytest.approx(0.048, rel=1e-6)
    assert base.inertia_from == "mesh x density"
    assert base.com == pytest.approx((0, 0, 0.01), abs=1e-9)
    assert base.inertia is not None
    assert base.inertia[0, 0] == pytest.approx(0.048 * (0.04**2 + 0.02**2) / 12, rel=1e-6)
    # As weighed, whatever the density; the inertia keeps the mesh's form.
    assert arm.mass == 0.5
    assert arm.inertia_from == "measured"
    assert arm.com == pytest.approx((0.05, 0, 0), abs=1e-9)
    assert arm.inertia is not None
    assert arm.inertia[2, 2] == pytest.approx(0.5 * (0.1**2 + 0.01**2) / 12, rel=1e-6)


def test_a_joint_is_given_in_metres_and_radians(folder: Path) -> None:
    text = HEAD + BASE + ARM + HINGE + "turn_deg = [0, 0, 90]\ndamping = 0.1\nfriction = 0.2\n"
    (joint,) = read_cad(write(folder, text)).joints
    assert joint.pose.position == pytest.approx((0, 0, 0.04))
    assert joint.pose.rotation @ (1, 0, 0) == pytest.approx((0, 1, 0), abs=1e-15)
    assert joint.axis == pytest.approx((0, 1, 0))
    assert (joint.lower, joint.upper) == pytest.approx((-math.pi / 2, math.pi / 4))
    assert (joint.effort, joint.damping, joint.friction) == (2.5, 0.1, 0.2)


def test_a_slide_has_its_limits_in_the_unit_of_the_assembly(folder: Path) -> None:
    hinge = HINGE.replace("revolute", "prismatic").replace("limits_deg", "limits")
    (joint,) = read_cad(write(folder, HEAD + BASE + ARM + hinge)).joints
    assert (joint.lower, joint.upper) == pytest.approx((-0.09, 0.045))


def test_parts_drawn_together_become_links_at_their_joints(folder: Path) -> None:
    # The same arm where it stands in the whole, 40 mm up and 7 mm along y.
    (folder / "meshes" / "arm.stl").write_bytes(box((100, 10, 10), (50, 7, 40)))
    hinge = HINGE.replace("[0, 0, 40]", "[0, 7, 40]")
    draft = read_cad(write(folder, HEAD + 'frame = "assembly"\n' + BASE + ARM + hinge))
    assert draft.link("arm").com == pytest.approx((0.05, 0, 0), abs=1e-8)
    assert draft.joints[0].pose.position == pytest.approx((0, 0.007, 0.04))
    shape = draft.link("arm").shapes[0]
    assert shape.pose.position == pytest.approx((0, -0.007, -0.04))


def test_a_chain_drawn_together_has_each_joint_from_its_parent(folder: Path) -> None:
    tip = ARM.replace('"arm"', '"tip"')
    second = HINGE.replace("hinge", "wrist").replace('"arm"', '"tip"').replace('"base"', '"arm"')
    second = second.replace("[0, 0, 40]", "[100, 0, 45]")
    text = HEAD + 'frame = "assembly"\n' + BASE + ARM + tip + second + HINGE
    draft = read_cad(write(folder, text))
    assert draft.joint_above()["tip"].pose.position == pytest.approx((0.1, 0, 0.005))
    assert draft.home()["tip"].position == pytest.approx((0.1, 0, 0.045))


def test_a_mesh_may_have_a_unit_of_its_own(folder: Path) -> None:
    (folder / "base.stl").write_bytes(box((0.06, 0.04, 0.02), (0, 0, 0.01)))
    draft = read_cad(write(folder, HEAD + BASE + 'unit = "m"\n'))
    assert draft.link("base").mass == pytest.approx(0.048, rel=1e-6)


def test_the_engine_runs_what_the_table_says(folder: Path) -> None:
    robot = read_description(write(folder, HEAD + BASE + ARM + HINGE), base="fixed")
    assert {link.name for link in robot.links} >= {"arm"}
    assert robot.link("arm").mass == pytest.approx(0.5)
    assert robot.joint("hinge").limits == pytest.approx((-math.pi / 2, math.pi / 4))


@pytest.mark.parametrize(
    ("text", "words", "line"),
    [
        (HEAD + BASE + "colour = 3\n", "'colour' is unknown", 8),
        (HEAD.replace('"mm"', '"inch"') + BASE, "unit is 'inch', not 'mm' or 'm'", 3),
        (HEAD.replace("/1", "/2") + BASE, "schema is", 1),
        (HEAD.replace("density_kg_m3 = 1000.0\n", "") + BASE, "neither mass nor density", 5),
        (HEAD.replace("1000.0", "0.0") + BASE, "density_kg_m3 is 0.0", 4),
        (HEAD.replace("1000.0", "-3.0") + BASE, "density_kg_m3 is -3.0", 4),
        (HEAD + BASE + ARM.replace("0.5", "nan"), "mass_kg is nan", 11),
        (HEAD + BASE + ARM.replace("0.5", '"0.5"'), "mass_kg is '0.5', of type str", 11),
        (HEAD + BASE + BASE, "2 links are called 'base'", 9),
        (HEAD + BASE + ARM + HINGE.replace("revolute", "hinge"), "kind is 'hinge'", 16),
        (HEAD + BASE + ARM + HINGE.replace("0, 2, 0", "0, 0, 0"), "axis is", 18),
        (HEAD + BASE + ARM + HINGE.replace("[-90, 45]", "[-90]"), "limits_deg is", 19),
        (HEAD + BASE + ARM + HINGE.replace("limits_deg", "limits"), "revolute", 19),
        (HEAD + BASE + ARM + HINGE.replace("0, 0, 40", "0, inf, 40"), "origin is", 17),
        (HEAD + BASE + ARM + HINGE.replace("2.5", "-1"), "effort is -1.0", 20),
        (HEAD + BASE + ARM + HINGE + "damping = -0.1\n", "damping is -0.1", 21),
        (HEAD + BASE.replace("base.stl", "../box.stl"), "lies outside", 7),
        (HEAD + BASE.replace("base.stl", "Base.STL"), "is not there, but 'base.stl' is", 7),
        (HEAD + BASE.replace("base.stl", "gone.stl"), "is not there", 7),
    ],
)
def test_what_is_wrong_is_named_by_its_line(folder: Path, text: str, words: str, line: int) -> None:
    with pytest.raises(RobotError) as caught:
        read_cad(write(folder, text))
    assert words in caught.value.what
    assert caught.value.where.endswith(f"assembly.toml:{line}")


@pytest.mark.parametrize(
    ("hinge", "code"),
    [
        (HINGE.replace('"base"', '"mast"'), "dangling-joint"),
        (HINGE + HINGE.replace("hinge", "back").replace('"arm"', '"b"'), "dangling-joint"),
        (
            HINGE
            + HINGE.replace("hinge", "back")
            .replace('"arm"', '"x"')
            .replace('"base"', '"arm"')
            .replace('"x"', '"base"'),
            "cyclic-tree",
        ),
        ("", "lost-base"),
    ],
)
def test_links_that_make_no_tree_are_refused(folder: Path, hinge: str, code: str) -> None:
    with pytest.raises(RobotError) as caught:
        read_description(write(folder, HEAD + BASE + ARM + hinge), base="fixed")
    findings = getattr(caught.value, "findings", ())
    refused = {finding.code for finding in findings if finding.severity == "refused"}
    assert refused == {code}


def test_a_stub_in_place_of_a_mesh_is_named(folder: Path) -> None:
    (folder / "base.stl").write_bytes(b"version https://git-lfs.github.com/spec/v1\n")
    with pytest.raises(MeshError, match=r"base\.stl: is the pointer that Git LFS left") as caught:
        read_cad(write(folder, HEAD + BASE))
    assert caught.value.code == "mesh-lfs-stub"


def test_a_sheet_has_no_mass_and_is_refused(folder: Path) -> None:
    corners = np.array([(0, 0, 0), (9, 0, 0), (0, 9, 0)], dtype=float)
    (folder / "base.stl").write_bytes(as_stl(Mesh(vertices=corners, faces=np.array([(0, 1, 2)]))))
    with pytest.raises(RobotError, match="encloses no volume"):
        read_cad(write(folder, HEAD + BASE))


@pytest.mark.parametrize("weighed", [False, True])
def test_a_part_of_another_unit_weighs_what_it_does_in_its_own(folder: Path, weighed: bool) -> None:
    arm = ARM if weighed else ARM.replace("mass_kg = 0.5\n", "")
    right = read_description(write(folder, HEAD + BASE + arm + HINGE), base="fixed")
    # The same arm, drawn in metres in an assembly of millimetres.
    (folder / "meshes" / "arm.stl").write_bytes(box((0.1, 0.01, 0.01), (0.05, 0, 0)))
    mended = read_description(folder / "assembly.toml", base="fixed")
    assert {finding.code for finding in mended.findings} >= {"mesh-units"}
    one, other = right.links[1], mended.links[1]
    # 0.1 * 0.01 * 0.01 m3 at 1000 kg/m3, or as weighed; corners are float32: 2^-24 of each.
    assert one.mass == pytest.approx(0.5 if weighed else 0.01, rel=1e-6)
    assert other.mass == pytest.approx(one.mass, rel=1e-6)
    assert other.com == pytest.approx(one.com, abs=1e-7)
    assert other.inertia == pytest.approx(one.inertia, rel=1e-5, abs=1e-12)


@pytest.mark.parametrize("kind", ["link", "joint"])
@pytest.mark.parametrize("name", ["", "  "])
def test_a_part_without_a_name_is_refused_at_its_line(folder: Path, kind: str, name: str) -> None:
    old = {"link": 'name = "arm"', "joint": 'name = "hinge"'}[kind]
    text = (HEAD + BASE + ARM + HINGE).replace(old, f'name = "{name}"')
    with pytest.raises(RobotError, match=f"a {kind} has no name") as refused:
        read_cad(write(folder, text))
    line = text.splitlines().index(f'name = "{name}"') + 1
    assert refused.value.where.endswith(f":{line}")


def test_more_links_than_a_body_has_are_refused(folder: Path) -> None:
    parts = (f'[[link]]\nname = "{index}"\nmesh = "base.stl"\n' for index in range(1001))
    with pytest.raises(RobotError, match="has 1001 links; a body has 1000 at most"):
        read_cad(write(folder, HEAD + "".join(parts)))


def test_absurd_tables_are_refused(tmp_path: Path) -> None:
    for text in ("a = " + "[" * 5000, "x", "a = 1\n" + "#" * 2**20, "\0"):
        with pytest.raises(RobotError):
            read_cad(write(tmp_path, text))
    with pytest.raises(RobotError, match="cannot be read"):
        read_cad(tmp_path / "nowhere.toml")


@settings(max_examples=200, deadline=None)
@given(data=st.data())
def test_a_table_with_letters_changed_is_read_or_refused(
    data: st.DataObject, tmp_path_factory: pytest.TempPathFactory
) -> None:
    folder = tmp_path_factory.mktemp("table")
    (folder / "base.stl").write_bytes(box((60, 40, 20), (0, 0, 10)))
    text = HEAD + BASE + HINGE
    for _ in range(data.draw(st.integers(1, 3))):
        at = data.draw(st.integers(0, len(text) - 1))
        cut = data.draw(st.integers(0, 8))
        text = text[:at] + data.draw(st.text(max_size=4)) + text[at + cut :]
    (folder / "assembly.toml").write_text(text, encoding="utf-8", errors="replace")
    try:
        draft = read_cad(folder / "assembly.toml")
    except RobotError:
        return
    assert all(link.mass is not None and link.mass > 0 for link in draft.links)
