"""Files that another library wrote are read as what it put into them."""

from __future__ import annotations

import io
import zipfile

import numpy as np
import pytest

from morph.body.mesh import Mesh, as_obj, as_stl, read_mesh
from morph.body.mesh.fan import fans

trimesh = pytest.importorskip("trimesh")

MODEL = '<model unit="{unit}" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">'
OBJECT = """<object id="{id}"><mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/>
<vertex x="0" y="1" z="0"/><vertex x="0" y="0" z="1"/></vertices><triangles>
<triangle v1="0" v2="2" v3="1"/><triangle v1="0" v2="1" v3="3"/><triangle v1="0" v2="3" v3="2"/>
<triangle v1="1" v2="2" v3="3"/></triangles></mesh></object>"""
RELATIONS = """<Relationships><Relationship Id="a" Target="/3D/part.model"
Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>"""
DAE = """<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema"><asset>
<unit meter="0.01"/><up_axis>Y_UP</up_axis></asset><library_geometries><geometry id="g"><mesh>
<source id="s"><float_array id="a" count="12">0 0 0 1 0 0 0 1 0 0 0 1</float_array>
<technique_common><accessor source="#a" count="4" stride="3"/></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
<polylist count="4"><input semantic="VERTEX" source="#v" offset="0"/>
<input semantic="NORMAL" source="#n" offset="1"/><vcount>3 3 3 3</vcount>
<p>0 9 2 9 1 9 0 9 1 9 3 9 0 9 3 9 2 9 1 9 2 9 3 9</p></polylist></mesh></geometry>
</library_geometries><library_visual_scenes><visual_scene id="w"><node><translate>5 0 0</translate>
<rotate>0 0 1 90</rotate><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#w"/></scene></COLLADA>"""


def part() -> Mesh:
    """A ring of quads cut into triangles, with no symmetry that could hide an error."""
    shape = trimesh.creation.annulus(r_min=0.5, r_max=1.0, height=0.7, sections=24)
    shape.apply_transform(trimesh.transformations.euler_matrix(0.3, -0.7, 1.1))
    shape.apply_translation((3.0, -1.0, 0.5))
    return Mesh(vertices=np.asarray(shape.vertices), faces=np.asarray(shape.faces))


def archive(**files: str) -> bytes:
    sink = io.BytesIO()
    with zipfile.ZipFile(sink, "w", zipfile.ZIP_DEFLATED) as writer:
        for name, text in files.items():
            writer.writestr(name.replace("__", "/").replace("_dot_", "."), text)
    return sink.getvalue()


def package(model: str, unit: str = "meter") -> bytes:
    whole = MODEL.format(unit=unit) + model + "</model>"
    return archive(**{"_rels/.rels": RELATIONS, "3D/part.model": whole})


@pytest.mark.parametrize(
    ("ending", "how"),
    [
        ("stl", {}),
        (".STL", {}),
        ("stl", {"file_type": "stl_ascii"}),
        ("obj", {}),
        ("ply", {}),
        ("ply", {"encoding": "ascii"}),
        ("3mf", {}),
    ],
)
def test_what_trimesh_writes_is_read_back(ending: str, how: dict[str, str]) -> None:
    expected = part()
    shape = trimesh.Trimesh(expected.vertices, expected.faces, process=False)
    written = shape.export(**{"file_type": ending.lower().lstrip("."), **how})
    content = written.encode() if isinstance(written, str) else written
    # trimesh writes 3MF in millimetres, and eight digits or float32, 2^-24 of 4, elsewhere.
    unit = 0.001 if ending == "3mf" else 1.0
    found = read_mesh(content, ending, "part")
    assert found.watertight
    assert len(found.faces) == len(expected.faces)
    assert found.volume == pytest.approx(expected.volume * unit**3, rel=1e-6)
    assert found.com == pytest.approx(expected.com * unit, abs=1e-6 * unit)
    assert found.inertia == pytest.approx(expected.inertia * unit**5, abs=1e-6 * unit**5)


def test_a_binary_stl_that_begins_with_solid_is_binary() -> None:
    content = b"solid part made by a careless program".ljust(80) + as_stl(part())[80:]
    assert read_mesh(content, "stl", "part").volume == pytest.approx(part().volume, rel=1e-6)


def test_an_ascii_stl_may_shout_and_scatter_its_white_space() -> None:
    facet = "FACET NORMAL 0 0 1\nOUTER LOOP\nVERTEX 0 0 0\n\tVERTEX 1\t0 0\nVERTEX 0 1E0 0\n"
    content = f"  SOLID\n{facet}ENDLOOP ENDFACET\nENDSOLID".encode()
    found = read_mesh(content, "stl", "part")
    assert found.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]


def test_an_obj_counts_back_and_cuts_polygons() -> None:
    content = b"v 0 0 0\nv 1 0 0\nv 1 1 0 0.5 0.5 0.5\nv 0 1 0\nvn 0 0 1\nf -4/1/1 -3//1 3/2 4\n"
    found = read_mesh(content, "obj", "part")
    assert found.faces.tolist() == [[0, 1, 2], [0, 2, 3]]


@pytest.mark.parametrize("order", ["<", ">"])
def test_a_binary_ply_of_either_order_may_mix_polygons(order: str) -> None:
    name = "little" if order == "<" else "big"
    header = (
        f"ply\nformat binary_{name}_endian 1.0\ncomment by hand\nelement vertex 5\n"
        "property double z\nproperty float y\nproperty short x\nelement face 2\n"
        "property uchar red\nproperty list uchar int vertex_indices\nend_header\n"
    )
    kind = np.dtype([("z", order + "f8"), ("y", order + "f4"), ("x", order + "i2")])
    rows = np.array([(0, 0, 0), (0, 0, 1), (0, 1, 1), (0, 1, 0), (7, 0, 0)], dtype=kind)
    faces = b"".join(
        bytes((200, len(face))) + np.array(face, dtype=order + "i4").tobytes()
        for face in ([0, 1, 2, 3], [0, 1, 4])
    )
    found = read_mesh(header.encode() + rows.tobytes() + faces, "ply", "part")
    assert found.vertices[4].tolist() == [0, 0, 7]
    assert found.vertices[2].tolist() == [1, 1, 0]
    assert found.faces.tolist() == [[0, 1, 2], [0, 2, 3], [0, 1, 4]]


@pytest.mark.parametrize(
    ("unit", "metres"), [("millimeter", 1e-3), ("inch", 0.0254), ("meter", 1.0)]
)
def test_a_3mf_is_given_in_metres(unit: str, metres: float) -> None:
    model = f'<resources>{OBJECT.format(id=1)}</resources><build><item objectid="1"/></build>'
    found = read_mesh(package(model, unit), "3mf", "part")
    assert found.volume == pytest.approx(metres**3 / 6, rel=1e-12)


def test_a_3mf_places_the_parts_of_its_parts() -> None:
    # Twice as large along x, then shifted by 10 along y, then mirrored along z.
    part = (
        '<object id="2"><components><component objectid="1" transform="2 0 0 0 1 0 0 0 1 0 10 0"/>'
    )
    model = (
        f"<resources>{OBJECT.format(id=1)}{part}</components></object></resources><build>"
        '<item objectid="2" transform="1 0 0 0 1 0 0 0 -1 0 0 0"/></build>'
    )
    found = read_mesh(package(model), "3mf", "part")
    # A tetrahedron of volume 1/6, centre 1/4: twice as wide, and right side out though mirrored.
    assert found.volume == pytest.approx(2 / 6, rel=1e-12)
    assert found.com == pytest.approx((0.5, 10.25, -0.25), abs=1e-12)


def test_a_collada_scene_is_placed_and_given_in_metres() -> None:
    found = read_mesh(DAE.encode(), "dae", "part")
    # In centimetres: x' = 5 - y, y' = x, by the quarter turn about z and the shift after it.
    assert found.volume == pytest.approx(1e-6 / 6, rel=1e-9)
    assert found.com == pytest.approx((0.0475, 0.0025, 0.0025), abs=1e-12)


def test_what_is_written_for_the_engine_is_the_same_mesh() -> None:
    import mujoco

    expected = part()
    assert np.array_equal(read_mesh(as_obj(expected), "obj", "x").vertices, expected.vertices)
    assert np.array_equal(read_mesh(as_obj(expected), "obj", "x").faces, expected.faces)
    for name, content in {"part.stl": as_stl(expected), "part.obj": as_obj(expected)}.items():
        spec = mujoco.MjSpec()
        spec.add_mesh(name="part", file=name, inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_EXACT)
        body = spec.worldbody.add_body()
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="part", density=1.0)
        spec.assets = {name: content}
        model = spec.compile()
        # Float32, 2^-24 of coordinates up to 4, on a part of size 2: 1e-6 covers it.
        assert model.body_mass[1] == pytest.approx(expected.volume, rel=1e-6)
        moments = np.sort(np.linalg.eigvalsh(expected.inertia))
        assert np.sort(model.body_inertia[1]) == pytest.approx(moments, rel=1e-5)


def test_a_polygon_with_a_dent_keeps_its_area() -> None:
    # A square of side 2 without the triangle (2, 0), (2, 2), (1, 1): area 4 - 1 = 3.
    corners = np.array([(0, 0), (2, 0), (1, 1), (2, 2), (0, 2)], dtype=float)
    faces = fans(np.array([1, 2, 3, 4, 0]), np.array([5]))
    a, b, c = (corners[faces[:, at]] for at in range(3))
    across = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    assert across.sum() / 2 == pytest.approx(3.0, abs=1e-15)
