"""Convex pieces of shapes whose volumes are known, and the cache that keeps them."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from morph.body import pieces
from morph.body.mesh import Mesh
from morph.body.pieces import Cutting, cache_folder, convex_pieces
from morph.errors import MeshError

OUTLINE = np.array([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], dtype=float)
"""An L: a square of side 2 without a quarter; area 3, and 3.5 for its hull."""


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A cache of this test's own."""
    monkeypatch.setenv("MORPH_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def ell(size: float = 1.0) -> Mesh:
    """An L of height 1, times a size; watertight."""
    low = np.column_stack([OUTLINE, np.zeros(6)])
    floor = [(0, 3, 1), (1, 3, 2), (0, 5, 3), (3, 5, 4)]
    roof = [(a + 6, c + 6, b + 6) for a, b, c in floor]
    ring = [(at, (at + 1) % 6) for at in range(6)]
    walls = [face for a, b in ring for face in ((a, b, b + 6), (a, b + 6, a + 6))]
    vertices = np.concatenate([low, low + np.array((0, 0, 1))]) * size
    return Mesh(vertices=vertices, faces=np.array(floor + roof + walls))


@pytest.mark.parametrize("size", [1.0, 0.001])
def test_an_ell_is_cut_into_pieces_that_fill_it(size: float) -> None:
    mesh = ell(size)
    assert mesh.consistent
    found = convex_pieces(mesh)
    # Hull 3.5, mesh 3. A cut across the inner corner leaves pieces that fill the L; the cut's
    # place is sought on a grid of about 2 / 20, and each 0.1 off it adds at most 0.5 * 0.1 * 1.
    # CoACD leaves a gap of 5e-5 of the size at a cut, and as much off the ends: 3e-4 in all.
    assert found.hull_ratio == pytest.approx(3.5 / 3, rel=1e-9)
    assert 1 - 3e-4 < found.pieces_ratio < 1 + 0.05 / 3
    assert 2 <= len(found.meshes) <= 4
    for piece in found.meshes:
        assert piece.consistent
        assert piece.hull.volume == pytest.approx(piece.volume, rel=1e-9)
        # A corner of a piece may stand out by as much as the mesh's surface was approximated.
        assert (piece.bounds[0] >= mesh.bounds[0] - 0.01 * size).all()
        assert (piece.bounds[1] <= mesh.bounds[1] + 0.01 * size).all()


def test_a_convex_mesh_is_its_own_only_piece() -> None:
    found = convex_pieces(ell().hull)
    assert found.hull_ratio == pytest.approx(1.0, rel=1e-12)
    assert found.pieces_ratio == pytest.approx(1.0, rel=1e-6)
    assert len(found.meshes) == 1


def test_a_mesh_inside_out_is_cut_as_one_right_side_out() -> None:
    turned = Mesh(vertices=ell().vertices, faces=ell().faces[:, ::-1])
    assert convex_pieces(turned).pieces_ratio == pytest.approx(1.0, abs=0.05 / 3)


def test_the_second_time_nothing_is_cut(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = convex_pieces(ell())
    assert len(list(cache.rglob("*.npz"))) == 1
    monkeypatch.setattr(pieces, "_cut", lambda *_: pytest.fail("it was cut again"))
    second = convex_pieces(ell())
    assert second.pieces_ratio == first.pieces_ratio
    for one, other in zip(first.meshes, second.meshes, strict=True):
        assert np.array_equal(one.vertices, other.vertices)


def test_other_settings_and_other_meshes_have_other_entries(cache: Path) -> None:
    convex_pieces(ell())
    assert len(convex_pieces(ell(), Cutting(most=1)).meshes) == 1
    convex_pieces(ell(2.0))
    assert len(list(cache.rglob("*.npz"))) == 3


@pytest.mark.parametrize("damage", ["cut short", "rubbish", "wrong faces", "empty", "objects"])
def test_a_damaged_entry_is_computed_again(cache: Path, damage: str) -> None:
    before = convex_pieces(ell())
    entry = next(cache.rglob("*.npz"))
    corners = np.zeros((3, 3))
    if damage == "cut short":
        entry.write_bytes(entry.read_bytes()[:-100])
    elif damage == "rubbish":
        entry.write_bytes(b"rubbish")
    elif damage == "wrong faces":
        np.savez(entry, vertices_0=corners, faces_0=np.array([(0, 1, 9)]))
    elif damage == "empty":
        np.savez(entry)
    else:
        np.savez(entry, vertices_0=corners, faces_0=np.array([{}], dtype=object))
    assert convex_pieces(ell()).pieces_ratio == pytest.approx(before.pieces_ratio, rel=1e-12)


def test_a_cache_that_cannot_be_written_to_costs_only_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("MORPH_CACHE", str(tmp_path / "file"))
    assert len(convex_pieces(ell()).meshes) >= 2


def test_a_sheet_cannot_be_cut() -> None:
    corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0)], dtype=float)
    with pytest.raises(MeshError, match="enclose nothing"):
        convex_pieces(Mesh(vertices=corners, faces=np.array([(0, 1, 2)])))


def test_cutting_prints_nothing(tmp_path: Path) -> None:
    # CoACD logs from C++, past Python's own streams, so only a process shows it.
    script = (
        "import numpy as np; from morph.body.mesh import Mesh; "
        "from morph.body.pieces import convex_pieces; "
        "v = np.array([(0,0,0),(1,0,0),(0,1,0),(0,0,1)], float); "
        "convex_pieces(Mesh(vertices=v, faces=np.array([(0,2,1),(0,1,3),(0,3,2),(1,2,3)])))"
    )
    environment = {**os.environ, "MORPH_CACHE": str(tmp_path / "silent")}
    command = [sys.executable, "-c", script]
    ended = subprocess.run(command, capture_output=True, text=True, env=environment, check=True)
    assert ended.stdout + ended.stderr == ""


@pytest.mark.skipif(sys.platform != "linux", reason="each platform has its own folder")
def test_the_cache_lies_where_the_platform_keeps_caches(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("MORPH_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", "/somewhere")
    assert cache_folder() == Path("/somewhere/morph")
    monkeypatch.delenv("XDG_CACHE_HOME")
    assert cache_folder() == Path.home() / ".cache" / "morph"
