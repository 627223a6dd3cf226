"""Our boundary elements against those of Capytaine, which shares no code with them."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator

import numpy as np
import pytest

from morph.physics.fluid.tensor import kirchhoff

Shape = tuple[np.ndarray, np.ndarray]
MOTIONS = ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")


@pytest.fixture(autouse=True)
def _quiet() -> Iterator[None]:
    level = logging.getLogger("capytaine").level
    logging.getLogger("capytaine").setLevel(logging.ERROR)
    yield
    logging.getLogger("capytaine").setLevel(level)


def theirs(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Capytaine's added mass in a fluid without a surface or a floor, at unit density."""
    import capytaine

    # A triangle is a quadrilateral with one corner twice.
    mesh = capytaine.Mesh(vertices, np.column_stack([faces, faces[:, 0]]))
    dofs = capytaine.rigid_body_dofs(rotation_center=(0.0, 0.0, 0.0))
    body = capytaine.FloatingBody(mesh=mesh, dofs=dofs)
    # Without a surface there are no waves: the table of them may be small, and is not kept.
    waves = capytaine.Delhommeau(
        tabulation_nr=10,
        tabulation_nz=10,
        tabulation_nb_integration_points=101,
        tabulation_cache_dir=None,
    )
    solver = capytaine.BEMSolver(green_function=waves, method="direct")
    rows = []
    for motion in MOTIONS:
        problem = capytaine.RadiationProblem(
            body=body, radiating_dof=motion, free_surface=np.inf, rho=1.0, wavenumber=0.0
        )
        result = solver.solve(problem, keep_details=False)
        rows.append([result.added_masses[name] for name in MOTIONS])
    return np.array(rows)


def ell() -> Shape:
    """An L of two arms, 0.3 x 0.1 x 0.1 and 0.1 x 0.2 x 0.1 m, in even triangles."""
    import manifold3d

    made = manifold3d.Manifold.cube((0.3, 0.1, 0.1)) + manifold3d.Manifold.cube((0.1, 0.3, 0.1))
    mesh = made.translate((0.2, -0.4, 0.1)).refine_to_length(0.04).to_mesh64()
    return np.array(mesh.vert_properties[:, :3]), np.array(mesh.tri_verts, dtype=np.int64)


def test_an_ellipsoid_off_the_origin_has_the_tensor_that_capytaine_finds(
    ball: Callable[[int], Shape],
) -> None:
    vertices, faces = ball(2)
    _agree(vertices * (0.3, 0.2, 0.1) + (0.4, -0.1, 0.2), faces)


def test_an_l_has_the_tensor_that_capytaine_finds() -> None:
    _agree(*ell())


def _agree(vertices: np.ndarray, faces: np.ndarray) -> None:
    ours, other = kirchhoff(vertices, faces), theirs(vertices, faces)
    # Both solve one system; theirs takes distant panels as points and single precision.
    root = np.sqrt(np.diag(ours))
    assert np.abs((0.5 * (other + other.T) - ours) / np.outer(root, root)).max() < 0.002
