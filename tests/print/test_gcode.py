from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from morph.print.errors import SlicerError
from morph.print.gcode import lines

ABSOLUTE = b"""G28
M82
G92 E0
G1 X10 Y10 Z0.2 F6000
;TYPE:Perimeter
;WIDTH:0.45
;HEIGHT:0.2
G1 X30 Y10 E1.5 ; a line
G1 E0.7 F2400
G1 X30 Y40
G1 E1.5
;TYPE:Solid infill
;WIDTH:0.4
G1 X10 Y40 E2.25
G92 E0
G1 X10 Y10 E3
"""
"""Three lines with 1.5, 0.75 and 3 mm of filament, and a retraction of 0.8 mm in between."""

RELATIVE = b"""G28
M83
G1 X10 Y10 Z0.2 F6000
;TYPE:Perimeter
;WIDTH:0.45
;HEIGHT:0.2
G1 X30 Y10 E1.5
G1 E-0.8
G91
G1 Y30
G90
M83
G1 E.8
;TYPE:Solid infill
;WIDTH:0.4
G1 X10 E.75
G1 Y10 E3
"""
"""The same, with relative distances."""


@pytest.mark.parametrize("gcode", [ABSOLUTE, RELATIVE, ABSOLUTE.replace(b"\n", b"\r\n")])
def test_absolute_and_relative_distances_tell_the_same_lines(gcode: bytes) -> None:
    found = lines(gcode)
    assert found.filament == pytest.approx([1.5, 0.75, 3.0])
    assert found.start == pytest.approx(np.array([[10, 10, 0.2], [30, 40, 0.2], [10, 40, 0.2]]))
    assert found.end == pytest.approx(np.array([[30, 10, 0.2], [10, 40, 0.2], [10, 10, 0.2]]))


def test_each_line_has_the_type_width_and_height_that_were_named_last() -> None:
    found = lines(ABSOLUTE)
    assert [found.features[each] for each in found.feature] == [
        "Perimeter",
        "Solid infill",
        "Solid infill",
    ]
    assert found.width == pytest.approx([0.45, 0.4, 0.4])
    assert found.height == pytest.approx([0.2, 0.2, 0.2])


def test_without_remarks_the_type_is_empty_and_the_sizes_are_unknown() -> None:
    found = lines(b"G1 X1 E1\n")
    assert (found.features, found.feature.tolist()) == (("",), [0])
    assert np.isnan(found.width).all()
    assert np.isnan(found.height).all()


def test_a_pause_in_printing_and_a_wipe_lay_nothing() -> None:
    # Filament is drawn back along the way, and pushed again in place: neither is a line.
    found = lines(b"M83\nG1 X1 E1\nG1 X0 E-0.8\nG1 E0.8\nG1 X5\nG1 X6 E1\n")
    assert found.filament.tolist() == [1.0, 1.0]


def test_homing_one_axis_leaves_the_others() -> None:
    found = lines(b"M83\nG1 X4 Y5 Z6\nG28 X\nG1 Y7 E1\n")
    assert found.start.tolist() == [[0.0, 5.0, 6.0]]
    assert found.end.tolist() == [[0.0, 7.0, 6.0]]


@pytest.mark.parametrize(
    ("gcode", "said"),
    [
        (b"G1 X1 E1\nG2 X3 Y3 I1 J1 E1\n", r"line 2 is an arc \(G2\)"),
        (b"G20\nG1 X1 E1\n", r"line 1 is inches \(G20\)"),
        (b"G1 X1 E1\nG1 X1.2.3 E1\n", "a coordinate is no number"),
        (b"G1 X1 Enan\n", "a coordinate is no number"),
        (b"G1 X1 E1\n;WIDTH:wide\nG1 X2 E2\n", "the width or height of a line is no number"),
        (b"G28\nG1 X1 Y1\n", "none of its 2 lines lays plastic"),
        (b"", "none of its 0 lines lays plastic"),
    ],
)
def test_what_cannot_be_weighed_is_refused_and_says_where(gcode: bytes, said: str) -> None:
    with pytest.raises(SlicerError, match=said) as caught:
        lines(gcode, where="plate.gcode")
    assert caught.value.where == "plate.gcode"
    assert caught.value.fix


words = st.sampled_from([b"G1", b"G0", b"G92", b"G28", b"G90", b"G91", b"M82", b"M83", b"X1.5",
                         b"Y-2", b"E3", b"E", b"\n", b"\n", b";TYPE:Perimeter", b";WIDTH:", b"*7",
                         b"\xff", b"Z1e3"])  # fmt: skip


@given(st.lists(words, max_size=60), st.binary(max_size=40))
def test_no_text_is_read_wrongly_without_a_word(text: list[bytes], tail: bytes) -> None:
    try:
        found = lines(b" ".join(text) + tail)
    except SlicerError:
        return
    assert np.isfinite(found.start).all()
    assert np.isfinite(found.end).all()
    assert (found.filament > 0).all()
