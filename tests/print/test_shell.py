from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from morph.print.arrays import Array
from morph.print.errors import SeatError, SolidError
from morph.print.gate import check_part
from morph.print.mesh import Mesh, from_manifold
from morph.print.part import Part
from morph.print.printer import Profile, material, printer
from morph.print.servo import SERVOS, ServoSize, case, servo
from morph.print.shell import HAIR_MM, Shell, shell
from morph.print.skeleton import Mount, Skeleton
from morph.print.solid import box, frame, placed

PROFILE = Profile(printer=printer("mk4"), material=material("pla"))
PLAY = PROFILE.clearance_mm


def block(low: tuple[float, ...], high: tuple[float, ...]) -> Mesh:
    return from_manifold(box(low, high))


def accepted(grown: Shell, name: str = "part") -> None:
    """See that it is one solid that the gate lets pass."""
    assert len(grown.mesh.manifold.decompose()) == 1
    part = Part(name=name, kind="printed", mesh=grown.mesh, placements=(), seats=grown.seats)
    _, checks = check_part(part, PROFILE)
    assert [check for check in checks if check.verdict == "refused"] == []


def test_a_block_with_a_pocket_is_the_block_less_the_pocket() -> None:
    low, high = (-40.0, -30.0, -60.0), (60.0, 30.0, 0.0)
    mount = Mount(servo="MX-28", pose=np.eye(4))
    grown = shell(Skeleton(name="part", solids=(block(low, high),), servos=(mount,)), PROFILE)
    which = servo("MX-28")
    sides = np.subtract(high, low) + 2 * HAIR_MM
    room = (which.length_mm + 2 * PLAY) * (which.width_mm + 2 * PLAY) * (which.height_mm + PLAY)
    wires = (30.0 - 14.0) * 20.0 * 6.0
    # The hair above z = 0 over the pocket is cut with it: 0.005 * (51 * 36 + the horn's rim).
    assert grown.mesh.volume == pytest.approx(math.prod(sides) - room - wires, abs=15.0)
    accepted(grown)


@pytest.mark.parametrize("which", SERVOS, ids=lambda each: each.name)
def test_a_servo_alone_gets_a_case_that_it_goes_into(which: ServoSize) -> None:
    pose = frame(np.array([10.0, -20.0, 30.0]), np.array([1.0, 2.0, 2.0]))
    mount = Mount(servo=which.name, pose=pose)
    grown = shell(Skeleton(name="part", solids=(), servos=(mount,)), PROFILE)
    inside = placed(case(which).manifold, pose)
    for out in (0.0, 5.0, which.height_mm):
        moved = inside.translate([float(x) for x in out * pose[:3, 2]])
        assert (moved ^ grown.mesh.manifold).volume() == pytest.approx(0.0, abs=1e-6)
    assert grown.seats[0].holds == which.name
    assert len(grown.seats) == 1 + len(which.holes_mm)
    accepted(grown)


@pytest.mark.parametrize("which", SERVOS, ids=lambda each: each.name)
def test_what_a_servo_turns_is_clear_of_it(which: ServoSize) -> None:
    # A bar that passes through the servo: the joint's frame is often drawn inside the case.
    bar = block((-4.0, -4.0, -10.0), (4.0, 80.0, 12.0))
    room = from_manifold(case(which).manifold.hull())
    mount = Mount(servo=which.name, pose=np.eye(4))
    grown = shell(Skeleton(name="part", solids=(bar,), horns=(mount,), spared=(room,)), PROFILE)
    assert (grown.mesh.manifold ^ case(which).manifold).volume() == pytest.approx(0.0, abs=1e-6)
    assert grown.mesh.bounds[0, 2] <= which.horn.top_mm + 1e-6
    accepted(grown)


def test_pieces_that_lie_apart_are_joined() -> None:
    apart = (block((0, 0, 0), (10, 10, 10)), block((60, 0, 0), (70, 10, 10)))
    grown = shell(Skeleton(name="part", solids=apart), PROFILE)
    assert any("2 separate pieces are joined" in note for note in grown.notes)
    # At least as thick as three radii of the thinnest strut: pi * 3^2 * 50 mm.
    assert grown.mesh.volume > 2000.0 + math.pi * 9.0 * 50.0 * 0.6
    accepted(grown)


def test_a_strut_goes_around_what_others_sweep() -> None:
    apart = (block((0, 0, 0), (10, 10, 10)), block((60, 0, 0), (70, 10, 10)))
    wall = block((25, -15, -15), (45, 25, 25))
    grown = shell(Skeleton(name="part", solids=apart, spared=(wall,)), PROFILE)
    assert (grown.mesh.manifold ^ wall.manifold).volume() == pytest.approx(0.0, abs=1e-6)
    accepted(grown)


def test_a_piece_that_is_walled_in_is_refused_with_its_place() -> None:
    inner = block((-20, -20, -20), (20, 20, 20))
    outer = block((100, 0, 0), (160, 60, 60))
    cage = from_manifold(box((-50, -50, -50), (50, 50, 50)) - box((-30, -30, -30), (30, 30, 30)))
    with pytest.raises(SolidError, match=r"arm: a piece of 64\.\d cm3 about \(0, 0, 0\) mm"):
        shell(Skeleton(name="arm", solids=(inner, outer), spared=(cage,)), PROFILE)


def test_a_small_piece_that_is_walled_in_and_holds_nothing_is_left_out() -> None:
    inner, outer = block((-6, -6, -6), (6, 6, 6)), block((100, 0, 0), (160, 60, 60))
    cage = from_manifold(box((-20, -20, -20), (20, 20, 20)) - box((-10, -10, -10), (10, 10, 10)))
    grown = shell(Skeleton(name="arm", solids=(inner, outer), spared=(cage,)), PROFILE)
    assert grown.mesh.volume == pytest.approx(60.0**3, rel=1e-3)
    assert grown.notes == (
        "a piece of 1.7 cm3 about (0, 0, 0) mm is left out: nothing can join it",
    )


def test_crumbs_are_left_out_and_told() -> None:
    body = block((0, 0, 0), (40, 40, 40))
    # A cut leaves a plate of 0.5 mm, 800 mm3, beyond what others sweep.
    sweep = block((-1, -1, 35), (41, 41, 39.5))
    grown = shell(Skeleton(name="part", solids=(body,), spared=(sweep,)), PROFILE)
    assert any("1 crumbs of 80" in note for note in grown.notes)
    assert grown.mesh.bounds[1, 2] == pytest.approx(35.0, abs=0.01)


def test_a_thin_plate_is_made_thick_enough_and_told() -> None:
    grown = shell(Skeleton(name="part", solids=(block((0, 0, 0), (50, 30, 0.5)),)), PROFILE)
    assert grown.mesh.extent[2] == pytest.approx(1.6 + 2 * HAIR_MM, abs=1e-3)
    assert grown.mesh.extent[0] == pytest.approx(50.0, abs=0.02)
    assert any("1.6 mm thick" in note for note in grown.notes)


def test_a_box_has_its_room_and_a_way_out() -> None:
    cells = block((-20, -10, 0), (20, 10, 25))
    plate = block((-40, -40, -4), (40, 40, 1))
    grown = shell(Skeleton(name="part", solids=(plate,), boxes=(cells,)), PROFILE)
    for out in (0.0, 10.0, 25.0):
        moved = cells.manifold.translate([0.0, 0.0, out])
        assert (moved ^ grown.mesh.manifold).volume() == pytest.approx(0.0, abs=1e-6)
    # A rim of 8 mm holds it.
    assert grown.mesh.bounds[1, 2] == pytest.approx(8.0, abs=1e-6)
    accepted(grown)


def test_a_mirrored_skeleton_gives_a_mirrored_shell() -> None:
    mirror = np.diag([1.0, -1.0, 1.0, 1.0])
    solids = (block((0, 5, -60), (20, 25, -20)), block((30, 20, -10), (40, 40, 60)))
    pose = frame(np.array([10.0, 20.0, 0.0]), np.array([0.0, 0.3, 1.0]))
    one = Skeleton(name="left", solids=solids, servos=(Mount(servo="STS3215", pose=pose),))
    # A servo's mirror image is itself, turned over in y.
    turned = mirror @ pose @ mirror
    other = Skeleton(
        name="right",
        solids=tuple(mesh.moved(mirror) for mesh in solids),
        servos=(Mount(servo="STS3215", pose=turned),),
    )
    left, right = (shell(each, PROFILE).mesh for each in (one, other))
    both = (left.moved(mirror).manifold ^ right.manifold).volume()
    # Struts may differ by where the first of equally near points is: 1 % of the whole.
    assert both == pytest.approx(left.volume, rel=0.01)
    assert right.volume == pytest.approx(left.volume, rel=0.01)


def test_servos_that_are_drawn_into_each_other_are_told() -> None:
    beside = np.eye(4)
    beside[1, 3] = 30.0
    pair = (Mount(servo="MX-28", pose=np.eye(4)), Mount(servo="MX-28", pose=beside))
    grown = shell(Skeleton(name="arm", solids=(), servos=pair), PROFILE)
    # 35.6 - 30 mm of their width: 5.6 * 50.6 * 35.5 = 10.06 cm3.
    assert any("drawn into each other by 10.1 cm3" in note for note in grown.notes)


def test_a_horn_inside_a_pocket_is_refused() -> None:
    mount = Mount(servo="MX-28", pose=np.eye(4))
    inside = np.eye(4)
    inside[:3, 3] = (12.0, 0.0, -20.0)
    horns = (Mount(servo="AX-12", pose=inside),)
    with pytest.raises(SeatError, match=r"arm: what else the part holds leaves 0% .* AX-12"):
        shell(Skeleton(name="arm", solids=(), servos=(mount,), horns=horns), PROFILE)


@pytest.mark.parametrize(
    "turn", [lambda: np.eye(4), lambda: frame(np.zeros(3), np.array([1.0, 2, 3]))]
)
def test_shapes_that_only_touch_are_one_piece(turn: Callable[[], Array]) -> None:
    pose = turn()
    touching = (block((0, 0, 0), (20, 20, 20)), block((20, 5, 5), (40, 15, 15)))
    skeleton = Skeleton(name="part", solids=tuple(mesh.moved(pose) for mesh in touching))
    grown = shell(skeleton, PROFILE)
    assert not any("struts" in note for note in grown.notes)
    accepted(grown)
