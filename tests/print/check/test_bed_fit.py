from __future__ import annotations

from collections.abc import Callable

import pytest

from morph.print.check.bed_fit import bed_fit
from morph.print.check.subject import Subject
from morph.print.mesh import Mesh
from morph.print.orient import fits
from morph.print.split import split


@pytest.mark.parametrize(
    # An Ender-3's 220 x 220 x 250 mm less 5 mm at each edge is 210 x 210 x 250: the diagonal of
    # the floor is 297 mm; that of the room, 388 mm, is of no use, since a part lies on a face.
    ("sides", "verdict"),
    [
        ((200.0, 200.0, 240.0), "passed"),
        ((10.0, 10.0, 249.0), "passed"),
        ((280.0, 5.0, 5.0), "passed"),
        ((320.0, 5.0, 5.0), "noted"),
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


@pytest.mark.parametrize("length", [289.0, 293.0, 300.0, 340.0])
def test_what_fits_is_what_can_be_laid_and_is_not_cut_later(
    length: float, box: Callable[..., Mesh], subject: Callable[..., Subject]
) -> None:
    bar = subject(box(length, 5.0, 5.0))
    # Across the diagonal a bar of 5 mm fits up to 210 sqrt(2) - 5 = 292 mm.
    assert (bed_fit(bar).verdict == "passed") == fits(bar.mesh, bar.profile) == (length < 292.0)
    assert len(split(bar.part, bar.profile)) == (1 if length < 292.0 else 2)
