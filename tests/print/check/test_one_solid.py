from __future__ import annotations

from collections.abc import Callable

import pytest

from morph.print.check.one_solid import one_solid
from morph.print.check.overlap import overlap
from morph.print.check.subject import Subject
from morph.print.mesh import Mesh

Make = Callable[..., Mesh]


def test_pieces_are_told_with_their_sizes(
    box: Make, beside: Make, subject: Callable[..., Subject]
) -> None:
    found = one_solid(subject(beside(box(20, 10, 5), box(4, 3, 2, at=(30, 0, 0)))))
    assert found.verdict == "refused"
    assert found.what == "2 solids in one mesh, where 1 is allowed: 20 x 10 x 5, 4 x 3 x 2 mm"


def test_a_crumb_is_told_and_does_not_refuse_the_part(
    box: Make, beside: Make, subject: Callable[..., Subject]
) -> None:
    found = one_solid(subject(beside(box(20, 20, 20), box(0.2, 0.1, 0.1, at=(30, 0, 0)))))
    assert found.verdict == "noted"
    assert "0.2 x 0.1 x 0.1 mm" in found.what


def test_a_void_is_told(box: Make, beside: Make, subject: Callable[..., Subject]) -> None:
    inner = box(10, 10, 10)
    void = Mesh(vertices=inner.vertices, faces=inner.faces[:, ::-1])
    hollow = subject(beside(box(20, 20, 20), void))
    assert one_solid(hollow).verdict == "noted"
    assert overlap(hollow).verdict == "passed"


@pytest.mark.parametrize("shift", [10.0, 15.0])
def test_how_much_of_two_cubes_lies_in_each_other_is_known(
    shift: float, box: Make, beside: Make, subject: Callable[..., Subject]
) -> None:
    found = overlap(subject(beside(box(20, 20, 20), box(20, 20, 20, at=(shift, 0.01, 0.01)))))
    # Each has one whole side in the other, 400 mm2, and of the four sides along the shift the
    # part that they share, 20 (20 - shift), on the two that the small shifts put inside.
    inside = (400.0 + 2.0 * 20.0 * (20.0 - shift)) / 2400.0
    assert found.verdict == "refused"
    # A side is right to two of 1500 points.
    assert found.value == pytest.approx(inside, abs=0.005)
