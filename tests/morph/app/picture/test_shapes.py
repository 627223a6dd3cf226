from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import trimesh

from morph.app.picture.shapes import PictureShape, shapes

EVERY = """<mujoco><asset><material name="red" rgba="1 0 0 0.5"/>
<mesh name="tetra" vertex="0 0 0  1 0 0  0 1 0  0 0 1"/></asset><worldbody>
<geom type="plane" size="1 1 1"/><body name="a" pos="1 2 3">
<geom type="box" size="0.1 0.2 0.3" pos="0 0 1" euler="0 0 90" rgba="0 1 0 1"/>
<geom type="sphere" size="0.2" material="red"/>
<geom type="ellipsoid" size="0.1 0.2 0.3"/>
<geom type="capsule" size="0.1 0.4"/>
<geom type="cylinder" size="0.1 0.4"/>
<geom type="mesh" mesh="tetra"/>
<geom type="box" size="1 1 1" group="3"/></body></worldbody></mujoco>"""


@pytest.fixture(scope="module")
def found() -> list[PictureShape]:
    return list(shapes(mujoco.MjModel.from_xml_string(EVERY)))


def volume(shape: PictureShape) -> float:
    return float(trimesh.Trimesh(shape.vertices, shape.faces, process=True).volume)


def test_planes_and_shapes_for_collisions_are_left_out(found: list[PictureShape]) -> None:
    assert len(found) == 6
    assert {shape.body for shape in found} == {1}


def test_every_solid_has_its_volume_and_its_outside_outward(found: list[PictureShape]) -> None:
    due = [
        8 * 0.1 * 0.2 * 0.3,
        4 / 3 * np.pi * 0.2**3,
        4 / 3 * np.pi * 0.1 * 0.2 * 0.3,
        np.pi * 0.1**2 * 0.8 + 4 / 3 * np.pi * 0.1**3,
        np.pi * 0.1**2 * 0.8,
        1 / 6,
    ]
    # Flat triangles cut round bodies: of a circle in 16 they leave 1 - (2 pi / 16)^2 / 6 = 0.974.
    # A ball of 320 has edges of about 0.3 of its radius, and loses (0.3)^2 / 2.6 = 3.5 %.
    for shape, expected in zip(found, due, strict=True):
        assert volume(shape) == pytest.approx(expected, rel=0.04), expected


def test_a_shape_stands_where_the_model_has_it(found: list[PictureShape]) -> None:
    # A quarter turn about z swaps the box's x and y; its middle is 1 m above the body.
    low, high = found[0].vertices.min(axis=0), found[0].vertices.max(axis=0)
    assert low == pytest.approx([-0.2, -0.1, 0.7])
    assert high == pytest.approx([0.2, 0.1, 1.3])


def test_colours_are_those_of_the_material(found: list[PictureShape]) -> None:
    assert (found[0].colour, found[0].opacity) == ((0, 255, 0), 1.0)
    assert (found[1].colour, found[1].opacity) == ((255, 0, 0), 0.5)


def test_a_mesh_is_drawn_whole(tmp_path: Path) -> None:
    trimesh.creation.box((1, 2, 3)).export(tmp_path / "box.stl")
    text = (
        "<mujoco><asset><mesh name='box' file='box.stl'/></asset><worldbody><body>"
        "<geom type='mesh' mesh='box' pos='1 0 0'/></body></worldbody></mujoco>"
    )
    assets: dict[str, Any] = {"box.stl": (tmp_path / "box.stl").read_bytes()}
    (shape,) = shapes(mujoco.MjModel.from_xml_string(text, assets=assets))
    assert volume(shape) == pytest.approx(6.0, rel=1e-5)
    assert shape.vertices.mean(axis=0) == pytest.approx([1.0, 0.0, 0.0], abs=1e-6)
