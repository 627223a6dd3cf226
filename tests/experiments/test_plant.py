"""The planter, read back with the standard library and trimesh on a biped of our own."""

from __future__ import annotations

import difflib
import hashlib
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path, PurePosixPath

import numpy as np
import pytest
import trimesh

from experiments.plant import DEFECTS
from experiments.plant.defect import Defect, Places, Planted
from experiments.plant.description import Description
from experiments.plant.draw import Chosen, draw, planted
from experiments.plant.originals import PACKAGED, originals, packaged_root
from experiments.planted import judged, main

BY_NAME = {defect.name: defect for defect in DEFECTS}
SHAPES = {
    "torso": ((0.20, 0.12, 0.30), 5.0),
    "thigh": ((0.05, 0.04, 0.30), 0.8),
    "shin": ((0.04, 0.05, 0.30), 0.6),
    "foot": ((0.20, 0.05, 0.03), 0.2),
}
"""Box in m and mass in kg of each part."""


def _link(name: str, part: str, *, collision: bool) -> str:
    (a, b, c), mass = SHAPES[part]
    # A box of sides a, b, c: m (b^2 + c^2) / 12 about the first axis, and so on round.
    moments = [mass * (p * p + q * q) / 12 for p, q in ((b, c), (a, c), (a, b))]
    mesh = f'<geometry><mesh filename="package://biped/meshes/{part}.stl"/></geometry>'
    touch = f'<collision><origin xyz="0 0 0"/>{mesh}</collision>' if collision else ""
    return f"""<link name="{name}">
      <inertial><origin xyz="0 0.01 0"/><mass value="{mass}"/>
        <inertia ixx="{moments[0]:.9g}" ixy="0" ixz="0" iyy="{moments[1]:.9g}" iyz="0"
                 izz="{moments[2]:.9g}"/></inertial>
      <visual><origin xyz="0 0 0"/>{mesh}</visual>{touch}</link>"""


def _joint(name: str, parent: str, child: str, xyz: str) -> str:
    return f"""<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>
      <origin xyz="{xyz}" rpy="0 0 0"/><axis xyz="0 1 0"/>
      <limit lower="-0.5" upper="1.2" effort="9" velocity="9"/></joint>"""


@pytest.fixture
def biped(tmp_path: Path) -> Description:
    """Return a torso on two legs of three links, hips 0.08 m to the left and right."""
    root = tmp_path / "own" / "biped"
    (root / "meshes").mkdir(parents=True)
    for part, (box, _) in SHAPES.items():
        trimesh.creation.box(box).export(root / "meshes" / f"{part}.stl")
    parts = [_link("torso", "torso", collision=True)]
    for side, y in (("left", "0.08"), ("right", "-0.08")):
        parts += [
            _link(f"{side}_thigh", "thigh", collision=True),
            _link(f"{side}_shin", "shin", collision=False),
            _link(f"{side}_foot", "foot", collision=True),
            _joint(f"{side}_hip", "torso", f"{side}_thigh", f"0 {y} -0.15"),
            _joint(f"{side}_knee", f"{side}_thigh", f"{side}_shin", "0 0 -0.3"),
            _joint(f"{side}_ankle", f"{side}_shin", f"{side}_foot", "0 0 -0.3"),
        ]
    (root / "biped.urdf").write_text(f'<robot name="biped"><!-- ours -->{"".join(parts)}</robot>')
    return Description(name="biped", root=root, urdf=PurePosixPath("biped.urdf"))


def contents(root: Path) -> dict[str, bytes]:
    """Return every file below a folder."""
    return {
        str(path.relative_to(root)): path.read_bytes()
        for path in sorted(root.rglob("*"))
        if path.is_file()
    }


def lines(urdf: bytes) -> list[str]:
    """Return one line an element, in the file's order, with its attributes in theirs."""

    def flat(element: ET.Element, depth: int) -> list[str]:
        words = [f"{key}={value}" for key, value in sorted(element.attrib.items())]
        below = [line for child in element for line in flat(child, depth + 1)]
        return [" ".join([".." * depth + element.tag, *words]), *below]

    return flat(ET.fromstring(urdf), 0)


def changed(before: Path, after: Path) -> tuple[list[str], list[str], set[str]]:
    """Return elements gone, elements new, and other files that differ."""
    old, new = contents(before), contents(after)
    urdf = next(name for name in old if name.lower().endswith(".urdf"))
    steps = difflib.ndiff(lines(old.pop(urdf)), lines(new.pop(urdf)))
    kept = [step for step in steps if step[0] in "-+"]
    gone = [step[2:].lstrip(".") for step in kept if step[0] == "-"]
    come = [step[2:].lstrip(".") for step in kept if step[0] == "+"]
    return gone, come, {name for name in {*old, *new} if old.get(name) != new.get(name)}


def plant(
    biped: Description, name: str, variant: str, site: str, folder: Path
) -> tuple[Description, Planted]:
    """Return a copy of the biped with one defect at one place."""
    defect = BY_NAME[name]
    fact = defect.fact(biped, site, variant)
    assert site in defect.sites(biped, variant)
    assert fact, f"{name} ({variant}) is none at {site}"
    chosen = Chosen(defect=defect, variant=variant, original=biped, site=site, fact=fact)
    return planted(chosen, folder, np.random.default_rng(5))


LIMIT = "limit effort=9 lower=-0.5 upper=1.2 velocity=9"
# Thigh, 0.8 kg: (0.04^2 + 0.3^2) 0.8 / 12 = 0.00610667, (0.05^2 + 0.3^2) 0.8 / 12 =
# 0.00616667, (0.05^2 + 0.04^2) 0.8 / 12 = 0.000273333. Foot, 0.2 kg: 5.67e-5, 6.82e-4, 7.08e-4.
THIGH = "inertia ixx=0.00610666667 ixy=0 ixz=0 iyy=0.00616666667 iyz=0 izz=0.000273333333"
FOOT = "inertia ixx=5.66666667e-05 ixy=0 ixz=0 iyy=0.000681666667 iyz=0 izz=0.000708333333"
MESH = "mesh filename=package://biped/meshes/shin.stl"

SAID = [
    ("unit-swap", "mesh in mm", "left_shin", [], [], {"meshes/shin.stl"}),
    ("unit-swap", "scale for mm", "left_shin", [MESH], [MESH + " scale=0.001 0.001 0.001"], set()),
    ("unit-swap", "mass in g", "left_foot", ["mass value=0.2"], ["mass value=200"], set()),
    (
        "unit-swap",
        "centre in mm",
        "left_thigh",
        ["origin xyz=0 0.01 0"],
        ["origin xyz=0 10 0"],
        set(),
    ),
    (
        "unit-swap",
        "joint in mm",
        "left_knee",
        ["origin rpy=0 0 0 xyz=0 0 -0.3"],
        ["origin rpy=0 0 0 xyz=0 0 -300"],
        set(),
    ),
    ("flipped-axis", "negated", "right_knee", ["axis xyz=0 1 0"], ["axis xyz=0 -1 0"], set()),
    (
        "mirrored-limb",
        "xyz copied",
        "left_hip",
        ["origin rpy=0 0 0 xyz=0 0.08 -0.15"],
        ["origin rpy=0 0 0 xyz=0 -0.08 -0.15"],
        set(),
    ),
    (
        "mirrored-limb",
        "origin copied",
        "right_hip",
        ["origin rpy=0 0 0 xyz=0 -0.08 -0.15"],
        ["origin rpy=0 0 0 xyz=0 0.08 -0.15"],
        set(),
    ),
    (
        "swapped-inertia",
        "ixx and izz",
        "left_thigh",
        [THIGH],
        ["inertia ixx=0.000273333333 ixy=0 ixz=0 iyy=0.00616666667 iyz=0 izz=0.00610666667"],
        set(),
    ),
    (
        "swapped-inertia",
        "ixx and iyy",
        "left_foot",
        [FOOT],
        ["inertia ixx=0.000681666667 ixy=0 ixz=0 iyy=5.66666667e-05 iyz=0 izz=0.000708333333"],
        set(),
    ),
    (
        "missing-mass",
        "no inertial",
        "left_foot",
        ["inertial", "origin xyz=0 0.01 0", "mass value=0.2", FOOT],
        [],
        set(),
    ),
    ("missing-mass", "no mass", "left_foot", ["mass value=0.2"], [], set()),
    ("missing-mass", "mass of zero", "left_foot", ["mass value=0.2"], ["mass value=0"], set()),
    (
        "broken-inertia",
        "exponent",
        "left_thigh",
        [THIGH],
        [THIGH.replace("iyy=0.00616666667", "iyy=0.0616666667")],
        set(),
    ),
    ("broken-inertia", "sign", "left_thigh", [THIGH], [THIGH.replace("iyy=", "iyy=-")], set()),
    (
        "broken-inertia",
        "column",
        "left_thigh",
        [THIGH],
        [THIGH.replace("iyy=0.00616666667", "iyy=0").replace("iyz=0 ", "iyz=0.00616666667 ")],
        set(),
    ),
    ("wrong-case", "extension", "left_shin", [], [], {"meshes/shin.stl", "meshes/shin.STL"}),
    ("wrong-case", "stem", "left_shin", [], [], {"meshes/shin.stl", "meshes/Shin.stl"}),
    ("wrong-case", "path", "left_shin", [MESH], [MESH.replace("shin", "SHIN")], set()),
    ("lfs-stub", "pointer", "left_shin", [], [], {"meshes/shin.stl"}),
    ("negative-volume", "faces", "left_shin", [], [], {"meshes/shin.stl"}),
    (
        "duplicate-name",
        "joint",
        "left_knee",
        ["joint name=left_knee type=revolute"],
        ["joint name=left_hip type=revolute"],
        set(),
    ),
    (
        "duplicate-name",
        "link",
        "left_foot",
        ["link name=left_foot", "child link=left_foot"],
        ["link name=left_shin", "child link=left_shin"],
        set(),
    ),
    (
        "cyclic-tree",
        "own grandchild",
        "left_hip",
        ["parent link=torso"],
        ["parent link=left_foot"],
        set(),
    ),
    (
        "cyclic-tree",
        "itself",
        "left_ankle",
        ["parent link=left_shin"],
        ["parent link=left_foot"],
        set(),
    ),
    (
        "cyclic-tree",
        "second parent",
        "left_ankle",
        [],
        [
            "joint name=left_ankle_closing type=revolute",
            "parent link=right_foot",
            "child link=left_foot",
            "origin rpy=0 0 0 xyz=0 0 -0.3",
            "axis xyz=0 1 0",
            LIMIT,
        ],
        set(),
    ),
    (
        "dangling-joint",
        "parent typo",
        "left_knee",
        ["parent link=left_thigh"],
        ["parent link=left_high"],
        set(),
    ),
    (
        "dangling-joint",
        "child typo",
        "left_knee",
        ["child link=left_shin"],
        ["child link=leftshin"],
        set(),
    ),
    ("dangling-joint", "no child", "left_knee", ["child link=left_shin"], [], set()),
    (
        "absurd-limit",
        "degrees",
        "left_knee",
        [LIMIT],
        # -0.5 rad is -28.6 degrees, 1.2 rad 68.8.
        ["limit effort=9 lower=-29 upper=69 velocity=9"],
        set(),
    ),
    (
        "absurd-limit",
        "huge",
        "left_knee",
        [LIMIT],
        ["limit effort=9 lower=-1e9 upper=1e9 velocity=9"],
        set(),
    ),
    (
        "absurd-limit",
        "reversed",
        "left_knee",
        [LIMIT],
        ["limit effort=9 lower=1.2 upper=-0.5 velocity=9"],
        set(),
    ),
    ("moved-mesh-origin", "file", "left_shin", [], [], {"meshes/shin.stl"}),
    (
        "lost-base",
        "joint gone",
        "left_hip",
        [
            "joint name=left_hip type=revolute",
            "parent link=torso",
            "child link=left_thigh",
            "origin rpy=0 0 0 xyz=0 0.08 -0.15",
            "axis xyz=0 1 0",
            LIMIT,
        ],
        [],
        set(),
    ),
]


@pytest.mark.parametrize(
    ("name", "variant", "site", "gone", "come", "files"),
    SAID,
    ids=[f"{row[0]}-{row[1]}".replace(" ", "_") for row in SAID],
)
def test_a_planter_changes_what_it_says_and_nothing_else(
    biped: Description,
    tmp_path: Path,
    name: str,
    variant: str,
    site: str,
    gone: list[str],
    come: list[str],
    files: set[str],
) -> None:
    before = contents(biped.root)
    copy, _ = plant(biped, name, variant, site, tmp_path / "copy")
    assert contents(biped.root) == before, "the original was touched"
    found = changed(biped.root, copy.root)
    assert (sorted(found[0]), sorted(found[1]), found[2]) == (sorted(gone), sorted(come), files)


def test_an_unplanted_copy_is_the_original_byte_for_byte(
    biped: Description, tmp_path: Path
) -> None:
    assert contents(biped.copy_to(tmp_path / "copy").root) == contents(biped.root)


def test_a_copy_written_anew_says_what_the_original_says(
    biped: Description, tmp_path: Path
) -> None:
    copy = biped.copy_to(tmp_path / "copy")
    copy.write(copy.parse())
    assert changed(biped.root, copy.root) == ([], [], set())
    assert b"<!-- ours -->" in copy.path.read_bytes()


def test_a_mesh_in_millimetres_is_a_thousand_times_as_large(
    biped: Description, tmp_path: Path
) -> None:
    copy, what = plant(biped, "unit-swap", "mesh in mm", "left_shin", tmp_path)
    extents = trimesh.load(copy.root / "meshes" / "shin.stl").extents
    # STL holds 32 bits: 1.2e-7 of the size.
    np.testing.assert_allclose(extents, (40.0, 50.0, 300.0), rtol=1e-6)
    # Both shins are drawn with this file.
    assert what.places.parts == {"left_shin", "right_shin"}


def test_an_inverted_mesh_has_its_volume_with_a_minus(biped: Description, tmp_path: Path) -> None:
    copy, _ = plant(biped, "negative-volume", "faces", "left_shin", tmp_path)
    mesh = trimesh.load(copy.root / "meshes" / "shin.stl")
    assert mesh.volume == pytest.approx(-0.04 * 0.05 * 0.3, rel=1e-6)


def test_a_stub_names_the_content_that_was_there(biped: Description, tmp_path: Path) -> None:
    content = (biped.root / "meshes" / "shin.stl").read_bytes()
    copy, _ = plant(biped, "lfs-stub", "pointer", "left_shin", tmp_path / "copy")
    assert (copy.root / "meshes" / "shin.stl").read_text().splitlines() == [
        "version https://git-lfs.github.com/spec/v1",
        f"oid sha256:{hashlib.sha256(content).hexdigest()}",
        f"size {len(content)}",
    ]


@pytest.mark.parametrize(
    ("variant", "site", "moved"), [("all shapes", "left_foot", 2), ("collision", "left_foot", 1)]
)
def test_shapes_move_by_more_than_the_link_is_large(
    biped: Description, tmp_path: Path, variant: str, site: str, moved: int
) -> None:
    copy, _ = plant(biped, "moved-mesh-origin", variant, site, tmp_path)
    gone, come, files = changed(biped.root, copy.root)
    assert (len(gone), len(come), files) == (moved, moved, set())
    size = float(np.linalg.norm(SHAPES["foot"][0]))
    for line in come:
        away = [float(word) for word in line.removeprefix("origin xyz=").split()]
        assert 1.5 * size < np.linalg.norm(away) < 4.0 * size


def test_a_mesh_moved_in_its_file_keeps_its_shape(biped: Description, tmp_path: Path) -> None:
    copy, _ = plant(biped, "moved-mesh-origin", "file", "left_shin", tmp_path)
    mesh = trimesh.load(copy.root / "meshes" / "shin.stl")
    size = float(np.linalg.norm(SHAPES["shin"][0]))
    assert 1.5 * size < np.linalg.norm(mesh.bounds.mean(axis=0)) < 4.0 * size
    # A 32-bit number of up to 1.3 m is good to 1e-7 m.
    np.testing.assert_allclose(mesh.extents, SHAPES["shin"][0], atol=1e-6)


@pytest.mark.parametrize("variant", BY_NAME["broken-inertia"].variants)
@pytest.mark.parametrize("site", ["left_thigh", "left_foot", "torso"])
def test_no_body_has_a_broken_inertia(
    biped: Description, tmp_path: Path, variant: str, site: str
) -> None:
    copy, _ = plant(biped, "broken-inertia", variant, site, tmp_path)
    moments = np.linalg.eigvalsh(inertia(copy.path, site))
    assert moments[0] < 0 or moments[2] > moments[0] + moments[1]


@pytest.mark.parametrize(
    ("variant", "site"), [("ixx and izz", "left_thigh"), ("ixx and iyy", "left_foot")]
)
def test_some_body_has_a_swapped_inertia(
    biped: Description, tmp_path: Path, variant: str, site: str
) -> None:
    copy, _ = plant(biped, "swapped-inertia", variant, site, tmp_path)
    moments = np.linalg.eigvalsh(inertia(copy.path, site))
    assert 0 < moments[0] <= moments[2] <= moments[0] + moments[1]


def inertia(urdf: Path, link: str) -> np.ndarray:
    """Return a link's inertia as the file has it."""
    element = ET.parse(urdf).find(f"link[@name='{link}']/inertial/inertia")
    assert element is not None
    xx, xy, xz, yy, yz, zz = (
        float(element.get(key, "")) for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    )
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def test_the_inertial_blocks_of_two_links_change_places(biped: Description, tmp_path: Path) -> None:
    copy, what = plant(biped, "swapped-inertia", "two links", "left_foot", tmp_path)

    def block(urdf: Path, link: str) -> list[str]:
        element = ET.parse(urdf).find(f"link[@name='{link}']/inertial")
        assert element is not None
        return lines(ET.tostring(element))

    assert block(copy.path, "left_foot") == block(biped.path, "torso")
    assert block(copy.path, "torso") == block(biped.path, "left_foot")
    assert {"left_foot", "torso"} <= what.places.parts


@pytest.mark.parametrize("variant", ["base gone", "both gone"])
def test_without_its_base_a_robot_is_in_pieces(
    biped: Description, tmp_path: Path, variant: str
) -> None:
    copy, _ = plant(biped, "lost-base", variant, "left_hip", tmp_path)
    robot = ET.parse(copy.path)
    assert robot.find("link[@name='torso']") is None
    hips = [robot.find(f"joint[@name='{side}_hip']") for side in ("left", "right")]
    assert [hip is None for hip in hips] == [variant == "both gone"] * 2


def test_a_link_that_is_gone_is_still_named_by_its_joints(
    biped: Description, tmp_path: Path
) -> None:
    copy, what = plant(biped, "dangling-joint", "link gone", "left_knee", tmp_path)
    robot = ET.parse(copy.path)
    assert robot.find("link[@name='left_shin']") is None
    assert robot.find("joint[@name='left_knee']/child[@link='left_shin']") is not None
    assert what.places.parts == {"left_knee", "left_ankle", "left_shin"}


def test_a_link_that_stands_twice_stands_twice(biped: Description, tmp_path: Path) -> None:
    copy, _ = plant(biped, "duplicate-name", "link twice", "left_foot", tmp_path)
    assert len(ET.parse(copy.path).findall("link[@name='left_foot']")) == 2


def test_a_limit_that_is_not_finite_is_not(biped: Description, tmp_path: Path) -> None:
    copy, _ = plant(biped, "absurd-limit", "not finite", "left_knee", tmp_path)
    limit = ET.parse(copy.path).find("joint[@name='left_knee']/limit")
    assert limit is not None
    assert not np.isfinite(float(limit.get("upper", "0")))


@pytest.mark.parametrize(
    ("name", "variant", "site", "why"),
    [
        ("flipped-axis", "negated", "left_hip", "its limits disagree with the axes as they are"),
        ("swapped-inertia", "ixx and iyy", "left_thigh", "0.0061 and 0.0062 are one as the other"),
        ("missing-mass", "no mass", "torso", "no joint moves it"),
        ("absurd-limit", "degrees", "right_hip", "it turns by a little only"),
    ],
)
def test_what_would_be_no_defect_is_not_planted(
    biped: Description, name: str, variant: str, site: str, why: str
) -> None:
    robot = biped.parse()
    for joint, lower, upper in (("left_hip", "-1.2", "0.5"), ("right_hip", "-0.5", "0.6")):
        limit = robot.find(f"joint[@name='{joint}']/limit")
        assert limit is not None
        limit.attrib |= {"lower": lower, "upper": upper}
    biped.write(robot)
    defect = BY_NAME[name]
    sites = [one for one in defect.sites(biped, variant) if defect.fact(biped, one, variant)]
    assert sites, "it is a defect nowhere"
    assert site not in sites, why


def test_every_variant_of_every_class_is_planted_above() -> None:
    apart = {
        ("swapped-inertia", "two links"),
        ("duplicate-name", "link twice"),
        ("dangling-joint", "link gone"),
        ("absurd-limit", "not finite"),
        ("moved-mesh-origin", "all shapes"),
        ("moved-mesh-origin", "collision"),
        ("lost-base", "base gone"),
        ("lost-base", "both gone"),
    }
    every = {(defect.name, variant) for defect in DEFECTS for variant in defect.variants}
    assert {(row[0], row[1]) for row in SAID} | apart == every
    assert len(DEFECTS) == len(BY_NAME) == 15


@pytest.mark.parametrize("defect", DEFECTS, ids=lambda one: one.name)
def test_published_robots_have_ten_places_of_each_class_on_four_of_them(defect: Defect) -> None:
    if not packaged_root().is_dir():
        pytest.skip("example-robot-data is not installed")
    packaged = [one for one in originals() if one.name in PACKAGED]
    found = draw(defect, packaged, 10, np.random.default_rng(7))
    assert len(found) == 10
    assert len({one.original.name for one in found}) >= 4
    assert len({(one.original.name, one.variant, one.site) for one in found}) == 10
    assert found == draw(defect, packaged, 10, np.random.default_rng(7))


def _finding(code: str, kind: str, name: str, what: str = "") -> dict[str, object]:
    return {"code": code, "where": {"kind": kind, "name": name}, "what": what}


PLANT = Planted(
    defect="flipped-axis",
    variant="negated",
    robot="biped",
    site="left_hip",
    fact="",
    did="",
    places=Places(
        parts=frozenset({"left_hip", "left_thigh"}),
        meshes=frozenset({"thigh.stl"}),
        partners=frozenset({"right_hip"}),
    ),
    codes=frozenset({"axis-flipped"}),
    also=frozenset({"joint-axis"}),
)


@pytest.mark.parametrize(
    ("finding", "named", "own", "twin"),
    [
        (_finding("axis-flipped", "joint", "left_hip"), True, True, False),
        (_finding("joint-axis", "joint", "left_hip"), True, False, False),
        (_finding("axis-flipped", "joint", "right_hip", "beside left_hip"), True, True, True),
        (_finding("axis-flipped", "joint", "right_hip", "its twin"), False, False, False),
        (_finding("axis-flipped", "joint", "left_knee"), False, False, False),
        (_finding("axis-flipped", "robot", "left_hip"), False, False, False),
        (_finding("limb-mirrored", "joint", "left_hip"), False, False, False),
        (_finding("axis-flipped", "mesh", "package://a/Thigh.STL"), True, True, False),
    ],
)
def test_a_defect_is_named_by_a_right_code_at_a_right_place(
    finding: dict[str, object], named: bool, own: bool, twin: bool
) -> None:
    row = judged(PLANT, [], [finding], "repaired")
    assert (row["named"], row["by_own_code"], row["by_twin_only"]) == (named, own, twin)
    assert len(row["found"] + row["beside"] + row["elsewhere"]) == 1


def test_what_the_original_had_already_names_nothing() -> None:
    known = _finding("axis-flipped", "joint", "left_hip")
    row = judged(PLANT, [known], [known], "repaired")
    assert not row["named"]
    assert row["known_before"] == ["axis-flipped"]
    assert judged(replace(PLANT, codes=frozenset({"mimic"})), [known], [], "ok")["found"] == []


def test_a_dry_run_says_where_the_defects_go(capsys: pytest.CaptureFixture[str]) -> None:
    if not packaged_root().is_dir():
        pytest.skip("example-robot-data is not installed")
    assert main(["--dry", "--per-class", "2", "--defect", "lost-base"]) == 0
    said = capsys.readouterr().out.splitlines()
    assert len(said) == 2
    assert all(line.startswith("lost-base") for line in said)


def test_without_descriptions_the_study_says_what_to_do(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("experiments.planted.originals", list)
    assert main([]) == 2
    assert "MORPH_ROBOTS" in capsys.readouterr().err
