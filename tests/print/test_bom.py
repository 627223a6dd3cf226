from __future__ import annotations

import csv
import io
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from morph.print.bom import COLUMNS, bill, harmless
from morph.print.job import Job
from morph.print.mesh import Mesh
from morph.print.part import Part, Placement, Seat
from morph.print.printer import Profile, material, printer
from morph.print.weight import box

BOX = trimesh.creation.box(extents=(10.0, 20.0, 30.0))
ARM = Part(
    name="arm",
    kind="printed",
    mesh=Mesh(vertices=np.asarray(BOX.vertices), faces=np.asarray(BOX.faces)),
    placements=tuple(
        Placement(link=link, pose=np.eye(4), world=np.eye(4)) for link in ("one", "two", "two")
    ),
    hand="left",
    seats=(Seat(holds="M3", position=np.zeros(3), axis=np.array([0, 0, 1.0]), bore_mm=3.4),),
    weight=box(0.01234, np.array([10.0, 20.0, 30.0])),
    number="P-01",
)
SERVO = replace(ARM, name="sts3215", kind="bought", hand="", seats=(), number="B-01", mesh=None)


def rows(*parts: Part, refused: tuple[Part, ...] = ()) -> list[dict[str, str]]:
    job = Job(
        profile=Profile(printer=printer("mk4"), material=material("petg")),
        parts=parts,
        refused=refused,
        checks=(),
        orientations={},
        sliced={},
        plates=(),
    )
    return list(csv.DictReader(io.StringIO(bill(job), newline="")))


def test_a_part_is_one_line_with_what_one_copy_weighs() -> None:
    arm, servo, screw = rows(ARM, SERVO)
    assert tuple(arm) == COLUMNS
    assert arm == {
        "number": "P-01",
        "name": "arm",
        "kind": "printed",
        "hand": "left",
        "count": "3",
        "material": "petg",
        "grams_each": "12.34",
        "links": "one two",
        "file": "parts/arm.stl",
        "note": "",
    }
    assert (servo["kind"], servo["material"], servo["file"]) == ("bought", "", "")
    # One seat in each of three copies at one place: three screws of which none is cut into.
    assert (screw["name"], screw["kind"], screw["count"]) == ("M3", "screw", "3")


def test_pieces_and_what_is_refused_say_so() -> None:
    piece = replace(ARM, name="rail_1", piece_of="rail", seats=())
    fused = replace(ARM, name="lid", kind="fused", into="arm", seats=())
    found = rows(piece, fused, refused=(replace(ARM, name="horn", weight=None, seats=()),))
    assert [each["note"] for each in found] == ["piece of rail", "in one with arm", ""]
    assert [each["kind"] for each in found] == ["printed", "fused", "refused"]
    assert found[2]["grams_each"] == ""


@pytest.mark.parametrize("text", ["=1+1", "+1", "-1", "@SUM(A1)", "\t=1", "\r=1", "\n=1"])
def test_no_cell_is_a_formula(text: str) -> None:
    (row,) = rows(replace(SERVO, name=text))
    assert row["name"] == harmless(text) == f"'{text}"


def test_commas_and_quotes_stay_in_their_cell() -> None:
    (row,) = rows(replace(SERVO, name='a, "b"\nc'))
    assert row["name"] == 'a, "b"\nc'
