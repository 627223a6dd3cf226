"""The facts of solids whose volume, centre and inertia have closed forms."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from morph.body.mesh import Mesh
from morph.errors import MeshError

FAR = np.array((3.0, -40.0, 500.0))


def box(x: float, y: float, z: float, at: np.ndarray = FAR) -> Mesh:
    corners = np.array(list(itertools.product((-0.5, 0.5), repeat=3))) * (x, y, z) + at
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [face for a, b, c, d in sides for face in ((a, b, c), (a, c, d))]
    return Mesh(vertices=corners, faces=np.array(faces))


def prism(sides: int, radius: float, height: float) -> Mesh:
    """A regular prism along z about the origin, closed by two fans."""
    angle = 2 * np.pi * np.arange(sides) / sides
    ring = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    low = np.column_stack([ring, np.full(sides, -height / 2)])
    high = np.column_stack([ring, np.full(sides, height / 2)])
    vertices = np.concatenate([low, high, [(0, 0, -height / 2), (0, 0, height / 2)]])
    faces = []
    for here in range(sides):
        after = (here + 1) % sides
        faces += [(here, after, sides + here), (after, sides + after, sides + here)]
        faces += [(2 * sides, after, here), (2 * sides + 1, sides + here, sides + after)]
    return Mesh(vertices=vertices, faces=np.array(faces))


def soup(mesh: Mesh) -> Mesh:
    """The same faces, each with corners of its own, as STL holds them."""
    return Mesh(
        vertices=mesh.vertices[mesh.faces].reshape(-1, 3),
        faces=np.arange(3 * len(mesh.faces)).reshape(-1, 3),
    )


def test_a_box_far_from_the_origin_has_the_moments_of_the_textbook() -> None:
    mesh = box(0.2, 0.3, 0.5)
    # V = 0.2 * 0.3 * 0.5 = 0.03; I_xx = V (y^2 + z^2) / 12. Corners 500 m off are rounded to
    # 2^-53 * 500 = 6e-14 m, 3e-13 of the smallest edge: five times that is allowed.
    assert mesh.volume == pytest.approx(0.03, rel=2e-12)
    assert mesh.com == pytest.approx(FAR, abs=1e-12)
    x, y, z = 0.2**2, 0.3**2, 0.5**2
    expected = 0.03 / 12 * np.diag((y + z, x + z, x + y))
    assert mesh.inertia == pytest.approx(expected, abs=2e-12 * 0.03)
    assert mesh.bounds[1] - mesh.bounds[0] == pytest.approx((0.2, 0.3, 0.5), abs=1e-12)


def test_a_corner_tetrahedron_has_products_of_inertia() -> None:
    vertices = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], dtype=float)
    mesh = Mesh(vertices=vertices, faces=np.array([(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]))
    # Over it, the mean of x^2 is 1/10 and of xy 1/20; about the centre, at 1/4 each, 1/10 - 1/16
    # and 1/20 - 1/16. So I_xx = V 2 (1/10 - 1/16) and I_xy = -V (1/20 - 1/16), with V = 1/6.
    assert mesh.volume == pytest.approx(1 / 6, rel=1e-14)
    assert mesh.com == pytest.approx((0.25, 0.25, 0.25), abs=1e-15)
    assert mesh.inertia[0, 0] == pytest.approx(2 / 6 * (1 / 10 - 1 / 16), rel=1e-13)
    assert mesh.inertia[0, 1] == pytest.approx(-1 / 6 * (1 / 20 - 1 / 16), rel=1e-13)


def test_a_prism_of_many_sides_nears_a_cylinder() -> None:
    sides, radius, height = 360, 0.1, 0.4
    mesh = prism(sides, radius, height)
    # A regular polygon has area n r^2 sin(2 pi / n) / 2 and a polar moment of
    # area n r^4 sin(2 pi / n) (2 + cos(2 pi / n)) / 12.
    turn = 2 * np.pi / sides
    area = sides * radius**2 * np.sin(turn) / 2
    polar = sides * radius**4 * np.sin(turn) * (2 + np.cos(turn)) / 12
    assert mesh.volume == pytest.approx(area * height, rel=1e-13)
    assert mesh.inertia[2, 2] == pytest.approx(polar * height, rel=1e-12)
    # A chord of 1 degree leaves turn^2 / 6 = 5e-5 of the circle's area out.
    assert mesh.volume == pytest.approx(np.pi * radius**2 * height, rel=6e-5)
    side = mesh.inertia[2, 2] / 2 + area * height * height**2 / 12
    assert mesh.inertia[0, 0] == pytest.approx(side, rel=1e-12)


def test_moments_are_those_that_sampling_finds() -> None:
    mesh = prism(7, 0.3, 0.2).scaled((1.0, 2.0, -0.5))
    rng = np.random.default_rng(3)
    low, high = mesh.bounds
    points = rng.uniform(low, high, size=(400_000, 3))
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    inside = (points @ normal.T - np.einsum("ij,ij->i", normal, a) <= 0).all(axis=1)
    # A share p of 400 000 is known to sqrt(p (1 - p) / 400 000) = 0.0007, 0.1 % of a share of
    # two thirds; five times that is allowed.
    volume = np.prod(high - low) * inside.mean()
    assert mesh.volume == pytest.approx(volume, rel=5e-3)
    found = points[inside]
    spread = np.cov(found.T) * volume
    expected = np.trace(spread) * np.eye(3) - spread
    assert mesh.inertia == pytest.approx(expected, abs=5e-3 * expected.max())


def test_a_box_turned_inside_out_has_negative_volume_and_the_same_inertia() -> None:
    mesh = box(0.2, 0.3, 0.5)
    turned = Mesh(vertices=mesh.vertices, faces=mesh.faces[:, ::-1])
    assert turned.volume == pytest.approx(-mesh.volume, rel=1e-12)
    assert turned.com == pytest.approx(mesh.com, abs=1e-12)
    assert turned.inertia == pytest.approx(mesh.inertia, abs=1e-14)
    assert turned.watertight
    assert turned.consistent


@pytest.mark.parametrize("scale", [(-1.0, 1.0, 1.0), (0.001, 0.001, 0.001), (-2.0, -3.0, -4.0)])
def test_scaling_keeps_outside_outside(scale: tuple[float, float, float]) -> None:
    mesh = box(0.2, 0.3, 0.5).scaled(scale)
    assert mesh.volume == pytest.approx(0.03 * abs(np.prod(scale)), rel=1e-11)
    assert mesh.com == pytest.approx(FAR * scale, rel=1e-12)


def test_a_closed_surface_stays_closed_as_a_soup_and_loses_it_with_one_face() -> None:
    mesh = soup(box(0.2, 0.3, 0.5))
    assert mesh.watertight
    assert mesh.consistent
    assert len(mesh.merged.vertices) == 8
    assert not Mesh(vertices=mesh.vertices, faces=mesh.faces[1:]).watertight


def test_corners_rounded_to_float32_still_meet() -> None:
    # The same corner, computed twice, may land on neighbouring float32 numbers.
    mesh = soup(prism(100, 0.1, 0.3))
    rounded = mesh.vertices.astype(np.float32)
    moved = np.nextafter(rounded, np.float32(1.0))
    odd = (np.arange(len(rounded)) % 2 == 1)[:, None]
    found = Mesh(vertices=np.where(odd, moved, rounded).astype(float), faces=mesh.faces)
    assert found.watertight
    # A crack of 1e-5 m, thirty times what is taken for rounding, remains one.
    cracked = found.vertices.copy()
    cracked[0] += 1e-5
    assert not Mesh(vertices=cracked, faces=mesh.faces).watertight


def test_a_face_that_winds_the_other_way_is_told_from_a_hole() -> None:
    mesh = box(0.2, 0.3, 0.5)
    faces = mesh.faces.copy()
    faces[0] = faces[0][::-1]
    found = Mesh(vertices=mesh.vertices, faces=faces)
    assert found.watertight
    assert not found.consistent


def test_the_hull_of_a_prism_without_its_lids_is_the_prism() -> None:
    mesh = prism(12, 0.1, 0.3)
    open_ends = Mesh(
        vertices=mesh.vertices, faces=mesh.faces.reshape(12, 4, 3)[:, :2].reshape(-1, 3)
    )
    assert not open_ends.watertight
    assert open_ends.hull.volume == pytest.approx(mesh.volume, rel=1e-12)
    assert open_ends.hull.consistent


def test_a_sheet_encloses_nothing_and_says_so() -> None:
    vertices = np.array([(0, 0, 1), (2, 0, 1), (2, 1, 1), (0, 1, 1)], dtype=float)
    sheet = Mesh(vertices=vertices, faces=np.array([(0, 1, 2), (0, 2, 3)]))
    assert sheet.hollow
    assert not sheet.watertight
    assert sheet.com == pytest.approx((1.0, 0.5, 1.0), abs=1e-15)
    assert (sheet.inertia == 0).all()
    with pytest.raises(MeshError, match="lie in one plane") as caught:
        _ = sheet.hull
    assert caught.value.code == "mesh-empty"
