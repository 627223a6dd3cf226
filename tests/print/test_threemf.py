from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pytest
import trimesh

from morph.print.errors import PlateError
from morph.print.job import Laid, Plate
from morph.print.mesh import Mesh
from morph.print.part import Part, Placement
from morph.print.threemf import bytes_3mf, read_3mf, write_3mf

ABOUT = {"Title": "a <robot> & more", "policy_sha256": "ab" * 32, "Application": "morph 0.1.0"}


def part(name: str, shape: trimesh.Trimesh, number: str) -> Part:
    here = Placement(link="body", pose=np.eye(4), world=np.eye(4))
    mesh = Mesh(vertices=np.asarray(shape.vertices), faces=np.asarray(shape.faces))
    return Part(name=name, kind="printed", mesh=mesh, placements=(here, here), number=number)


def at(x: float, y: float, z: float, turn: float = 0.0) -> np.ndarray:
    return trimesh.transformations.rotation_matrix(turn, [0, 0, 1]) + np.array(
        [[0, 0, 0, x], [0, 0, 0, y], [0, 0, 0, z], [0, 0, 0, 0]]
    )


BALL = part("ball", trimesh.creation.icosphere(subdivisions=3, radius=20.0), "P-01")
BOX = part("box", trimesh.creation.box(extents=(10.0, 20.0, 30.0)), "P-02")
PLATE = Plate(
    name="plate_1",
    laid=(
        Laid(part="ball", copy=0, pose=at(30, 40, 20)),
        Laid(part="ball", copy=1, pose=at(80, 40, 20)),
        Laid(part="box", copy=0, pose=at(140, 40, 15, turn=0.5)),
    ),
)


def test_what_is_written_is_read_back_without_a_warning_in_strict_mode(tmp_path: Path) -> None:
    read = read_3mf(write_3mf(tmp_path / "plate.3mf", PLATE, [BALL, BOX], metadata=ABOUT))
    assert read.unit == "MilliMeter"
    assert read.metadata == ABOUT
    assert read.numbers == {"ball": "P-01", "box": "P-02"}
    assert [name for name, _ in read.items] == ["ball", "ball", "box"]
    for (_, pose), laid in zip(read.items, PLATE.laid, strict=True):
        # Six decimals, and numbers of four bytes: 140 mm to 8e-6.
        np.testing.assert_allclose(pose, laid.pose, atol=2e-5)
    for name, of in (("ball", BALL), ("box", BOX)):
        assert of.mesh is not None
        assert len(read.meshes[name].faces) == len(of.mesh.faces)
        assert abs(read.meshes[name].volume / of.mesh.volume - 1.0) < 1e-6


def test_a_second_library_reads_the_same_volume_in_millimetres(tmp_path: Path) -> None:
    scene = trimesh.load(write_3mf(tmp_path / "plate.3mf", PLATE, [BALL, BOX], metadata=ABOUT))
    assert scene.units == "millimeter"
    assert BALL.mesh is not None
    # Two balls and a box of 10 * 20 * 30 mm3.
    assert scene.volume == pytest.approx(2.0 * BALL.mesh.volume + 6000.0, rel=1e-6)
    np.testing.assert_allclose(scene.bounds[:, 2], [0.0, 40.0], atol=1e-4)


def test_the_same_plate_is_the_same_file_and_whole_as_an_archive(tmp_path: Path) -> None:
    content = bytes_3mf(PLATE, [BALL, BOX], metadata=ABOUT)
    assert content == bytes_3mf(PLATE, [BALL, BOX], metadata=ABOUT)
    assert read_3mf(content).metadata == ABOUT
    path = write_3mf(tmp_path / "plate.3mf", PLATE, [BALL, BOX], metadata=ABOUT)
    assert path.read_bytes() == content
    with zipfile.ZipFile(path) as archive:
        assert archive.testzip() is None


def test_nothing_is_left_where_a_plate_cannot_be_written(tmp_path: Path) -> None:
    taken = tmp_path / "plate.3mf"
    taken.mkdir()
    with pytest.raises(PlateError, match="cannot write"):
        write_3mf(taken, PLATE, [BALL, BOX], metadata=ABOUT)
    with pytest.raises(PlateError, match=r"cannot write.*No such file"):
        write_3mf(tmp_path / "missing" / "plate.3mf", PLATE, [BALL, BOX], metadata=ABOUT)
    assert [each.name for each in tmp_path.iterdir()] == ["plate.3mf"]


@pytest.mark.parametrize("about", [{"two words": "x"}, {"": "x"}, {"Title": "a\x00b"}])
def test_metadata_that_xml_cannot_hold_is_refused(about: dict[str, str]) -> None:
    with pytest.raises(PlateError, match="cannot stand in a 3MF file"):
        bytes_3mf(PLATE, [BALL, BOX], metadata=about)


def test_a_part_that_was_not_handed_over_is_named() -> None:
    with pytest.raises(PlateError, match="part 'box' is laid here, and has no mesh"):
        bytes_3mf(PLATE, [BALL], metadata={})


@pytest.mark.parametrize("share", [0.0, 0.3, 0.9])
def test_a_truncated_file_is_refused_by_name(tmp_path: Path, share: float) -> None:
    content = bytes_3mf(PLATE, [BALL, BOX], metadata={})
    path = tmp_path / "cut.3mf"
    path.write_bytes(content[: int(share * len(content))])
    with pytest.raises(PlateError, match=r"cut\.3mf"):
        read_3mf(path)
    with pytest.raises(PlateError, match="cannot read"):
        read_3mf(tmp_path / "none.3mf")


def test_a_file_that_lib3mf_warns_of_is_refused(tmp_path: Path) -> None:
    path = write_3mf(tmp_path / "plate.3mf", PLATE, [BOX, BALL], metadata={})
    wrong = tmp_path / "wrong.3mf"
    with zipfile.ZipFile(path) as source, zipfile.ZipFile(wrong, "w") as target:
        for entry in source.namelist():
            text = source.read(entry).replace(b'objectid="2"', b'objectid="77"')
            target.writestr(entry, text)
    with pytest.raises(PlateError, match=r"wrong\.3mf"):
        read_3mf(wrong)
