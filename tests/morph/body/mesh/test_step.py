"""STEP, on a box whose boundary is written here face by face."""

from __future__ import annotations

import importlib.util

import numpy as np
import pytest

from morph.body.mesh import read_mesh
from morph.errors import MeshError

HEAD = """ISO-10303-21;
HEADER;
FILE_DESCRIPTION((''),'2;1');
FILE_NAME('box','2020-01-01T00:00:00',(''),(''),'','','');
FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));
ENDSEC;
DATA;
"""


class Writer:
    """Numbers the entities of a STEP file as they are added."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def add(self, entity: str) -> str:
        self.lines.append(f"#{len(self.lines) + 1}={entity};")
        return f"#{len(self.lines)}"

    def triple(self, kind: str, values: np.ndarray) -> str:
        return self.add(f"{kind}('',({','.join(f'{value:.6f}' for value in values)}))")


def box_in_step(size: np.ndarray) -> bytes:
    """A box from the origin to `size`, mm, as AP214 holds it."""
    w = Writer()
    corner = {
        key: np.array(key) * size
        for key in ((i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1))
    }
    vertex = {
        key: w.add(f"VERTEX_POINT('',{w.triple('CARTESIAN_POINT', at)})")
        for key, at in corner.items()
    }
    edges: dict[tuple[object, object], str] = {}

    def edge(start: tuple[int, ...], end: tuple[int, ...]) -> str:
        low, high = min(start, end), max(start, end)
        if (low, high) not in edges:
            way = (corner[high] - corner[low]) / np.linalg.norm(corner[high] - corner[low])
            vector = w.add(f"VECTOR('',{w.triple('DIRECTION', way)},1.)")
            line = w.add(f"LINE('',{w.triple('CARTESIAN_POINT', corner[low])},{vector})")
            edges[low, high] = w.add(f"EDGE_CURVE('',{vertex[low]},{vertex[high]},{line},.T.)")
        forward = ".T." if start == low else ".F."
        return w.add(f"ORIENTED_EDGE('',*,*,{edges[low, high]},{forward})")

    faces = []
    for axis in range(3):
        for side in (0, 1):
            u, v = ((axis + 1) % 3, (axis + 2) % 3) if side else ((axis + 2) % 3, (axis + 1) % 3)
            ring = []
            for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)):
                key = [side, side, side]
                key[u], key[v] = a, b
                ring.append(tuple(key))
            sides = ",".join(edge(ring[at], ring[(at + 1) % 4]) for at in range(4))
            loop = f"EDGE_LOOP('',({sides}))"
            bound = w.add(f"FACE_OUTER_BOUND('',{w.add(loop)},.T.)")
            normal = np.eye(3)[axis] * (1 if side else -1)
            at = w.triple("CARTESIAN_POINT", corner[ring[0]])
            axes = f"{w.triple('DIRECTION', normal)},{w.triple('DIRECTION', np.eye(3)[u])}"
            placement = w.add(f"AXIS2_PLACEMENT_3D('',{at},{axes})")
            plane = w.add(f"PLANE('',{placement})")
            faces.append(w.add(f"ADVANCED_FACE('',({bound}),{plane},.T.)"))
    shell = w.add(f"CLOSED_SHELL('',({','.join(faces)}))")
    solid = w.add(f"MANIFOLD_SOLID_BREP('',{shell})")
    length = w.add("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))")
    angle = w.add("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))")
    solid_angle = w.add("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())")
    fuzz = w.add(f"UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E-7),{length},'','')")
    context = w.add(
        "(GEOMETRIC_REPRESENTATION_CONTEXT(3)"
        f"GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT(({fuzz}))"
        f"GLOBAL_UNIT_ASSIGNED_CONTEXT(({length},{angle},{solid_angle}))"
        "REPRESENTATION_CONTEXT('',''))"
    )
    shape = w.add(f"ADVANCED_BREP_SHAPE_REPRESENTATION('',({solid}),{context})")
    application = w.add("APPLICATION_CONTEXT('automotive design')")
    mechanical = w.add(f"PRODUCT_CONTEXT('',{application},'mechanical')")
    product = w.add(f"PRODUCT('box','box','',({mechanical}))")
    formation = w.add(f"PRODUCT_DEFINITION_FORMATION('','',{product})")
    design = w.add(f"PRODUCT_DEFINITION_CONTEXT('part definition',{application},'design')")
    definition = w.add(f"PRODUCT_DEFINITION('','',{formation},{design})")
    held = w.add(f"PRODUCT_DEFINITION_SHAPE('','',{definition})")
    w.add(f"SHAPE_DEFINITION_REPRESENTATION({held},{shape})")
    return (HEAD + "\n".join(w.lines) + "\nENDSEC;\nEND-ISO-10303-21;\n").encode()


def test_a_box_of_millimetres_is_given_in_metres() -> None:
    pytest.importorskip("cascadio")
    found = read_mesh(box_in_step(np.array((30.0, 20.0, 10.0))), ".STP", "box")
    # glTF holds float32: 2^-24 of each edge.
    assert found.watertight
    assert found.volume == pytest.approx(6e-6, rel=1e-6)
    assert found.bounds == pytest.approx(np.array([(0, 0, 0), (0.03, 0.02, 0.01)]), abs=1e-8)


@pytest.mark.parametrize("content", [b"rubbish", HEAD.encode(), HEAD.encode() + b"#1=\xff(;" * 99])
def test_what_is_no_step_is_refused(content: bytes) -> None:
    pytest.importorskip("cascadio")
    with pytest.raises(MeshError, match=r"^box: ") as caught:
        read_mesh(content, "step", "box")
    assert caught.value.code == "mesh-unreadable"


def test_without_the_extra_the_error_names_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(MeshError, match=r"pip install 'morph-robotics\[step\]'"):
        read_mesh(HEAD.encode(), "stp", "box")
