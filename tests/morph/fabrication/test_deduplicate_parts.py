from __future__ import annotations

import numpy as np

from morph.body.load import load
from morph.fabrication.deduplicate_parts import made
from morph.fabrication.drawing import drawing
from morph.fabrication.groups import PieceGroup
from morph.fabrication.names import UniqueNames
from morph.fabrication.pieces import Piece
from morph.print.mesh import Mesh, from_manifold
from morph.print.part import Part
from morph.print.printer import Profile, material, printer
from morph.print.skeleton import Skeleton
from morph.print.solid import box

PROFILE = Profile(printer=printer("mk4"), material=material("pla"))


def room(x: float) -> Mesh:
    """Room of 4 mm along x from x, across the block below."""
    return from_manifold(box((x, -20.0, -20.0), (x + 4.0, 20.0, 0.0)))


def piece(*rooms: Mesh) -> Piece:
    block = from_manifold(box((-20.0, -10.0, -10.0), (20.0, 10.0, 10.0)))
    body = Skeleton(name="cart", solids=(block,), spared=rooms)
    return Piece(name="cart", link="cart", source=body, pose=np.eye(4))


def part(group: PieceGroup) -> Part:
    (found,) = made(drawing(load("cartpole")), group, PROFILE, UniqueNames()).parts
    return found


def test_a_part_keeps_out_of_the_room_that_any_of_its_copies_needs() -> None:
    half_turn = np.diag([-1.0, -1.0, 1.0, 1.0])
    one, other = piece(room(10.0)), piece(room(10.0))
    found = part(PieceGroup(members=[(one, np.eye(4)), (other, half_turn)])).mesh
    assert found is not None
    # 40 x 20 x 20 mm less two slots of 4 x 20 x 10, one of them half a turn away. A block is
    # grown by 0.005 mm on all sides: at most 4000 mm2 * 0.01 mm = 40 mm3.
    assert abs(found.volume - (16000.0 - 2 * 800.0)) < 40.0
    inside = found.trimesh.contains([[12.0, 0.0, -5.0], [-12.0, 0.0, -5.0], [0.0, 0.0, -5.0]])
    assert inside.tolist() == [False, False, True]


def test_a_room_that_takes_all_is_left_out_and_the_others_are_kept() -> None:
    everything = from_manifold(box((-30.0, -30.0, -30.0), (30.0, 30.0, 30.0)))
    group = PieceGroup(members=[(piece(room(10.0), everything), np.eye(4))])
    found = made(drawing(load("cartpole")), group, PROFILE, UniqueNames())
    (check,) = found.checks
    assert check.verdict == "noted"
    assert "nothing is left of it" in check.what
    mesh = found.parts[0].mesh
    assert mesh is not None
    assert abs(mesh.volume - (16000.0 - 800.0)) < 40.0
