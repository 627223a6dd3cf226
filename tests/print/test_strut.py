from __future__ import annotations

import pytest

from morph.print.solid import box, pieces, union
from morph.print.strut import strut

ONE = ((0.0, 0.0, 0.0), (10.0, 10.0, 10.0))
OTHER = ((30.0, 0.0, 0.0), (40.0, 10.0, 10.0))


@pytest.mark.parametrize("wall", [0.0, 20.0])
def test_a_strut_makes_one_piece_of_two_and_keeps_out_of_what_is_forbidden(wall: float) -> None:
    one, other = box(*ONE), box(*OTHER)
    # A wall between them that is wider and higher than both, so that the way leads around it.
    forbidden = box((18.0, -5.0, -5.0), (22.0, wall, wall)) if wall else union([])
    between = strut(one, other, forbidden)
    assert between is not None
    assert len(pieces(union([one, other, between]))) == 1
    assert (between ^ forbidden).volume() < 1e-6


def test_what_is_shut_in_cannot_be_joined() -> None:
    shut = box((-80.0, -80.0, -80.0), (20.0, 80.0, 80.0)) - box(
        (-5.0, -5.0, -5.0), (15.0, 15.0, 15.0)
    )
    assert strut(box(*ONE), box(*OTHER), shut) is None
