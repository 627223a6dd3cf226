"""Bytes that no mesh should hold are refused by name, soon, and in little memory."""

from __future__ import annotations

import io
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from morph.body.mesh import Mesh, as_stl, read_mesh
from morph.body.mesh.read import READERS
from morph.errors import MeshError

STUB = b"version https://git-lfs.github.com/spec/v1\noid sha256:aa\nsize 4\n"
PLY = "ply\nformat {0} 1.0\nelement vertex {1}\nproperty float x\nproperty float y\n"
PLY += "property float z\nelement face {2}\nproperty list {3} int vertex_indices\nend_header\n"
DAE = '<COLLADA><library_visual_scenes><visual_scene id="w">{}</visual_scene>'
DAE += '</library_visual_scenes><scene><instance_visual_scene url="#w"/></scene></COLLADA>'
TYPE = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"
RELATIONS = f'<R><Relationship Id="a" Target="/a.model" Type="{TYPE}"/></R>'
ENTITY = '<!DOCTYPE a [<!ENTITY b "bbbb">]>'


def corners(*values: float) -> bytes:
    """A binary STL with one face, whose corners begin with some values."""
    vertices = np.arange(9.0)
    vertices[: len(values)] = 0.0
    content = bytearray(as_stl(Mesh(vertices=vertices.reshape(3, 3), faces=np.array([(0, 1, 2)]))))
    content[96 : 96 + 4 * len(values)] = np.array(values, dtype="<f4").tobytes()
    return bytes(content)


def ply(order: str, vertices: int, faces: int, count: str, body: bytes = b"") -> bytes:
    return PLY.format(order, vertices, faces, count).encode() + body


def package(model: bytes, relations: str = RELATIONS) -> bytes:
    sink = io.BytesIO()
    with zipfile.ZipFile(sink, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as writer:
        writer.writestr("_rels/.rels", relations)
        writer.writestr("a.model", model)
    return sink.getvalue()


def levels(depth: int) -> bytes:
    """Objects of which each holds the one below it ten times."""
    cube = '<object id="0"><mesh><vertex x="0" y="0" z="0"/><triangle v1="0" v2="0" v3="0"/></mesh>'
    rest = "".join(
        f'</object><object id="{at}">' + f'<component objectid="{at - 1}"/>' * 10
        for at in range(1, depth)
    )
    return f'<model>{cube}{rest}</object><item objectid="{depth - 1}"/></model>'.encode()


def nodes(depth: int) -> bytes:
    """Nodes of which each shows the one below it ten times."""
    inner = "".join(
        f'<node id="{at}">' + f'<instance_node url="#{at - 1}"/>' * 10 + "</node>"
        for at in range(1, depth)
    )
    return DAE.format(f'<node id="0"/>{inner}<instance_node url="#{depth - 1}"/>').encode()


UNREADABLE, EMPTY, LARGE = "mesh-unreadable", "mesh-empty", "mesh-too-large"
CASES: dict[str, tuple[str, bytes, str, str]] = {
    "stub": ("stl", STUB, "mesh-lfs-stub", "Git LFS"),
    "stub of an obj": ("obj", STUB, "mesh-lfs-stub", "Git LFS"),
    "nothing": ("stl", b"", EMPTY, "is empty"),
    "white space": ("ply", b"  \n ", EMPTY, "is empty"),
    "no triangle": ("stl", bytes(84), EMPTY, "no faces"),
    "an odd ending": ("exe", b"MZ", UNREADABLE, "end in 'exe'"),
    "65 MiB": ("stl", bytes(65 * 2**20), LARGE, "bytes"),
    "stl: four thousand million triangles": (
        "stl",
        bytes(80) + b"\xff\xff\xff\xff" + bytes(500),
        UNREADABLE,
        "declares 4294967295 triangles",
    ),
    "stl: 34 bytes": ("stl", b"0" * 34, UNREADABLE, "has 34 bytes"),
    "stl: cut short": ("stl", corners()[:-1], UNREADABLE, "134 bytes, and has 133"),
    "stl: not a number": ("stl", corners(float("nan")), UNREADABLE, "corner 0 is at"),
    "stl: infinite": ("stl", corners(1.0, float("-inf")), UNREADABLE, "corner 0 is at"),
    "stl: absurdly far": ("stl", corners(1.0, 1.0, 3e38), UNREADABLE, "within 1e"),
    "stl: a facet of two": (
        "stl",
        b"solid\nfacet\nvertex 0 0 0\nvertex 1 0 0\nendfacet",
        UNREADABLE,
        "1 facets have 2",
    ),
    "stl: words": ("stl", b"solid\nvertex a b c\nendfacet", UNREADABLE, "vertex 0 cannot"),
    "obj: corner 9 of 3": ("obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9", UNREADABLE, "corner 8"),
    "obj: corner 0": ("obj", b"v 0 0 0\nf 0 1 1", UNREADABLE, "part:2"),
    "obj: two corners": ("obj", b"v 0 0 0\nf 1 1", UNREADABLE, "part:2"),
    "obj: before the first": ("obj", b"v 0 0 0\nf 1 1 -2", UNREADABLE, "corner -1"),
    "obj: a wide number": ("obj", b"v 0 0 0\nf 1 1 99999999999999999999", UNREADABLE, "part:2"),
    "obj: one long face": ("obj", b"v 0 0 0\nf" + b" 1" * 2**24, UNREADABLE, "part:2"),
    "obj: many faces": ("obj", b"v 0 0 0" + b"\nf 1 1 1" * 2_000_001, LARGE, "2000000 lines f"),
    "ply: no end": ("ply", b"ply\nformat ascii 1.0\n", UNREADABLE, "does not end"),
    "ply: many corners": ("ply", ply("ascii", 4 * 10**9, 1, "uchar"), UNREADABLE, "4000000000"),
    "ply: many faces": (
        "ply",
        ply("binary_little_endian", 0, 3 * 10**6, "uchar", bytes(4 * 10**6)),
        LARGE,
        "3000000 faces",
    ),
    "ply: a face of many": (
        "ply",
        ply("binary_little_endian", 1, 1, "uint", bytes(12) + b"\xff" * 4),
        UNREADABLE,
        "a face has 4294967295",
    ),
    "ply: ends early": (
        "ply",
        ply("ascii", 2, 1, "uchar", b"0 0 0\n"),
        UNREADABLE,
        "vertex 1 of 2",
    ),
    "ply: counted in fractions": ("ply", ply("ascii", 1, 1, "float"), UNREADABLE, "ends at"),
    "3mf: no archive": ("3mf", b"PK\x03\x04 and no more", UNREADABLE, "BadZipFile"),
    "3mf: a hundred million zeros": (
        "3mf",
        package(bytes(10**8)),
        LARGE,
        "unpacks to more",
    ),
    "3mf: parts of parts": ("3mf", package(levels(12)), LARGE, "more than 10000 parts"),
    "3mf: a part of itself": (
        "3mf",
        package(
            b'<model><object id="1"><component objectid="1"/></object><item objectid="1"/></model>'
        ),
        UNREADABLE,
        "more than 32 deep",
    ),
    "3mf: an entity": ("3mf", package(f"{ENTITY}<model/>".encode()), UNREADABLE, "document type"),
    "3mf: another file": (
        "3mf",
        package(b"<model/>", RELATIONS.replace("/a.model", "../../../etc/passwd")),
        UNREADABLE,
        "no item named",
    ),
    "3mf: many files": ("3mf", b"PK\x01\x02" * 10_001, LARGE, "more than the 10000 files"),
    "dae: not xml": ("dae", b"<COLLADA><", UNREADABLE, "is not XML"),
    "dae: an entity": ("dae", f"{ENTITY}<COLLADA>&b;</COLLADA>".encode(), UNREADABLE, "entity"),
    "dae: nodes of nodes": ("dae", nodes(12), LARGE, "more than 10000 parts"),
    "dae: corners without a place": (
        "dae",
        DAE.format(
            '<node><instance_geometry url="#g"/></node><geometry id="g"><mesh><vertices id="v"/>'
            '<triangles><input semantic="VERTEX" source="#v"/><p>0 0 0</p></triangles></mesh>'
            "</geometry>"
        ).encode(),
        UNREADABLE,
        "KeyError('POSITION')",
    ),
    "dae: a dangling name": (
        "dae",
        DAE.format('<node><instance_geometry url="#g"/></node>').encode(),
        UNREADABLE,
        "KeyError",
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_is_refused_by_name(case: str) -> None:
    ending, content, code, words = CASES[case]
    with pytest.raises(MeshError) as caught:
        read_mesh(content, ending, "part")
    assert caught.value.code == code
    assert words in str(caught.value)
    assert caught.value.where.startswith("part")


MEASURE = """
import importlib.util, sys, time
spec = importlib.util.spec_from_file_location("cases", sys.argv[1])
cases = importlib.util.module_from_spec(spec)
spec.loader.exec_module(cases)

def peak():
    lines = open("/proc/self/status").read().splitlines()
    return next(int(line.split()[1]) / 1024 for line in lines if line.startswith("VmHWM"))

before = peak()
for case, (ending, content, _, _) in cases.CASES.items():
    start = time.process_time()
    try:
        cases.read_mesh(content, ending, "part")
    except cases.MeshError:
        pass
    seconds = time.process_time() - start
    if seconds > float(sys.argv[2]):
        print(f"{case} took {seconds:.2f} s")
if peak() - before > 200.0:
    print(f"took {peak() - before:.0f} MB above {before:.0f} MB")
"""


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="peaks are read from /proc")
def test_each_refusal_takes_under_a_second_and_200_megabytes(
    slowness: Callable[[], float],
) -> None:
    command = [sys.executable, "-c", MEASURE, __file__, str(2.0 * slowness())]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=600, check=True)
    assert ended.stdout == ""


ENDINGS = sorted(set(READERS) - {"step", "stp"})
"""STEP is converted in a process of its own, at a second each."""


@settings(max_examples=300, deadline=None)
@given(ending=st.sampled_from(ENDINGS), content=st.binary(max_size=400))
@example(ending="ply", content=ply("binary_big_endian", 1, 1, "uchar", bytes(13)))
@example(ending="ply", content=ply("ascii", 1, 1, "uchar", b"nan 0 0\n3 0 0 0"))
@example(ending="stl", content=b"solid \xff\nendfacet")
def test_rubbish_is_refused_and_never_crashes(ending: str, content: bytes) -> None:
    try:
        mesh = read_mesh(content, ending, "part")
    except MeshError:
        return
    assert np.isfinite(mesh.vertices).all()


GOOD = {
    "stl": corners(),
    "obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1/1 2/2 4/4\nf -4 4 3\nf 2 3 4\n",
    "ply": ply("ascii", 3, 1, "uchar", b"0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"),
    "3mf": package(levels(3)),
    "dae": nodes(3),
}


@settings(max_examples=300, deadline=None)
@given(ending=st.sampled_from(ENDINGS), data=st.data())
def test_a_good_file_with_bytes_changed_is_read_or_refused(
    ending: str, data: st.DataObject
) -> None:
    content = bytearray(GOOD[ending])
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(content) - 1))
        content[at : at + data.draw(st.integers(0, 3))] = data.draw(st.binary(max_size=3))
        content = content or bytearray(b" ")
    try:
        mesh = read_mesh(bytes(content), ending, "part")
    except MeshError:
        return
    # Whatever was read has facts, too.
    assert np.isfinite(mesh.volume)
    assert mesh.inertia.shape == (3, 3)
    assert mesh.watertight in (True, False)
