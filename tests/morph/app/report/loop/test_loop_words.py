from __future__ import annotations

import math

import pytest

from morph.app.report.loop.words import FIGURES, differences, told, truth
from morph.body.load import load
from morph.model.latent.parameter_attribution import Difference
from morph.model.latent.unknowns import unknowns


def differs(name: str, value: float, low: float, high: float) -> Difference:
    return Difference(name=name, value=value, low90=low, high90=high)


@pytest.mark.parametrize(
    ("found", "said"),
    [
        (differs("length:pole", 2.0, 1.987, 2.013), "pole is 2.00 times as long (1.99 to 2.01)"),
        (differs("weight:cart", 0.5, 0.3, 0.8), "cart is 0.5 times as heavy (0.3 to 0.8)"),
        (
            differs("gravity:world", 1.5, 1.45, 1.55),
            "gravity is 1.50 times as strong (1.45 to 1.55)",
        ),
        (
            differs("coulomb_friction@slide:c", 1.0, 0.98, 1.02),
            "slide: Coulomb friction 1.00 N (0.98 to 1.02) was left out",
        ),
        # The same parameter on a hinge is a torque.
        (
            differs("coulomb_friction@hinge:c", 1.0, 0.98, 1.02),
            "hinge: Coulomb friction 1.00 N m (0.98 to 1.02) was left out",
        ),
        (
            differs("actuator_delay@slide:T", 0.05, 0.0492, 0.0508),
            "slide: actuator delay 0.0500 s (0.0492 to 0.0508) was left out",
        ),
    ],
)
def test_a_difference_is_said_in_plain_words(found: Difference, said: str) -> None:
    assert differences([found], load("cartpole")) == (said,)


def test_an_effect_of_several_parameters_is_one_sentence() -> None:
    label = "stribeck_friction@slide"
    found = [differs(f"{label}:{name}", 1.0, 0.9, 1.1) for name in ("c", "s", "vs")]
    (said,) = differences(found, load("cartpole"))
    assert said == (
        "slide: Stribeck friction c = 1.0 N (0.9 to 1.1), s = 1.0 N (0.9 to 1.1), "
        "vs = 1.0 m/s (0.9 to 1.1) was left out"
    )


@pytest.mark.parametrize("name", ["cartpole", "double_pendulum"])
def test_every_figure_that_may_be_off_has_its_words(name: str) -> None:
    robot = load(name)
    assert {knob.what for knob in unknowns(robot)} <= set(FIGURES)


@pytest.mark.parametrize("half", [3.0, 0.3, 0.02, 1e-4])
def test_an_interval_is_never_said_with_two_ends_alike(half: float) -> None:
    _, low, high = told(differs("length:pole", 2.0, 2.0 - half, 2.0 + half))
    assert low != high
    # Rounding moves an end by half a last digit, which is at most half of `half`.
    assert abs(float(high) - (2.0 + half)) <= 0.5 * half + 1e-12


def test_what_has_no_interval_is_said_without_one() -> None:
    assert told(differs("length:pole", 2.0, math.nan, math.nan)) == ("2", "", "")
    assert truth("length:pole", 2.0, load("cartpole")) == "pole is 2 times as long"
