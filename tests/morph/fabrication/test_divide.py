"""Bodies as parts: how many, how heavy, where, and which are twins."""

from __future__ import annotations

import math
from functools import lru_cache
from pathlib import Path

import mujoco
import numpy as np
import pytest

from morph.body.description import read_description
from morph.body.load import load
from morph.body.spec import bare_spec
from morph.fabrication.divide import divide
from morph.fabrication.division import Division
from morph.fabrication.drawing import drawing
from morph.fabrication.off_the_shelf_parts import axes, items
from morph.print.clearance import clearances
from morph.print.gate import check_part
from morph.print.part import Part
from morph.print.printer import Profile, material, printer

PROFILE = Profile(printer=printer("mk4"), material=material("pla"))


BOX = '<geom type="box" size="0.02 0.02 0.02" mass="1"/>'


@lru_cache(maxsize=8)
def division(name: str) -> Division:
    return divide(load(name), PROFILE)


def described(tmp_path: Path, body: str) -> Division:
    path = tmp_path / "robot.xml"
    path.write_text(f"<mujoco><worldbody>{body}</worldbody></mujoco>")
    return divide(read_description(path, None), PROFILE)


def printed(found: Division) -> list[Part]:
    return [part for part in found.parts if part.kind == "printed"]


def solid_volume(part: Part) -> float:
    assert part.mesh is not None
    return part.mesh.volume


@pytest.mark.parametrize(
    ("geom", "volume"),
    [
        ('type="box" size="0.02 0.01 0.03"', 8 * 20 * 10 * 30),
        ('type="sphere" size="0.02"', 4 / 3 * math.pi * 20**3),
        ('type="ellipsoid" size="0.02 0.01 0.03"', 4 / 3 * math.pi * 20 * 10 * 30),
        ('type="cylinder" size="0.02 0.03"', math.pi * 20**2 * 60),
        ('type="capsule" size="0.02 0.03"', math.pi * 20**2 * 60 + 4 / 3 * math.pi * 20**3),
    ],
)
def test_a_link_of_one_simple_solid_has_its_volume(
    tmp_path: Path, geom: str, volume: float
) -> None:
    found = described(tmp_path, f'<body name="b"><geom {geom} mass="1"/></body>')
    # A ring of n chords has sin(2 pi / n) / (2 pi / n) of its circle: for n of at least 56,
    # as balls and rods of 10 to 30 mm have, 0.2 % less, and of a ball twice that.
    assert solid_volume(printed(found)[0]) == pytest.approx(volume, rel=5e-3)


def test_the_printed_quadruped_is_three_parts_of_one_and_four_and_four_copies() -> None:
    found = division("quadruped_printed")
    counts = {part.name: part.count for part in printed(found)}
    assert counts == {"body": 1, "upper_leg": 4, "lower_leg": 4}
    # Its card: 29.5 g, 8.4 g and 6.0 g of solid PLA, at 1240 kg/m3, to 0.05 g.
    grams = [solid_volume(part) * 1240e-6 for part in printed(found)]
    assert grams == pytest.approx([29.5, 8.4, 6.0], abs=0.05)


def test_parts_and_what_is_bought_together_weigh_what_the_printed_quadruped_does() -> None:
    robot = load("quadruped_printed")
    found = division("quadruped_printed")
    plastic = sum(solid_volume(part) * 1240e-9 * part.count for part in printed(found))
    bought = sum(part.weight.mass * part.count for part in found.parts if part.weight)
    # The description writes masses to a microgram.
    assert plastic + bought == pytest.approx(robot.mass, abs=1e-5)
    assert found.complete == {link.name for link in robot.links}


def test_every_copy_of_a_part_stands_where_the_description_draws_it() -> None:
    found = division("quadruped_printed")
    model = bare_spec(load("quadruped_printed")).compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    for part in printed(found):
        assert part.mesh is not None
        for place in part.placements:
            geoms = [
                geom
                for geom in range(model.ngeom)
                if model.body(int(model.geom_bodyid[geom])).name == place.link
                and model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH
            ]
            at = int(model.geom_dataid[geoms[0]])
            first, count = model.mesh_vertadr[at], model.mesh_vertnum[at]
            corners = model.mesh_vert[first : first + count].astype(float)
            turn = data.geom_xmat[geoms[0]].reshape(3, 3)
            drawn = 1e3 * (corners @ turn.T + data.geom_xpos[geoms[0]])
            ours = part.mesh.moved(place.world).vertices
            # MuJoCo keeps corners in single precision: 6e-8 of 150 mm is 1e-5 mm.
            assert ours.min(axis=0) == pytest.approx(drawn.min(axis=0), abs=1e-4)
            assert ours.max(axis=0) == pytest.approx(drawn.max(axis=0), abs=1e-4)


def test_the_arm_buys_six_servos_of_55_grams_one_in_each_link_but_the_jaw() -> None:
    found = division("so101")
    servos = [part for part in found.parts if part.kind == "bought"]
    assert [(part.name, part.count) for part in servos] == [("sts3215", 6)]
    assert servos[0].weight is not None
    assert servos[0].weight.mass == 0.055
    links = [link.name for link in found.robot.links]
    assert [place.link for place in servos[0].placements] == links[:-1]


def test_every_part_of_the_arm_is_one_solid_that_carries_what_the_card_says() -> None:
    found = division("so101")
    held = {part.name: [seat.holds for seat in part.seats] for part in printed(found)}
    assert all(part.mesh.manifold.genus() >= 0 for part in printed(found) if part.mesh)
    for link in [link.name for link in found.robot.links][1:-1]:
        assert {"STS3215", "STS3215 horn"} <= set(held[link]), link
    assert "STS3215 horn" not in held["base"]
    assert "STS3215" not in held["jaw"]


def test_the_masses_of_bought_servos_sit_where_the_arm_draws_their_boxes() -> None:
    found = division("so101")
    part = next(part for part in found.parts if part.kind == "bought")
    assert part.weight is not None
    model = bare_spec(load("so101")).compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    names = [entry.shape for entry in found.robot.card.print.bought]  # type: ignore[union-attr]
    for place, name in zip(part.placements, names, strict=True):
        com = place.world[:3, :3] @ (1e3 * part.weight.com) + place.world[:3, 3]
        # Put on the joint's axis, up to 2 mm from where it is drawn; its top may be 1 mm off.
        assert np.abs(com - 1e3 * data.geom(name).xpos).max() < 1.5, name


def test_left_and_right_are_mirrored_twins(tmp_path: Path) -> None:
    arms = "".join(
        f'<body name="{side}_arm" pos="0 {y} 0"><joint name="{side}" axis="1 0 0"/>'
        f'<geom type="box" pos="0.02 {y} 0" size="0.02 0.01 0.005" mass="1"/>'
        f'<geom type="box" pos="0.03 {2 * y} 0.005" size="0.005 0.01 0.01" mass="1"/></body>'
        for side, y in (("left", 0.03), ("right", -0.03))
    )
    found = described(tmp_path, f'<body name="trunk"><freejoint/>{BOX}{arms}</body>')
    parts = {part.name: part for part in printed(found)}
    assert set(parts) == {"trunk", "arm_left", "arm_right"}
    left, right = parts["arm_left"], parts["arm_right"]
    assert (left.hand, right.hand) == ("left", "right")
    assert (left.placements[0].link, right.placements[0].link) == ("left_arm", "right_arm")
    assert left.mesh is not None
    assert right.mesh is not None
    mirror = np.diag([1.0, -1.0, 1.0, 1.0])
    here = left.mesh.moved(mirror @ left.placements[0].world)
    there = right.mesh.moved(right.placements[0].world)
    assert there.volume == pytest.approx(left.mesh.volume, rel=1e-9)
    # Grown once and mirrored: alike to rounding of 100 mm in the world.
    assert here.bounds == pytest.approx(there.bounds, abs=1e-9)


def test_a_servo_that_is_drawn_beside_its_joint_is_told_with_the_distance() -> None:
    found, _ = items(drawing(load("humanoid")))
    check = next(check for check in axes(found) if check.part == "l_knee_y")
    # The box's middle is 27 mm above the knee; an MX-28's axis is 50.6 / 2 - 12.8 mm from it.
    assert check.value == pytest.approx(27.0 - 12.5, abs=1e-6)
    assert check.verdict == "noted"


def test_a_link_without_a_joint_is_one_piece_with_the_one_it_hangs_from(tmp_path: Path) -> None:
    found = described(
        tmp_path,
        '<body name="base"><geom type="box" size="0.02 0.02 0.01" mass="1"/>'
        '<body name="post" pos="0 0 0.0195">'
        '<geom type="box" size="0.005 0.005 0.01" mass="1"/></body></body>',
    )
    parts = {part.name: part for part in found.parts}
    assert parts["post"].kind == "fused"
    assert parts["post"].into == "base"
    # 40 * 40 * 20 mm3, and 10 * 10 * 19.5 of the post, whose foot is in the base; a shell
    # closes cracks of some micrometres by growing, on 6000 mm2 of surface less than 60 mm3.
    assert solid_volume(parts["base"]) == pytest.approx(32000 + 1950, abs=60.0)


def test_what_cannot_be_made_is_a_check_and_not_an_exception(tmp_path: Path) -> None:
    (tmp_path / "open.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\n")
    path = tmp_path / "robot.xml"
    path.write_text(
        '<mujoco><asset><mesh name="open" file="open.obj" inertia="shell"/></asset><worldbody>'
        '<body name="b"><geom type="mesh" mesh="open" mass="1"/></body></worldbody></mujoco>'
    )
    found = divide(read_description(path, None), PROFILE)
    # A mesh is a part as it is: whether it can be printed is for the gate to say.
    assert [part.name for part in found.parts] == ["open"]


@pytest.mark.parametrize(
    ("path", "parts", "joints"),
    [
        ("poppy_humanoid/robots/Poppy_Humanoid.URDF", 26, 25),
        ("open_duck_mini_v2/urdf/robot.urdf", 44, 16),
    ],
)
def test_real_descriptions_divide_into_their_meshes(
    real_robots: Path, path: str, parts: int, joints: int
) -> None:
    found = division(str(real_robots / path))
    assert len(found.parts) == parts
    assert len(found.hinges) == joints
    drawn = sum(part.count for part in found.parts)
    model = bare_spec(found.robot).compile()
    assert drawn == int(np.sum(model.geom_group[: model.ngeom] < 3))


def test_real_twins_are_found_though_their_triangles_differ(real_robots: Path) -> None:
    found = division(str(real_robots / "open_duck_mini_v2/urdf/robot.urdf"))
    hands = {part.name: part.hand for part in found.parts}
    assert hands["roll_to_pitch_left"] == "left"
    assert hands["roll_to_pitch_right"] == "right"


@pytest.mark.parametrize("name", ["so101", "quadruped_printed", "cartpole"])
def test_parts_stay_clear_of_their_neighbours_over_the_whole_range_of_each_joint(name: str) -> None:
    found = division(name)
    checks = clearances(found.parts, found.hinges, PROFILE)
    assert [check.what for check in checks if check.verdict != "passed"] == []


def test_servos_go_into_the_meshes_of_the_printed_quadruped() -> None:
    for part in printed(division("quadruped_printed")):
        _, checks = check_part(part, PROFILE)
        assert [check.what for check in checks if check.verdict == "refused"] == []
    seats = {part.name: len(part.seats) for part in printed(division("quadruped_printed"))}
    assert seats == {"body": 4, "upper_leg": 1, "lower_leg": 0}
