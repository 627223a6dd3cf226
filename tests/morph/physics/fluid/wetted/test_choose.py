"""Which surface stands for a link, and what is said of it."""

import math

import numpy as np
import pytest

import morph
from morph.body.mesh import Mesh
from morph.errors import RobotError
from morph.physics.fluid.tensor import tensor_of_solid
from morph.physics.fluid.wetted import surface, wetted
from morph.physics.fluid.wetted.sound import sound


def torn(mesh: Mesh, count: int) -> Mesh:
    return Mesh(vertices=mesh.vertices, faces=mesh.faces[count:])


def mesh_of(found: object) -> Mesh:
    return Mesh(vertices=found.vertices, faces=found.faces)  # type: ignore[attr-defined]


def test_the_swimmers_hull_and_paddle_displace_what_the_card_says() -> None:
    robot = morph.load("hexapod_swimmer")
    hull, paddle = (wetted(robot, link) for link in ("hull", "left_front_paddle"))
    assert hull.volume + 6 * paddle.volume == pytest.approx(0.017043487, abs=1e-9)
    assert (hull.how, hull.reason, hull.spread) == ("mesh", "", None)
    assert sound(mesh_of(hull))
    assert paddle.box is not None
    assert np.allclose(paddle.box.sides, (0.16, 0.05, 0.003))
    assert np.allclose(paddle.centre, (-0.088, 0.0, 0.0))


def test_the_box_of_the_swimmers_hull_has_its_volume() -> None:
    robot = morph.load("hexapod_swimmer")
    box = wetted(robot, "hull", how="box")
    assert box.box is not None
    assert box.volume == pytest.approx(0.017043487 - 6 * 2.4e-5, abs=1e-9)
    # The hips widen the hull's 0.21 m and leave its length and height within 3 %.
    assert np.allclose(box.box.sides, (0.64, 0.228, 0.12), rtol=0.03)


def test_twice_the_scale_is_eight_times_the_volume() -> None:
    robot = morph.load("hexapod_swimmer")
    one, two = (wetted(robot, "hull", how="box", scale=scale) for scale in (1.0, 2.0))
    assert two.volume == pytest.approx(8 * one.volume)


@pytest.mark.parametrize("scale", [0.0, -1.0, math.nan, math.inf])
def test_a_scale_that_is_none_is_refused(scale: float) -> None:
    robot = morph.load("hexapod_swimmer")
    with pytest.raises(RobotError, match=r"link hull of robot .*has the scale"):
        wetted(robot, "hull", scale=scale)


def test_a_ball_with_a_hole_is_wrapped_to_the_ball(ball: Mesh) -> None:
    found = surface((torn(ball, 20),))
    assert found.how == "wrap"
    assert found.reason.startswith("1 open of its 1 piece: wrapped watertight")
    # Of 2 mm cells on a ball of 200 mm; the skin is off by less than half of one: 3 * 1 %.
    assert found.volume == pytest.approx(ball.volume, rel=0.03)
    assert found.spread is not None
    assert {choice.how for choice in found.choices} == {"wrap", "wrap, coarser", "hull", "box"}
    tensor = tensor_of_solid(found.vertices, found.faces, panels=640).matrix
    assert np.linalg.eigvalsh(tensor).min() > 0
    # rho V / 2 of the true ball; 3 % of volume and 1 % of panels.
    assert np.allclose(np.diag(tensor)[:3], ball.volume / 2, rtol=0.04)


def test_a_box_without_a_lid_is_replaced_by_its_hull_and_the_spread_is_given(cube: Mesh) -> None:
    lid = (cube.vertices[cube.faces][:, :, 2] > 0.049).all(axis=1)
    found = surface((Mesh(vertices=cube.vertices, faces=cube.faces[~lid]),))
    assert found.how == "hull"
    assert "a wrap of it encloses nothing" in found.reason
    assert found.volume == pytest.approx(1e-3)
    assert found.spread is not None


def test_a_tube_that_runs_through_itself_is_wrapped() -> None:
    # Around a lemniscate, whose two halves cross at the origin.
    turn, around = np.linspace(0, 2 * np.pi, 97)[:-1], np.linspace(0, 2 * np.pi, 13)[:-1]
    centre = np.stack([np.sin(turn), np.sin(turn) * np.cos(turn), 0 * turn], axis=1)
    along = np.stack([np.cos(turn), np.cos(2 * turn), 0 * turn], axis=1)
    side = np.stack([-along[:, 1], along[:, 0], 0 * turn], axis=1)
    side /= np.linalg.norm(along, axis=1)[:, None]
    up = np.array([0.0, 0.0, 1.0])
    ring = np.cos(around)[:, None] * side[:, None] + np.sin(around)[:, None] * up
    i, j = (grid.ravel() for grid in np.meshgrid(np.arange(96), np.arange(12), indexing="ij"))
    a, b = 12 * i + j, 12 * i + (j + 1) % 12
    c, d = (a + 12) % (96 * 12), (b + 12) % (96 * 12)
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([b, d, c], axis=1)])
    tube = Mesh(vertices=(centre[:, None] + 0.15 * ring).reshape(-1, 3), faces=faces)
    found = surface((tube,))
    assert found.how != "mesh"
    assert "tangled" in found.reason or "crosses" in found.reason
    assert sound(mesh_of(found))


def test_a_sheet_encloses_nothing_and_is_refused(cube: Mesh) -> None:
    flat = Mesh(vertices=cube.vertices * np.array([1.0, 1.0, 0.0]), faces=cube.faces)
    with pytest.raises(RobotError, match=r"the fin: its shapes enclose nothing: .* in one plane"):
        surface((flat,), where="the fin")


def test_no_shape_and_corners_that_are_nowhere_are_refused(cube: Mesh) -> None:
    with pytest.raises(RobotError, match="it has no shape for water to touch"):
        surface(())
    nowhere = Mesh(vertices=cube.vertices * np.array([1.0, math.nan, 1.0]), faces=cube.faces)
    with pytest.raises(RobotError, match="a corner of its shapes is not a number"):
        surface((nowhere,))
    with pytest.raises(RobotError, match="its wetted surface is to be 'skin'"):
        surface((cube,), how="skin")
