"""What differs by place or by mirroring alone is one form."""

import numpy as np
import pytest

from morph.body.mesh import Mesh
from morph.physics.fluid.wetted.alike import form_of
from morph.physics.fluid.wetted.tessellate import box_mesh, cylinder_mesh


def limb() -> tuple[Mesh, ...]:
    """A thigh of two parts, as lopsided along each axis."""
    rod = cylinder_mesh(0.05, 0.4)
    box = box_mesh(np.array([0.1, 0.2, 0.15]))
    return (rod, Mesh(vertices=box.vertices + np.array([0.03, 0.12, 0.2]), faces=box.faces))


def mirrored(shapes: tuple[Mesh, ...], signs: tuple[float, ...]) -> tuple[Mesh, ...]:
    return tuple(shape.scaled(signs) for shape in shapes)


@pytest.mark.parametrize("signs", [(-1, 1, 1), (1, -1, 1), (-1, -1, 1), (-1, -1, -1)])
def test_a_mirrored_limb_is_the_same_limb(signs: tuple[float, ...]) -> None:
    one, other = form_of(limb()), form_of(mirrored(limb(), signs))
    assert one.content == other.content
    assert (one.signs * signs == other.signs).all()
    assert sum(shape.volume for shape in other.shapes) == pytest.approx(
        sum(shape.volume for shape in limb())
    )


def test_place_the_order_of_shapes_and_the_last_digits_make_no_difference() -> None:
    moved = tuple(
        Mesh(vertices=shape.vertices * (1 + 1e-15) + 0.7, faces=shape.faces)
        for shape in reversed(limb())
    )
    one, other = form_of(limb()), form_of(moved)
    assert one.content == other.content
    assert np.allclose(other.middle - one.middle, 0.7)


def test_another_size_or_proportion_is_another_form() -> None:
    contents = {
        form_of(tuple(shape.scaled(factors) for shape in limb())).content
        for factors in ((1, 1, 1), (1.001, 1.001, 1.001), (1, 1, 1.001))
    }
    assert len(contents) == 3


def test_a_form_put_back_is_where_it_was() -> None:
    form = form_of(limb())
    points = np.concatenate([form.signs * s.vertices + form.middle for s in form.shapes])
    before = np.concatenate([shape.vertices for shape in limb()])
    # Rounded to a billionth of half a metre.
    assert np.allclose(points.min(axis=0), before.min(axis=0), atol=1e-9)
    assert np.allclose(points.max(axis=0), before.max(axis=0), atol=1e-9)
