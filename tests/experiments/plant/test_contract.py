"""The planter, read back with the standard library and trimesh on a biped of our own."""

from __future__ import annotations

import difflib
import hashlib
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
import trimesh

from experiments.plant import DEFECTS
from experiments.plant.defect import Planted
from experiments.plant.description import Description
from experiments.plant.draw import Chosen, planted

BY_NAME = {defect.name: defect for defect in DEFECTS}
SHAPES = {"shin": (0.04, 0.05, 0.30), "foot": (0.20, 0.05, 0.03)}
"""Boxes of the biped's parts in m, as in conftest.py."""


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


def test_a_mesh_in_other_capitals_is_copied_too(biped: Description, tmp_path: Path) -> None:
    shin = biped.root / "meshes" / "shin.stl"
    shin.rename(shin.with_name("Shin.STL"))
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
    size = float(np.linalg.norm(SHAPES["foot"]))
    for line in come:
        away = [float(word) for word in line.removeprefix("origin xyz=").split()]
        assert 1.5 * size < np.linalg.norm(away) < 4.0 * size


def test_a_mesh_moved_in_its_file_keeps_its_shape(biped: Description, tmp_path: Path) -> None:
    copy, _ = plant(biped, "moved-mesh-origin", "file", "left_shin", tmp_path)
    mesh = trimesh.load(copy.root / "meshes" / "shin.stl")
    size = float(np.linalg.norm(SHAPES["shin"]))
    assert 1.5 * size < np.linalg.norm(mesh.bounds.mean(axis=0)) < 4.0 * size
    # A 32-bit number of up to 1.3 m is good to 1e-7 m.
    np.testing.assert_allclose(mesh.extents, SHAPES["shin"], atol=1e-6)


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
