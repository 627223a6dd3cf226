"""Shapes that several tests break in their own way."""

import numpy as np
import pytest

from morph.body.mesh import Mesh
from morph.physics.fluid.wetted.tessellate import box_mesh, ellipsoid_mesh


@pytest.fixture
def cube() -> Mesh:
    """A cube of 0.1 m about the origin."""
    return box_mesh(np.full(3, 0.1))


@pytest.fixture
def ball() -> Mesh:
    """A ball of radius 0.1 m about the origin, as 1280 faces."""
    return ellipsoid_mesh(np.full(3, 0.1))
