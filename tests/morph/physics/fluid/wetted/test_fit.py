"""Mass, density and volume that do not go together are refused or said."""

import math

import pytest

from morph.errors import EffectError, RobotError
from morph.physics.fluid.wetted import check_density, fit_of


def test_the_swimmer_fits_and_says_nothing() -> None:
    assert fit_of(17.043487, 0.017043487, 1000.0) == ""


def test_the_shell_that_encloses_a_tenth_is_said_to_sink_with_both_numbers() -> None:
    said = fit_of(16.65, 0.00135, 1000.0)
    assert "weighs 16.65 kg and displaces 1.35 kg" in said
    assert "it sinks, unless its volume is 16.65 litres" in said


def test_a_body_that_floats_is_said_to() -> None:
    assert "floats" in fit_of(10.0, 0.02, 1000.0)


def test_a_body_lighter_than_the_air_it_displaces_is_refused() -> None:
    # 1 m3 of air weighs 1.2 kg.
    with pytest.raises(RobotError, match=r"weighs 1 kg .* of air alone weigh 1.2 kg"):
        fit_of(1.0, 1.0, 1000.0)


@pytest.mark.parametrize("bad", [0.0, -1.0, math.nan, math.inf])
def test_numbers_that_are_none_are_refused(bad: float) -> None:
    with pytest.raises(RobotError, match="its mass is"):
        fit_of(bad, 1.0, 1000.0)
    with pytest.raises(RobotError, match="its displaced volume is"):
        fit_of(1.0, bad, 1000.0)
    with pytest.raises(EffectError, match="the density of the fluid is"):
        check_density(bad)
