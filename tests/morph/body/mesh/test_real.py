"""Meshes of real robots: all of them are read, and trimesh finds the same in them."""

from __future__ import annotations

import importlib.metadata
import io
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

import numpy as np
import pytest

from morph.body.mesh import Mesh, read_mesh
from morph.errors import MeshError

ENDINGS = (".stl", ".obj", ".ply", ".dae", ".3mf")


def meshes(folder: Path) -> dict[Path, bytes]:
    files = sorted(path for path in folder.rglob("*") if path.suffix.lower() in ENDINGS)
    return {path: path.read_bytes() for path in files}


def test_every_mesh_is_read_or_is_a_stub(real_robots: Path) -> None:
    found = meshes(real_robots)
    assert len(found) > 200
    refused: dict[Path, str] = {}
    for path, content in found.items():
        try:
            read_mesh(content, path.suffix, str(path))
        except MeshError as error:
            refused[path] = error.code
    assert set(refused.values()) <= {"mesh-lfs-stub"}
    assert set(refused) == {path for path, content in found.items() if b"git-lfs" in content[:40]}


def test_trimesh_finds_the_same_volume_centre_and_inertia(real_robots: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    compared = 0
    for path, content in meshes(real_robots).items():
        if b"git-lfs" in content[:40] or path.suffix.lower() != ".stl":
            continue
        mesh = read_mesh(content, "stl", str(path))
        other = trimesh.load_mesh(io.BytesIO(content), file_type="stl")
        assert len(mesh.faces) == len(other.faces)
        if not (other.is_watertight and other.is_winding_consistent and mesh.watertight):
            continue
        compared += 1
        # trimesh joins corners that are 1e-8 apart, of parts from 0.01 m on: 1e-6 of the size.
        size = float(np.ptp(mesh.bounds, axis=0).max())
        assert mesh.consistent, path
        assert mesh.volume == pytest.approx(other.volume, abs=1e-5 * size**3), path
        assert mesh.com == pytest.approx(other.center_mass, abs=1e-4 * size), path
        assert mesh.inertia == pytest.approx(other.moment_inertia, abs=1e-5 * size**5), path
    assert compared > 100


def test_the_meshes_of_poppy_and_their_facts_take_a_second(
    real_robots: Path, processor: Callable[[float], AbstractContextManager[None]]
) -> None:
    contents = meshes(real_robots / "poppy_humanoid")
    # Half of it on a machine that does nothing else.
    with processor(1.0):
        found = [read_mesh(content, path.suffix, str(path)) for path, content in contents.items()]
        facts = [(mesh.volume, mesh.com, mesh.inertia, mesh.watertight) for mesh in found]
    assert len(facts) >= 52
    assert sum(len(mesh.faces) for mesh in found) > 120_000


def test_collada_of_another_makers_robots_has_the_extent_that_trimesh_finds() -> None:
    pytest.importorskip("collada")
    trimesh = pytest.importorskip("trimesh")
    try:
        data = importlib.metadata.distribution("example-robot-data")
    except importlib.metadata.PackageNotFoundError:
        pytest.skip("example-robot-data is not installed")
    folder = Path(str(data.locate_file("cmeel.prefix/share/example-robot-data/robots")))
    found = meshes(folder / "romeo_description" / "meshes" / "V1" / "collision")
    assert len(found) > 10
    for path, content in found.items():
        mesh: Mesh = read_mesh(content, path.suffix, str(path))
        other = trimesh.load_scene(path, process=False).to_mesh()
        assert len(mesh.faces) == len(other.faces), path
        assert mesh.bounds == pytest.approx(other.bounds, abs=1e-6), path
