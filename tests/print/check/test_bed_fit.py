from __future__ import annotations

from collections.abc import Callable

import pytest

from print.check.bed_fit import bed_fit
from print.check.subject import Subject
from print.mesh import Mesh


@pytest.mark.parametrize(
    # An Ender-3's 220 x 220 x 250 mm less 5 mm at each edge is 210 x 210 x 250: the diagonal of
    # the floor is 297 mm, and that of the room 388 mm, where a thin rod may stand aslant.
    ("sides", "verdict"),
    [
        ((200.0, 200.0, 240.0), "passed"),
        ((10.0, 10.0, 249.0), "passed"),
        ((280.0, 5.0, 5.0), "passed"),
        ((400.0, 20.0, 20.0), "noted"),
        ((215.0, 215.0, 215.0), "noted"),
    ],
)
def test_a_box_fits_if_there_is_any_way_to_lay_it(
    sides: tuple[float, float, float],
    verdict: str,
    box: Callable[..., Mesh],
    subject: Callable[..., Subject],
) -> None:
    assert bed_fit(subject(box(*sides))).verdict == verdict


def test_a_bar_that_does_not_fit_is_told_with_its_size_and_the_bed(
    box: Callable[..., Mesh], subject: Callable[..., Subject]
) -> None:
    found = bed_fit(subject(box(400.0, 20.0, 20.0)))
    assert "400 x 20 x 20 mm does not fit 210 x 210 x 250 mm" in found.what
    assert "cut into pieces" in found.fix
