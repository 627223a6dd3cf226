from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import trimesh

from morph.print.clearance import clearances
from morph.print.joint_sweep import MOST_STEPS, Sweep
from morph.print.mesh import Mesh
from morph.print.part import Check, Hinge, Part, Placement
from morph.print.printer import Profile, material, printer

PROFILE = Profile(printer=printer("ender3"), material=material("pla"))


def mesh_of(shape: trimesh.Trimesh) -> Mesh:
    return Mesh(vertices=np.array(shape.vertices), faces=np.array(shape.faces, dtype=np.int64))


def block(
    name: str,
    link: str,
    sides: tuple[float, float, float],
    at: tuple[float, float, float],
    kind: str = "printed",
) -> Part:
    world = np.eye(4)
    world[:3, 3] = at
    return Part(
        name=name,
        kind=kind,  # type: ignore[arg-type]
        mesh=mesh_of(trimesh.creation.box(sides)),
        placements=(Placement(link=link, pose=np.eye(4), world=world),),
    )


def hinge(low: float, high: float, **more: Any) -> Hinge:
    given: dict[str, Any] = {"kind": "hinge", "axis": np.array([0.0, 0.0, 1.0])} | more
    return Hinge(
        name="elbow", position=np.zeros(3), low=low, high=high, still="arm", moving="hand", **given
    )


BASE = block("base", "arm", (20.0, 20.0, 5.0), (0.0, 0.0, -5.0))
# From the axis 60 mm along x, 10 mm wide, above the base.
LEVER = block("lever", "hand", (60.0, 10.0, 5.0), (30.0, 0.0, 2.0))


def judged(*parts: Part, joint: Hinge) -> Check:
    (found,) = clearances(parts, [joint], PROFILE)
    return found


def post(y: float) -> Part:
    """A post at x = 50 mm whose near side is at y, as thick as the lever."""
    return block("post", "arm", (4.0, 4.0, 5.0), (50.0, y + 2.0, 2.0))


def test_parts_above_each_other_never_meet() -> None:
    found = judged(BASE, LEVER, joint=hinge(-2.0, 2.0))
    assert (found.verdict, found.value) == ("passed", 0.0)
    assert found.what == "free from -114.6 deg to 114.6 deg"


@pytest.mark.parametrize(("high", "verdict"), [(2.0, "refused"), (0.45, "noted"), (0.40, "passed")])
def test_a_lever_meets_a_post_where_geometry_says(high: float, verdict: str) -> None:
    # The upper side of the lever, 5 mm beside the axis, meets the post's lower corner, that with
    # the least angle seen so: at (52, 28) the line's angle is atan2(28, 52) - asin(5 / r).
    radius = math.hypot(52.0, 28.0)
    angle = math.atan2(28.0, 52.0) - math.asin(5.0 / radius)
    assert math.degrees(angle) == pytest.approx(23.45, abs=0.05)
    found = judged(BASE, LEVER, post(28.0), joint=hinge(-1.0, high))
    assert found.verdict == verdict
    if verdict == "passed":
        return
    # Positions are 4 mm apart at the lever's end, 61 mm from the axis, halved four times:
    # 4 / 61 / 16 = 0.24 deg; 1 mm3 of 5 mm height is a wedge of 0.2 mm2, reached within 0.5 deg.
    assert found.value == pytest.approx((high - angle) / (high + 1.0), abs=math.radians(0.8) / 1.4)
    assert found.what.startswith("lever meets post at 2")
    assert "free from -57.3 deg to 2" in found.what


def test_both_ends_of_the_range_are_looked_at() -> None:
    below = block("stop", "arm", (4.0, 4.0, 5.0), (50.0, -30.0, 2.0))
    found = judged(BASE, LEVER, post(28.0), below, joint=hinge(-2.0, 2.0))
    # Centred at -30 mm it mirrors the post whose near side is at 28 mm; both as right as above.
    assert found.verdict == "refused"
    assert found.value == pytest.approx(1.0 - 2 * math.radians(23.45) / 4.0, abs=0.01)


def test_a_part_that_fills_its_place_exactly_is_not_in_the_way() -> None:
    # A disc of the hand in a round hole of the arm with no play, and with the same facets.
    disc = trimesh.creation.cylinder(8.0, 5.0, sections=64)
    plate = trimesh.creation.box((30.0, 30.0, 5.0))
    ring = trimesh.boolean.difference([plate, disc], engine="manifold")
    here = Placement(link="arm", pose=np.eye(4), world=np.eye(4))
    there = Placement(link="hand", pose=np.eye(4), world=np.eye(4))
    arm = Part(name="ring", kind="printed", mesh=mesh_of(ring), placements=(here,))
    # Turned by half a facet corners reach 8 (1 - cos(pi / 64)) = 0.0096 mm into the ring:
    # 64 triangles of 0.39 * 0.0096 / 2 mm2 times 5 mm, 0.6 mm3, below the tolerance of 1 mm3.
    hand = Part(name="disc", kind="printed", mesh=mesh_of(disc), placements=(there,))
    assert judged(arm, hand, joint=hinge(-math.inf, math.inf)).verdict == "passed"


@pytest.mark.parametrize(("radius", "verdict"), [(10.0, "passed"), (10.5, "refused")])
def test_a_pin_of_few_facets_turns_in_a_hole_of_its_own_size(radius: float, verdict: str) -> None:
    # Corners reach 10 (1 - cos(pi / 24)) = 0.086 mm into the hole's 24 facets, over 20 mm: 48
    # films of 26 mm2 that share 24 triangles of 2.61 * 0.086 / 4 mm2 and 20 mm, some 25 mm3. A pin
    # thicker by half a millimetre lies in its hole by a film of that thickness.
    hole = trimesh.creation.cylinder(10.0, 20.0, sections=24)
    ring = trimesh.boolean.difference([trimesh.creation.box((40, 40, 20)), hole], engine="manifold")
    pin = trimesh.creation.cylinder(radius, 20.0, sections=24)
    pin.apply_transform(trimesh.transformations.rotation_matrix(math.pi / 24, [0, 0, 1]))
    here = Placement(link="arm", pose=np.eye(4), world=np.eye(4))
    arm = Part(name="ring", kind="printed", mesh=mesh_of(ring), placements=(here,))
    there = Placement(link="hand", pose=np.eye(4), world=np.eye(4))
    hand = Part(name="pin", kind="printed", mesh=mesh_of(pin), placements=(there,))
    found = judged(arm, hand, joint=hinge(-0.5, 0.5))
    assert found.verdict == verdict


def test_a_horn_that_is_drawn_into_its_servo_is_told_and_not_in_the_way() -> None:
    round_horn = mesh_of(trimesh.creation.cylinder(4.0, 4.0, sections=64))
    horn = Part(name="horn", kind="bought", mesh=round_horn, placements=BASE.placements)
    arm = block("arm", "hand", (60.0, 10.0, 5.0), (20.0, 0.0, 4.0))
    world = np.eye(4)
    world[2, 3] = 3.0
    horn = replace(horn, placements=(Placement(link="arm", pose=np.eye(4), world=world),))
    found = judged(BASE, arm, horn, joint=hinge(-0.3, 0.3))
    # From 1.5 mm, where the arm begins, to 5: pi 4^2 * 3.5 = 176 mm3; simplified by at most
    # 0.05 mm all around, 2 pi 4 * 3.5 * 0.05 = 4.4 mm3 less.
    assert found.verdict == "noted"
    assert "arm and horn share 17" in found.what


def test_printed_parts_in_each_other_are_refused_before_anything_moves() -> None:
    found = judged(block("base", "arm", (20.0, 20.0, 8.0), (0, 0, 0)), LEVER, joint=hinge(-1, 1))
    # The lever lies 4 - (-0.5) = 4.5 mm high in the base, of which 10 x 10 mm are above it.
    assert found.verdict == "refused"
    assert found.what == "lever and base lie in each other by 450 mm3 before anything moves"


def test_a_slide_is_followed_along_its_axis() -> None:
    wall = block("wall", "arm", (20.0, 20.0, 2.0), (30.0, 0.0, 41.0))
    found = judged(BASE, LEVER, wall, joint=hinge(0.0, 60.0, kind="slide"))
    # From the lever's top at 4.5 mm to the wall's underside at 40: 35.5 of 60 mm.
    assert found.verdict == "refused"
    assert found.value == pytest.approx(1.0 - 35.5 / 60.0, abs=0.01)
    assert judged(BASE, LEVER, wall, joint=hinge(0.0, 35.0, kind="slide")).verdict == "passed"


def test_other_links_are_left_out_and_parts_that_are_no_solid_are_named() -> None:
    other = block("other", "foot", (4.0, 4.0, 5.0), (50.0, 0.0, 2.0))
    assert judged(BASE, LEVER, other, joint=hinge(-1.0, 1.0)).verdict == "passed"
    cube = trimesh.creation.box((4.0, 4.0, 4.0))
    opened = Mesh(vertices=np.array(cube.vertices), faces=np.array(cube.faces)[1:])
    broken = Part(name="board", kind="bought", mesh=opened, placements=BASE.placements)
    found = judged(BASE, LEVER, broken, joint=hinge(-1.0, 1.0))
    assert found.verdict == "noted"
    assert "without board, no solid" in found.what


def test_a_joint_without_parts_passes() -> None:
    assert judged(BASE, joint=hinge(-1.0, 1.0)).verdict == "passed"


def test_a_long_lever_costs_no_more_positions_than_allowed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list[float] = []
    shared = Sweep.shared

    def counted(self: Any, position: float) -> Any:
        asked.append(position)
        return shared(self, position)

    monkeypatch.setattr(Sweep, "shared", counted)
    long = block("long", "hand", (2000.0, 10.0, 5.0), (1000.0, 0.0, 2.0))
    assert judged(BASE, long, joint=hinge(-3.0, 3.0)).verdict == "passed"
    assert len(asked) <= MOST_STEPS + 2


def test_bought_bodies_that_are_drawn_into_each_other_are_told_as_that() -> None:
    one = block("motor", "arm", (20.0, 20.0, 10.0), (0.0, 0.0, 0.0), kind="bought")
    other = block("battery", "hand", (40.0, 4.0, 10.0), (28.0, 0.0, 0.0), kind="bought")
    found = judged(BASE, LEVER, one, other, joint=hinge(-1.0, 1.0))
    # 8 to 10 mm along x, 4 along y and 10 along z: 80 mm3; towards the corner it is more.
    assert found.verdict == "refused"
    assert "bought, and drawn into each other by 0.08 cm3" in found.what
    assert "description" in found.fix


def test_a_joint_that_bought_bodies_stop_says_so_and_how_far_it_goes() -> None:
    motor = replace(post(20.0), name="motor", kind="bought")
    arm = replace(LEVER, name="battery", kind="bought")
    found = judged(motor, arm, joint=hinge(-1.0, 1.0))
    # The lever's far corner (48..52, 5) meets the post's near side, 20 mm off: see above.
    assert found.verdict == "refused"
    assert "both are bought and drawn in each other's way" in found.what
    # A printed part that is in the way much earlier is itself to blame.
    nearer = replace(post(8.0), name="near")
    assert judged(motor, arm, nearer, joint=hinge(-1.0, 1.0)).what.startswith("battery meets near")
