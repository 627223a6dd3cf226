from __future__ import annotations

import itertools
from collections.abc import Callable

import manifold3d
import numpy as np
import pytest
import trimesh

from morph.print.errors import SplitError
from morph.print.mesh import Mesh, from_manifold, joined
from morph.print.orient import fits
from morph.print.part import Part, Placement, Seat
from morph.print.printer import Profile, material, printer
from morph.print.split import split

PROFILE = Profile(printer=printer("ender3"), material=material("pla"))
"""Its bed is 220 x 220 mm and 250 high."""
PLAY = PROFILE.clearance_mm


def part(solid: manifold3d.Manifold, *seats: Seat) -> Part:
    here = Placement(link="body", pose=np.eye(4), world=np.eye(4))
    return Part(
        name="bar",
        kind="printed",
        mesh=from_manifold(solid),
        placements=(here, here),
        seats=seats,
        number="P-07",
        hand="left",
    )


def cube(*size: float) -> manifold3d.Manifold:
    return manifold3d.Manifold.cube(size, True)


def mesh(piece: Part) -> Mesh:
    assert piece.mesh is not None
    return piece.mesh


def overlap(one: Mesh, other: Mesh) -> float:
    return float((one.manifold ^ other.manifold).volume())


def rod(length: float, radius: float, bore: float = 0.0) -> manifold3d.Manifold:
    solid = manifold3d.Manifold.cylinder(length, radius, radius, 64)
    return solid - manifold3d.Manifold.cylinder(length, bore, bore, 64) if bore else solid


# Made when they are asked for: manifold3d complains of solids that outlive it.
WHOLES: dict[str, tuple[Callable[[], manifold3d.Manifold], int]] = {
    "a bar of 400 mm": (lambda: cube(400, 30, 20), 2),
    # Across the bed (272.7 + 25) / sqrt(2) = 210.5: slices of 3000 / 11, 20 mm thick, on edge 208.
    "a rail of 3 m": (lambda: cube(3000, 25, 20), 11),
    "a deck of 400 by 400": (lambda: cube(400, 400, 12), 4),
    "a rod of radius 9": (lambda: rod(500, 9), 2),
    "a rod of radius 4": (lambda: rod(400, 4), 2),
    "a tube with a stout wall": (lambda: rod(500, 20, bore=14), 2),
}


@pytest.mark.parametrize("name", WHOLES)
def test_pieces_fit_the_bed_and_make_up_the_whole(name: str) -> None:
    drawn, count = WHOLES[name]
    solid = drawn()
    pieces = split(part(solid), PROFILE)
    assert len(pieces) == count
    assert all(fits(mesh(piece), PROFILE) for piece in pieces)
    assert all(len(mesh(piece).manifold.decompose()) == 1 for piece in pieces)
    # Together they are the whole but for the play around pins: at most 10.4 mm long, on 2 pi 5 of
    # edge 0.2 mm and 0.4 mm on pi 5^2 below, and a rim of 0.6 mm: 65 + 33 + 10 = 108 mm3 each.
    union = joined(mesh(piece) for piece in pieces)
    missing = solid.volume() - union.volume
    assert 0.0 < missing < 2 * 108.0 * 4 * count
    assert (union.manifold - solid).volume() < 1e-3
    # No two take the same room.
    assert all(overlap(mesh(a), mesh(b)) < 1e-3 for a, b in itertools.combinations(pieces, 2))


@pytest.mark.parametrize("name", ["a bar of 400 mm", "a rod of radius 9", "a rod of radius 4"])
def test_turned_by_half_a_turn_pieces_collide(name: str) -> None:
    drawn, _ = WHOLES[name]
    first, second = split(part(drawn()), PROFILE)
    along = np.eye(3)[int(np.argmax(np.ptp(mesh(first).vertices, axis=0)))]
    for angle in (np.pi, np.pi / 2.0):
        turned = trimesh.transformations.rotation_matrix(angle, along)
        assert overlap(mesh(first), mesh(second).moved(turned)) > 0.5


def test_pieces_of_other_joints_do_not_go_together() -> None:
    pieces = split(part(cube(3000, 25, 20)), PROFILE)
    ends = [mesh(piece).bounds[:, 0] for piece in pieces]
    for shift in (1, 2):
        away = np.eye(4)
        # The third piece where the second belongs: its begin at the plane between the first two.
        away[0, 3] = ends[1][0] - ends[1 + shift][0]
        assert overlap(mesh(pieces[0]), mesh(pieces[1 + shift]).moved(away)) > 1.0


def test_pieces_say_whose_they_are() -> None:
    pieces = split(part(cube(400, 30, 20)), PROFILE)
    assert [piece.name for piece in pieces] == ["bar_1", "bar_2"]
    assert [piece.number for piece in pieces] == ["P-07-1", "P-07-2"]
    assert {(piece.piece_of, piece.hand, piece.count) for piece in pieces} == {("bar", "left", 2)}
    assert [np.sign(mesh(piece).bounds.mean(axis=0)[0]) for piece in pieces] == [-1.0, 1.0]


def test_nothing_is_cut_where_something_sits_and_each_seat_goes_with_its_piece() -> None:
    pocket = from_manifold(cube(40, 10, 30).translate((10.0, 0.0, 0.0)))
    servo = Seat(
        holds="STS3215",
        position=np.array([10.0, 0.0, 10.0]),
        axis=np.array([0.0, 0.0, 1.0]),
        bore_mm=0.0,
        pocket=pocket,
    )
    screw = Seat(
        holds="M3", position=np.array([-150.0, 0, 10]), axis=np.array([0, 0, 1.0]), bore_mm=3.4
    )
    solid = cube(400, 30, 20) - cube(40, 10, 30).translate((10.0, 0.0, 0.0))
    first, second = split(part(solid, servo, screw), PROFILE)
    # The pocket spans -10 to 30, and 3 mm more are spared.
    ends = np.stack([mesh(first).bounds[:, 0], mesh(second).bounds[:, 0]])
    assert ends[0, 1] < -13.0 + 10.5 or ends[1, 0] > 33.0 - 10.5
    assert overlap(mesh(first), pocket) == pytest.approx(0.0, abs=1e-6)
    assert sorted([seat.holds for seat in piece.seats] for piece in (first, second)) == [
        ["M3"],
        ["STS3215"],
    ]


@pytest.mark.parametrize("size", [(100.0, 50.0, 30.0), (270.0, 20.0, 20.0)])
def test_what_fits_stays_whole(size: tuple[float, ...]) -> None:
    # (270 + 20) / sqrt(2) = 205 < 210.
    whole = part(cube(*size))
    assert split(whole, PROFILE) == (whole,)


def test_a_tube_with_a_thin_wall_is_refused_with_the_reason() -> None:
    with pytest.raises(SplitError, match=r"part bar: .*radius of 1\.[345] mm.*needs 2\.35 mm"):
        split(part(rod(500, 20, bore=17)), PROFILE)


def test_what_is_no_solid_is_refused() -> None:
    box = trimesh.creation.box(extents=(400.0, 30.0, 20.0))
    holed = Mesh(vertices=np.asarray(box.vertices), faces=np.asarray(box.faces)[1:])
    here = Placement(link="body", pose=np.eye(4), world=np.eye(4))
    whole = Part(name="bar", kind="printed", mesh=holed, placements=(here,))
    with pytest.raises(SplitError, match="what is no solid cannot be cut"):
        split(whole, PROFILE)
