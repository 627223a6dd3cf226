from __future__ import annotations

import math

import pytest

from morph.errors import RecordingError
from morph.record.units import UNITS, unit


@pytest.mark.parametrize(
    ("symbol", "factor"),
    [
        ("deg", math.pi / 180.0),
        ("rpm", math.pi / 30.0),
        ("us", 1e-6),
        ("mN m", 1e-3),
        ("g", 9.80665),
        ("deg/s2", math.pi / 180.0),
        ("mm/s", 1e-3),
    ],
)
def test_a_unit_has_the_factor_of_the_si_brochure(symbol: str, factor: float) -> None:
    assert unit(symbol, where="here").factor == pytest.approx(factor, rel=1e-15)


def test_every_dimension_is_itself_a_unit_of_factor_one() -> None:
    assert {one.dimension for one in UNITS.values()} <= set(UNITS)
    assert all(UNITS[one.dimension].factor == 1.0 for one in UNITS.values())


def test_an_unknown_unit_is_refused_with_the_nearest() -> None:
    with pytest.raises(RecordingError, match="the unit 'degs' is unknown") as caught:
        unit("degs", where="recording.toml:7")
    assert caught.value.where == "recording.toml:7"
    assert "'deg'" in caught.value.fix
