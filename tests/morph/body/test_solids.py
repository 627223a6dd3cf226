"""Volume, centre and spread of shapes against closed forms and trimesh."""

from __future__ import annotations

import math

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from morph.body.draft import Pose, Shape
from morph.body.mesh import Mesh, read_mesh
from morph.body.solids import bounds, corners, diagonal, parallel, solid, together

edges = st.floats(0.01, 10)
POSE = Pose(
    position=np.array((0.3, -0.2, 0.7)),
    rotation=Rotation.from_euler("xyz", (0.4, -0.9, 2.1)).as_matrix(),
)


def shape(kind: str, *size: float, pose: Pose | None = None) -> Shape:
    return Shape(role="collision", kind=kind, size=size, pose=pose or Pose())


def of_mesh(mesh: trimesh.Trimesh, **more: object) -> Shape:
    read = read_mesh(bytes(mesh.export(file_type="stl")), "stl", "mesh")
    return Shape(role="visual", kind="mesh", mesh=read, **more)  # type: ignore[arg-type]


@given(edges, edges, edges)
def test_a_box_has_the_moments_of_the_textbook(a: float, b: float, c: float) -> None:
    found = solid(shape("box", a, b, c))
    assert found is not None
    assert found.volume == pytest.approx(a * b * c)
    expected = a * b * c / 12 * np.array((b * b + c * c, a * a + c * c, a * a + b * b))
    assert np.diag(found.inertia) == pytest.approx(expected)
    assert found.com == pytest.approx(np.zeros(3))


@given(edges, edges)
def test_a_cylinder_has_the_moments_of_the_textbook(r: float, length: float) -> None:
    found = solid(shape("cylinder", r, length))
    assert found is not None
    m = math.pi * r * r * length
    across = m * (3 * r * r + length * length) / 12
    assert found.volume == pytest.approx(m)
    assert np.diag(found.inertia) == pytest.approx((across, across, m * r * r / 2))


@given(edges)
def test_a_sphere_has_the_moments_of_the_textbook(r: float) -> None:
    found = solid(shape("sphere", r))
    assert found is not None
    assert found.volume == pytest.approx(4 / 3 * math.pi * r**3)
    assert found.inertia == pytest.approx(0.4 * 4 / 3 * math.pi * r**5 * np.eye(3))


@given(edges, edges)
def test_a_capsule_is_what_slices_of_it_add_up_to(r: float, length: float) -> None:
    # Discs along z, by Gauss's rule: exact for the cylinder and for each half ball, whose
    # integrands are polynomials of a degree below 20.
    nodes, weights = np.polynomial.legendre.leggauss(10)
    pieces = [(-length / 2, length / 2, lambda z: np.full_like(z, r * r))]
    for sign in (-1, 1):
        low, high = sorted((sign * length / 2, sign * (length / 2 + r)))
        pieces.append((low, high, lambda z, s=sign: r * r - (z - s * length / 2) ** 2))
    volume = along = across = 0.0
    for low, high, squared in pieces:
        z = (low + high) / 2 + (high - low) / 2 * nodes
        area = math.pi * squared(z)
        w = weights * (high - low) / 2
        volume += float(w @ area)
        along += float(w @ (area * squared(z) / 2))
        across += float(w @ (area * (squared(z) / 4 + z * z)))
    found = solid(shape("capsule", r, length))
    assert found is not None
    assert found.volume == pytest.approx(volume, rel=1e-9)
    assert np.diag(found.inertia) == pytest.approx((across, across, along), rel=1e-9)


@pytest.mark.parametrize("kind", ["box", "cylinder", "capsule", "sphere", "mesh"])
def test_a_pose_moves_the_centre_and_turns_the_moments(kind: str) -> None:
    sizes = {"box": (0.1, 0.2, 0.3), "sphere": (0.2,), "mesh": ()}.get(kind, (0.1, 0.4))
    if kind == "mesh":
        mesh = trimesh.creation.box((0.1, 0.2, 0.3))
        still, moved = of_mesh(mesh), of_mesh(mesh, pose=POSE)
    else:
        still, moved = shape(kind, *sizes), shape(kind, *sizes, pose=POSE)
    one, other = solid(still), solid(moved)
    assert one is not None
    assert other is not None
    assert other.volume == pytest.approx(one.volume)
    assert other.com == pytest.approx(POSE.position, abs=1e-9)
    turned = POSE.rotation @ one.inertia @ POSE.rotation.T
    assert other.inertia == pytest.approx(turned, abs=1e-9 * np.trace(one.inertia))


def test_a_mesh_has_the_moments_that_trimesh_finds() -> None:
    mesh = trimesh.creation.annulus(r_min=0.1, r_max=0.3, height=0.2)
    mesh.apply_transform(trimesh.transformations.euler_matrix(0.2, 0.5, -1.0))
    mesh.apply_translation((1.0, -2.0, 0.5))
    found = solid(of_mesh(mesh))
    assert found is not None
    # STL holds 32-bit numbers: 2.0 to 1e-7, and moments are small beside the offset squared.
    assert found.volume == pytest.approx(mesh.volume, rel=1e-4)
    assert found.com == pytest.approx(mesh.center_mass, abs=1e-5)
    size = np.trace(mesh.moment_inertia)
    assert found.inertia == pytest.approx(mesh.moment_inertia, abs=1e-4 * size)


@pytest.mark.parametrize(
    "scale", [(1.0, 1.0, 1.0), (0.5, 2.0, 3.0), (-1.0, 1.0, 1.0), (-1.0, -2.0, -0.5)]
)
def test_a_scaled_or_mirrored_mesh_is_the_scaled_body(scale: tuple[float, float, float]) -> None:
    a, b, c = (abs(s * e) for s, e in zip(scale, (0.1, 0.2, 0.4), strict=True))
    found = solid(of_mesh(trimesh.creation.box((0.1, 0.2, 0.4)), scale=scale))
    assert found is not None
    assert found.volume == pytest.approx(a * b * c, rel=1e-6)
    expected = a * b * c / 12 * np.array((b * b + c * c, a * a + c * c, a * a + b * b))
    assert np.diag(found.inertia) == pytest.approx(expected, rel=1e-6)


def test_an_open_mesh_and_one_inside_out_have_the_volume_that_they_seem_to_have() -> None:
    box = trimesh.creation.box((0.1, 0.2, 0.4))
    inverted, opened = box.copy(), box.copy()
    inverted.invert()
    opened.update_faces(np.arange(12) > 0)
    for mesh in (inverted, opened):
        found = solid(of_mesh(mesh))
        assert found is not None
        assert found.volume == pytest.approx(0.1 * 0.2 * 0.4, rel=1e-6)
        assert np.linalg.eigvalsh(found.inertia)[0] > 0


def test_the_hull_of_a_ring_is_its_disc() -> None:
    ring = trimesh.creation.annulus(r_min=0.2, r_max=0.3, height=0.1, sections=64)
    found, hull = solid(of_mesh(ring)), solid(of_mesh(ring), hull=True)
    assert found is not None
    assert hull is not None
    # Areas of regular polygons of 64 sides go with the square of the radius.
    assert found.volume / hull.volume == pytest.approx(1 - (0.2 / 0.3) ** 2, rel=1e-5)


@pytest.mark.parametrize(
    "nothing",
    [
        shape("box", 0.0, 1.0, 1.0),
        shape("sphere", 0.0),
        shape("cylinder", 0.0, 1.0),
        shape("cylinder", 1.0, 0.0),
        Shape(role="visual", kind="mesh", file="gone.stl"),
        of_mesh(trimesh.creation.box((1, 1, 1)), scale=(1.0, 0.0, 1.0)),
        Shape(
            role="visual",
            kind="mesh",
            mesh=Mesh(vertices=np.eye(3), faces=np.array([(0, 1, 2)])),
        ),
    ],
)
def test_what_has_no_volume_is_no_solid(nothing: Shape) -> None:
    assert solid(nothing) is None


def test_two_halves_together_are_the_whole() -> None:
    halves = [
        shape("box", 0.1, 0.2, 0.2, pose=Pose(position=np.array((x, 0.0, 0.0))))
        for x in (-0.05, 0.05)
    ]
    found = together(one for half in halves if (one := solid(half)) is not None)
    whole = solid(shape("box", 0.2, 0.2, 0.2))
    assert found is not None
    assert whole is not None
    assert found.volume == pytest.approx(whole.volume)
    assert found.inertia == pytest.approx(whole.inertia, rel=1e-12, abs=1e-15)
    assert together([]) is None


def test_a_point_away_from_the_axis_adds_its_distance_squared() -> None:
    assert parallel(np.array((3.0, 0.0, 4.0))) == pytest.approx(
        np.array([(16.0, 0.0, -12.0), (0.0, 25.0, 0.0), (-12.0, 0.0, 9.0)])
    )


@settings(deadline=None)
@given(st.sampled_from(["box", "cylinder", "capsule", "sphere"]), edges, edges, st.integers(0, 99))
def test_the_box_around_a_shape_holds_all_of_it(
    kind: str, width: float, length: float, seed: int
) -> None:
    size = {"box": (width, length, width), "sphere": (width,)}.get(kind, (width, length))
    turn = Rotation.random(random_state=seed)
    placed = shape(kind, *size, pose=Pose(position=np.ones(3), rotation=turn.as_matrix()))
    box = bounds([placed])
    assert box is not None
    made = {
        "box": lambda: trimesh.creation.box(size),
        "sphere": lambda: trimesh.creation.icosphere(subdivisions=1, radius=width),
        "cylinder": lambda: trimesh.creation.cylinder(radius=width, height=length, sections=12),
        "capsule": lambda: trimesh.creation.capsule(radius=width, height=length, count=(8, 8)),
    }[kind]()
    points = turn.apply(np.array(made.vertices)) + 1
    # trimesh's capsule stands on its centre or on one end; only the former is ours.
    if kind == "capsule":
        points -= points.mean(axis=0) - 1
    slack = 1e-9 * (width + length)
    assert (points >= box[0] - slack).all()
    assert (points <= box[1] + slack).all()
    # It is no looser than the corners of the shape's own box are.
    assert diagonal(box) <= math.sqrt(3) * diagonal(np.array(bounds([shape(kind, *size)]))) + slack


def test_shapes_that_are_not_there_have_no_bounds() -> None:
    gone = Shape(role="visual", kind="mesh", file="gone.stl")
    assert bounds([]) is None
    assert bounds([gone]) is None
    assert corners(gone).shape == (0, 3)
