"""A mesh that is round all over is known for what it is."""

import numpy as np
import pytest

from morph.body.mesh import Mesh
from morph.physics.fluid.tensor import ellipsoid_tensor, rod_tensor
from morph.physics.fluid.wetted.round import round_tensor
from morph.physics.fluid.wetted.tessellate import (
    box_mesh,
    capsule_mesh,
    cylinder_mesh,
    ellipsoid_mesh,
)

TURN = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
TURN *= np.sign(np.linalg.det(TURN))
PLACE = np.array([0.3, -0.2, 0.5])


def there(mesh: Mesh) -> Mesh:
    return Mesh(vertices=mesh.vertices @ TURN.T + PLACE, faces=mesh.faces)


@pytest.mark.parametrize(
    ("mesh", "exact"),
    [
        (ellipsoid_mesh(np.array([0.3, 0.2, 0.1])), ellipsoid_tensor(0.3, 0.2, 0.1)),
        (ellipsoid_mesh(np.full(3, 0.1)), ellipsoid_tensor(0.1, 0.1, 0.1)),
        (cylinder_mesh(0.1, 0.5), rod_tensor(0.1, 0.5, rounded=False)),
        (cylinder_mesh(0.5, 0.1), rod_tensor(0.5, 0.1, rounded=False)),
        (capsule_mesh(0.1, 0.5), rod_tensor(0.1, 0.5, rounded=True)),
    ],
)
def test_it_has_the_tensor_of_that_body_wherever_it_lies(mesh: Mesh, exact: object) -> None:
    found = round_tensor(there(mesh))
    assert found is not None
    due = exact.turned(TURN).shifted(PLACE)  # type: ignore[attr-defined]
    # Polygons grown to the volume: radii differ from the true ones by up to 0.3 %.
    root = np.sqrt(np.diag(due.matrix))
    assert np.abs((found.matrix - due.matrix) / np.outer(root, root)).max() < 0.01
    assert found.volume == pytest.approx(mesh.volume, rel=1e-9)


def test_what_is_no_round_body_is_not_taken_for_one() -> None:
    dented = capsule_mesh(0.1, 0.5)
    dented.vertices[0] *= 0.9
    oval = Mesh(
        vertices=cylinder_mesh(0.1, 0.5).vertices * (1.0, 1.1, 1.0),
        faces=cylinder_mesh(0.1, 0.5).faces,
    )
    for mesh in (box_mesh(np.array([1.0, 1.0, 2.0])), box_mesh(np.ones(3)), dented, oval):
        assert round_tensor(mesh) is None
