"""The printed quadruped: its parts are as drawn, fit their servos, and do not meet."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from experiments import draw_parts as draw
from experiments.describe_quadruped import LIFT, PLA, SWING, description
from morph.body.load import load
from morph.body.mesh import Mesh, read_mesh

NAMES = tuple(draw.PARTS)


def committed(name: str) -> Mesh:
    return read_mesh((draw.FOLDER / f"{name}.stl").read_bytes(), "stl", name)


def servo() -> Any:
    """A servo of the greatest size, its axis along z, its flange resting on z = 0."""
    s = draw.SERVO
    case = draw.box((-s.length / 2, -s.width / 2, -s.base), (s.length / 2, s.width / 2, 6.6))
    ears = (s.flange_length / 2, s.width / 2)
    flange = draw.box((-ears[0], -ears[1], 0.0), (ears[0], ears[1], s.flange))
    shaft = draw.rod(2.4, 0.0, s.top - s.base, (s.offset, 0.0))
    return (case + flange + shaft).translate((-s.offset, 0, 0))


def knee_servo() -> Any:
    return servo().rotate((-90, 0, 0)).translate((draw.KNEE[0], draw.SEAT, draw.KNEE[2]))


@pytest.mark.parametrize("name", NAMES)
def test_drawing_a_part_again_gives_the_part_that_is_kept(name: str) -> None:
    drawn, kept = draw.mesh_of(draw.PARTS[name]()), committed(name)
    # Float32 rounds coordinates up to 70 mm by 4e-6, on parts of 5 mm and more: 1e-6 of each.
    assert kept.volume == pytest.approx(drawn.volume, rel=1e-6)
    assert kept.com == pytest.approx(drawn.com, abs=1e-5)
    assert kept.bounds == pytest.approx(drawn.bounds, abs=1e-5)


@pytest.mark.parametrize("name", NAMES)
def test_a_part_can_be_sliced(name: str) -> None:
    part = draw.PARTS[name]()
    assert committed(name).consistent
    assert len(part.decompose()) == 1


def test_the_plate_has_the_volume_of_its_outline_less_its_holes() -> None:
    # A square of 2 * 35 mm with rounded borders of 14: (2 a)^2 + 4 (2 a) r + pi r^2.
    outline = 70.0**2 + 4 * 70.0 * 14.0 + math.pi * 14.0**2
    pocket = (22.8 + 0.4) * (12.6 + 0.4) + 2 * math.pi * 0.85**2
    holes = 4 * pocket + 4 * math.pi * 1.35**2 + math.pi * 9.0**2
    # Polygons of 24 and 48 sides lack 1.1 and 0.3 % of a circle: at most 2 mm2 here of 7934.
    assert committed("body").volume == pytest.approx(3.0 * (outline - holes), rel=3e-4)


def test_a_servo_fits_each_pocket_and_its_flange_rests_on_the_rim() -> None:
    plate = draw.body()
    wall = draw.upper_leg()
    reach = math.hypot(draw.HIP, draw.HIP)
    for angle in (45, 135, 225, 315):
        seated = servo().translate((reach, 0, draw.PLATE / 2)).rotate((0, 0, angle))
        assert (plate ^ seated).volume() == pytest.approx(0.0, abs=1e-6)
        # A hair lower, all of the flange that lies beyond the pocket is in the plate.
        lower = (plate ^ seated.translate((0, 0, -0.1))).volume()
        assert lower == pytest.approx(0.1 * (32.5 - 23.2) * 12.6, rel=0.15)
    assert (wall ^ knee_servo()).volume() == pytest.approx(0.0, abs=1e-6)
    assert (wall ^ knee_servo().translate((0, -0.1, 0))).volume() > 5.0


def test_the_shafts_end_where_the_horns_seats_are() -> None:
    top = knee_servo().bounding_box()[4]
    assert top == pytest.approx(-draw.SHIN_THICK / 2)
    assert servo().translate((0, 0, draw.PLATE / 2)).bounding_box()[5] == pytest.approx(draw.HORN)


@pytest.mark.parametrize("angle", np.linspace(*LIFT, 7))
def test_a_lower_leg_clears_its_upper_leg_through_its_range(angle: float) -> None:
    turned = draw.lower_leg().rotate((0, -math.degrees(angle), 0)).translate(draw.KNEE)
    assert (draw.upper_leg() ^ turned).volume() == pytest.approx(0.0, abs=1e-6)
    assert (knee_servo() ^ turned).volume() == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("angle", np.linspace(*SWING, 7))
def test_an_upper_leg_clears_the_body_through_its_range(angle: float) -> None:
    leg = (draw.upper_leg() + knee_servo()).rotate((0, 0, 45 + math.degrees(angle)))
    leg = leg.translate((draw.HIP, draw.HIP, draw.HORN))
    reach = math.hypot(draw.HIP, draw.HIP)
    hips = [
        servo().translate((reach, 0, draw.PLATE / 2)).rotate((0, 0, at))
        for at in (45, 135, 225, 315)
    ]
    assert (leg ^ draw.body()).volume() == pytest.approx(0.0, abs=1e-6)
    for hip in hips:
        assert (leg ^ hip).volume() == pytest.approx(0.0, abs=1e-6)


def test_the_description_is_that_of_the_meshes() -> None:
    kept = (draw.FOLDER.parent / "robot.xml").read_text(encoding="utf-8")
    assert description() == kept


def test_each_link_weighs_its_plastic_and_what_is_bought() -> None:
    robot = load("quadruped_printed")
    assert robot.card is not None
    assert robot.card.print is not None
    for link in robot.links:
        bought = sum(b.count * b.mass_kg for b in robot.card.print.bought if b.link == link.name)
        part = next(name for name in NAMES if link.name.endswith(name))
        plastic = committed(part).volume * 1e-9 * PLA
        # Masses in the description have nine digits after the point.
        assert link.mass == pytest.approx(bought + plastic, abs=2e-9)
    assert set(robot.card.print.printed) == {link.name for link in robot.links}


def test_it_stands_on_its_feet() -> None:
    import mujoco

    from morph.body.spec import spec_of

    spec = spec_of(load("quadruped_printed"))
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_PLANE, size=(1, 1, 0.1), contype=1, conaffinity=0
    )
    model = spec.compile()
    data = mujoco.MjData(model)
    for _ in range(1000):
        mujoco.mj_step(model, data)
    # At home the soles touch the ground; servos of 1.77 N m/rad sag a little, and no foot slips
    # far: 2 mm of 66 are the sag of 0.56 N on a lever of 65 mm, 0.02 rad, at hip and knee.
    assert data.body("body").xpos[2] == pytest.approx(0.0661, abs=0.002)
    assert data.body("body").xmat[8] > 0.999
