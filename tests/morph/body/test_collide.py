"""Collision by convex pieces: an L touches where it is, and not where its hull would be."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from morph.body.collide import with_pieces
from morph.body.load import load
from morph.body.mesh import Mesh, as_stl
from morph.body.robot import Robot
from morph.body.spec import spec_of


def prism(outline: list[tuple[float, float]], triangles: list[tuple[int, int, int]]) -> Mesh:
    """Return an outline, counter-clockwise in x and z, as a plate of thickness 1 along y."""
    count = len(outline)
    front = [(x, 0.0, z) for x, z in outline]
    back = [(x, 1.0, z) for x, z in outline]
    faces = [*triangles, *((c + count, b + count, a + count) for a, b, c in triangles)]
    for a in range(count):
        b = (a + 1) % count
        faces += [(a, a + count, b + count), (a, b + count, b)]
    return Mesh(vertices=np.array(front + back), faces=np.array(faces))


@pytest.fixture
def bracket(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Robot:
    """An L of two bars 2 x 1: its volume is 3, and its hull's 3.5."""
    monkeypatch.setenv("MORPH_CACHE", str(tmp_path / "cache"))
    outline = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)]
    mesh = prism(outline, [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)])
    assert mesh.volume == pytest.approx(3.0)
    (tmp_path / "bracket.stl").write_bytes(as_stl(mesh))
    shape = '<geometry><mesh filename="bracket.stl"/></geometry>'
    (tmp_path / "bracket.urdf").write_text(
        '<robot name="bracket"><link name="bracket"><inertial><mass value="2"/>'
        '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
        f"<visual>{shape}</visual><collision>{shape}</collision></link></robot>"
    )
    return load(tmp_path / "bracket.urdf", base="floating")


def touches(robot: Robot, x: float, z: float) -> bool:
    """Return whether a small ball at a point touches the robot."""
    spec = spec_of(robot)
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=(0.05, 0, 0), pos=(x, 0.5, z))
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return bool(data.ncon > 0)


def test_an_l_is_cut_where_its_hull_would_fill_the_corner(bracket: Robot) -> None:
    cut, (told,) = with_pieces(bracket)
    # The hull adds the triangle between the tips, 1/2 of the 3 that there are.
    assert told.hull_ratio == pytest.approx(3.5 / 3.0, abs=1e-6)
    # Two bars fit exactly; CoACD may leave 5 % of concavity.
    assert told.pieces_ratio == pytest.approx(1.0, abs=0.05)
    assert told.pieces >= 2
    # The point is 0.14 outside the L, and 0.21 inside its hull.
    assert touches(bracket, 1.15, 1.15)
    assert not touches(cut, 1.15, 1.15)
    assert touches(cut, 1.5, 0.5)


def test_pieces_change_neither_mass_nor_look(bracket: Robot) -> None:
    cut, _ = with_pieces(bracket)
    assert cut.mass == bracket.mass
    assert cut.link("bracket").inertia == bracket.link("bracket").inertia
    assert "visual mesh" in cut.link("bracket").shapes
    assert cut.sha256 != bracket.sha256


def test_the_second_time_pieces_come_from_the_cache(bracket: Robot, tmp_path: Path) -> None:
    first, _ = with_pieces(bracket)
    stored = sorted((tmp_path / "cache").rglob("*.npz"))
    again, _ = with_pieces(bracket)
    assert len(stored) == 1
    assert sorted((tmp_path / "cache").rglob("*.npz")) == stored
    assert again.mjcf == first.mjcf


def test_loading_cuts_nothing(bracket: Robot, tmp_path: Path) -> None:
    assert not (tmp_path / "cache").exists()
    assert bracket.link("bracket").shapes == ("visual mesh", "collision mesh")
