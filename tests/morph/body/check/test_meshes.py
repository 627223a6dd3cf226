"""Mesh files that are missing, damaged, or of the wrong size or place are named at their shape."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import trimesh

from morph.body.spec import spec_of

STUB = b"version https://git-lfs.github.com/spec/v1\noid sha256:" + b"a" * 64 + b"\nsize 400\n"
CUBE = "meshes/cube.stl"


def cube(edge: float = 0.2, at: tuple[float, float, float] = (0, 0, 0)) -> trimesh.Trimesh:
    """Return a cube, made without our code."""
    mesh = trimesh.creation.box((edge, edge, edge))
    mesh.apply_translation(at)
    return mesh


def stl(mesh: trimesh.Trimesh) -> bytes:
    return bytes(mesh.export(file_type="stl"))


def shown(bench: Any, content: bytes, file: str = CUBE, shape: str = "", **more: Any) -> Any:
    """Return the reading of a link that shows one mesh, among three of another file."""
    others = {"meshes/other.stl": stl(cube())}
    link = bench.link("arm", shape or bench.mesh(file))
    return bench.read(
        bench.link("base", bench.mesh("meshes/other.stl")),
        link,
        bench.link("hand", bench.mesh("meshes/other.stl")),
        bench.joint("elbow", "base", "arm", xyz="0 0 0.4"),
        bench.joint("wrist", "arm", "hand", xyz="0 0 0.4"),
        files={CUBE: content, **others, **more},
    )


def geoms(reading: Any) -> int:
    return int(reading.robot.mjcf.count("<geom"))


def test_a_good_mesh_is_read_without_a_word(bench: Any) -> None:
    reading = shown(bench, stl(cube()))
    assert reading.findings == ()
    assert geoms(reading) == 3


def test_a_missing_mesh_is_told_and_takes_no_dynamics_away(bench: Any) -> None:
    reading = shown(bench, stl(cube()), "package://robot/meshes/gone.stl")
    assert reading.stands("mesh-missing", "repaired", "link", "arm", "gone.stl")
    assert "gone.stl" in reading.the("mesh-missing").what
    assert (geoms(reading), reading.robot.mass) == (2, 3.0)


def test_a_git_lfs_stub_is_told_from_damage(bench: Any) -> None:
    reading = shown(bench, STUB)
    assert reading.stands("mesh-lfs-stub", "repaired", "link", "arm")
    assert "git lfs pull" in reading.the("mesh-lfs-stub").fix
    assert (geoms(reading), reading.robot.mass) == (2, 3.0)


@pytest.mark.parametrize(
    ("code", "content"),
    [
        ("mesh-unreadable", stl(cube())[:-20]),
        ("mesh-unreadable", b"\x00\x01" * 1000),
        ("mesh-empty", b""),
        ("mesh-empty", b"solid nothing\nendsolid nothing\n"),
        ("mesh-empty", bytes(84)),
    ],
)
def test_a_damaged_mesh_is_left_out_and_the_robot_stays(
    bench: Any, code: str, content: bytes
) -> None:
    reading = shown(bench, content)
    assert reading.stands(code, "repaired", "link", "arm")
    assert (geoms(reading), reading.robot.mass) == (2, 3.0)


def test_a_mesh_of_a_kind_that_nobody_reads_is_named(bench: Any) -> None:
    reading = shown(bench, b"", "arm.blend", **{"arm.blend": b"BLENDER"})
    assert reading.stands("mesh-unreadable", "repaired", "link", "arm")


def test_a_mesh_file_larger_than_any_part_is_not_read(bench: Any) -> None:
    path = bench.write(
        bench.link("arm", bench.mesh(CUBE), bench.box()), files={CUBE: b"solid a"}
    ).parent
    with (path / CUBE).open("r+b") as file:
        file.truncate(400 * 2**20)  # A hole: it takes no room on the disk.
    reading = bench.open(path / "robot.urdf")
    assert reading.stands("mesh-too-large", "repaired", "link", "arm")


def test_one_mesh_that_is_too_large_does_not_spoil_the_others(bench: Any) -> None:
    path = bench.write(
        bench.link("arm", bench.mesh("huge.stl")),
        bench.link("hand", bench.mesh(CUBE)),
        bench.joint("wrist", "arm", "hand", xyz="0 0 0.4"),
        files={CUBE: stl(cube()), "huge.stl": b""},
    ).parent
    with (path / "huge.stl").open("r+b") as file:
        file.truncate(600 * 2**20)
    reading = bench.open(path / "robot.urdf")
    assert reading.stands("mesh-too-large", "repaired", "link", "arm")
    assert geoms(reading) == 1


def test_shapes_of_too_many_faces_together_are_thinned_from_there_on(
    bench: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    # A ball of 20 * 4^3 = 1280 faces: two are within 3000, the third is not.
    monkeypatch.setattr("morph.body.shapes.MOST_TOGETHER", 3000)
    ball = stl(trimesh.creation.icosphere(subdivisions=3, radius=0.1))
    reading = bench.read(
        *(bench.link(name, bench.mesh(f"{name}.stl")) for name in "abc"),
        bench.joint("ab", "a", "b", xyz="0 0 0.3"),
        bench.joint("bc", "b", "c", xyz="0 0 0.3"),
        files={f"{name}.stl": ball for name in "abc"},
    )
    assert reading.stands("mesh-too-large", "repaired", "link", "c")
    faces = spec_of(reading.robot).compile().mesh_facenum
    assert sorted(faces.tolist())[1:] == [1280, 1280]
    assert 0 < min(faces) <= 500


def test_a_mesh_that_is_drawn_often_counts_once(
    bench: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    # 1280 faces, drawn three times, are within 3000: one mesh. Four times more is too much to draw.
    monkeypatch.setattr("morph.body.shapes.MOST_TOGETHER", 3000)
    monkeypatch.setattr("morph.body.shapes.MOST_DRAWN", 4 * 1280)
    ball = stl(trimesh.creation.icosphere(subdivisions=3, radius=0.1))

    def chain(links: str) -> Any:
        pairs = pairwise(links)
        return bench.read(
            *(bench.link(name, bench.mesh(CUBE)) for name in links),
            *(bench.joint(one + two, one, two, xyz="0 0 0.3") for one, two in pairs),
            files={CUBE: ball},
        )

    assert not any(finding.code == "mesh-too-large" for finding in chain("abc").findings)
    assert chain("abcde").stands("mesh-too-large", "repaired", "link", "e")


def test_other_capitals_are_told_and_the_file_is_taken(bench: Any) -> None:
    reading = shown(bench, stl(cube()), "meshes/Cube.STL")
    assert reading.stands("mesh-case", "repaired", "link", "arm", "Cube.STL")
    assert CUBE in reading.the("mesh-case").what
    assert geoms(reading) == 3


def test_a_mesh_in_another_place_is_told_and_taken(bench: Any) -> None:
    reading = shown(bench, stl(cube()), "/usr/author/robot/visual/cube.stl")
    assert reading.stands("mesh-path", "repaired", "link", "arm", "/usr/author")
    assert CUBE in reading.the("mesh-path").what
    assert geoms(reading) == 3


def test_a_path_that_leads_out_is_told_and_not_taken(bench: Any) -> None:
    outside = bench.folder.parent / "canary.stl"
    outside.write_bytes(stl(cube()))
    reading = shown(bench, stl(cube()), "../canary.stl")
    assert reading.stands("mesh-outside", "repaired", "link", "arm", "canary.stl")
    assert geoms(reading) == 2


def test_faces_that_look_inward_are_told(bench: Any) -> None:
    mesh = cube()
    mesh.invert()
    assert mesh.volume < 0
    reading = shown(bench, stl(mesh))
    assert reading.stands("mesh-inside-out", "info", "link", "arm")


def test_a_mesh_with_a_hole_is_told(bench: Any) -> None:
    mesh = cube()
    mesh.update_faces(np.arange(len(mesh.faces)) > 0)
    assert not mesh.is_watertight
    assert shown(bench, stl(mesh)).stands("mesh-open", "info", "link", "arm")


def test_a_mesh_in_millimetres_is_brought_to_metres(bench: Any) -> None:
    reading = shown(bench, stl(cube(200.0)))
    assert reading.stands("mesh-units", "repaired", "link", "arm")
    assert "0.001" in reading.the("mesh-units").fix


def test_a_mesh_in_millimetres_that_says_so_is_left_alone(bench: Any) -> None:
    shape = bench.mesh(CUBE, scale="0.001 0.001 0.001")
    assert shown(bench, stl(cube(200.0)), shape=shape).findings == ()


def test_a_mesh_scaled_to_millimetres_twice_is_brought_back(bench: Any) -> None:
    shape = bench.mesh(CUBE, scale="0.001 0.001 0.001")
    reading = shown(bench, stl(cube(0.2)), shape=shape)
    assert reading.stands("mesh-units", "repaired", "link", "arm")


def test_meshes_that_are_all_in_millimetres_are_brought_to_metres(bench: Any) -> None:
    reading = bench.read(
        *(bench.link(name, bench.mesh(CUBE)) for name in "abc"),
        bench.joint("ab", "a", "b", xyz="0 0 0.3"),
        bench.joint("bc", "b", "c", xyz="0 0 0.3"),
        files={CUBE: stl(cube(200.0))},
    )
    assert {f.where.name for f in reading.of("mesh-units")} == {"a", "b", "c"}


def test_a_mesh_that_mirrors_another_by_its_scale_is_left_alone(bench: Any) -> None:
    shape = bench.mesh(CUBE, scale="1 -1 1")
    assert shown(bench, stl(cube()), shape=shape).findings == ()


def test_a_small_screw_in_a_large_robot_is_no_unit_mistaken(bench: Any) -> None:
    assert shown(bench, stl(cube(0.01))).of("mesh-units") == []


def test_a_mesh_away_from_its_mass_is_told(bench: Any) -> None:
    reading = shown(bench, stl(cube(0.2, (0.0, 0.0, 1.5))))
    assert reading.stands("mesh-moved", "info", "link", "arm")


def test_a_visual_away_from_its_collision_shape_is_told(bench: Any) -> None:
    apart = bench.mesh(CUBE, xyz="0.9 0 0") + bench.box(role="collision")
    reading = shown(bench, stl(cube()), shape=apart)
    assert reading.stands("mesh-moved", "info", "link", "arm")
    beside = bench.mesh(CUBE, xyz="0.01 0 0") + bench.box(role="collision")
    assert not shown(bench, stl(cube()), shape=beside).of("mesh-moved")


@pytest.mark.parametrize(
    ("kind", "size"),
    [
        ("box", 'size="0.1 0 0.1"'),
        ("box", 'size="-0.1 0.1 0.1"'),
        ("box", 'size="0.1 1e-16 0.1"'),
        ("sphere", 'radius="0"'),
        ("sphere", ""),
        ("cylinder", 'radius="0.1"'),
        ("cylinder", 'radius="-0.1" length="1"'),
        ("capsule", 'radius="0" length="1"'),
    ],
)
def test_a_shape_without_size_is_told_and_left_out(bench: Any, kind: str, size: str) -> None:
    shape = f"<visual><geometry><{kind} {size}/></geometry></visual>"
    reading = shown(bench, stl(cube()), shape=shape)
    assert reading.stands("shape-size", "repaired", "link", "arm")
    assert geoms(reading) == 2


def test_a_mesh_scaled_to_nothing_is_told_and_left_out(bench: Any) -> None:
    reading = shown(bench, stl(cube()), shape=bench.mesh(CUBE, scale="1 0 1"))
    assert reading.stands("shape-size", "repaired", "link", "arm")
    assert reading.robot is not None
