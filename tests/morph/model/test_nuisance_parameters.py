from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.errors import DiagnosisError
from morph.model.hypothesis import Hypothesis
from morph.model.nuisance_parameters import Knob, knobs


def names(robot: Robot, **vary: float) -> set[str]:
    return {knob.name for knob in knobs(robot, vary)}


def test_only_figures_that_move_a_cartpole_are_turned(cartpole: Robot) -> None:
    # A cart that cannot turn or fall has neither a centre nor an inertia that shows.
    assert names(cartpole) == {
        "mass:cart",
        "mass:pole",
        "com:pole",
        "inertia:pole",
        "gain:slide",
        "damping:slide",
    }


def test_zero_trusts_a_kind_a_part_or_one_figure_fully(cartpole: Robot) -> None:
    everything = names(cartpole)
    assert everything - names(cartpole, mass=0.0) == {"mass:cart", "mass:pole"}
    assert everything - names(cartpole, pole=0.0) == {"mass:pole", "com:pole", "inertia:pole"}
    by_figure = {knob.name for knob in knobs(cartpole, {"mass:pole": 0.0})}
    assert everything - by_figure == {"mass:pole"}


def test_the_narrowest_name_decides(cartpole: Robot) -> None:
    found = knobs(cartpole, {"mass": 0.3, "pole": 0.2, "mass:pole": 0.4})
    fraction = {knob.name: knob.fraction for knob in found}
    assert fraction["mass:pole"] == 0.4
    assert fraction["com:pole"] == 0.2
    assert fraction["mass:cart"] == 0.3
    assert fraction["damping:slide"] == 0.10


@pytest.mark.parametrize(
    ("name", "fraction", "what"),
    [
        ("weight", 0.1, "no such figure; there are .*mass:pole"),
        ("mass:wheel", 0.1, "no such figure"),
        ("mass", math.nan, "a fraction is between 0 and 50"),
        ("mass", -0.1, "a fraction is between 0 and 50"),
        ("mass", 51.0, "a fraction is between 0 and 50"),
    ],
)
def test_what_cannot_vary_is_refused(
    cartpole: Robot, name: str, fraction: float, what: str
) -> None:
    with pytest.raises(DiagnosisError, match=f"--vary {name}.*{what}") as caught:
        knobs(cartpole, {name: fraction})
    assert caught.value.where == "robot cartpole"
    assert caught.value.fix


def test_a_figure_stays_within_its_fraction(cartpole: Robot) -> None:
    for fraction in (0.05, 0.3, 3.0):
        knob = Knob(kind="mass", part="pole", what="mass", fraction=fraction)
        low, high = (math.exp(bound) for bound in knob.bounds)
        assert high == pytest.approx(1.0 + fraction, rel=1e-12)
        # From a half on, what is taken away would leave nothing: a factor both ways.
        due = 1.0 - fraction if fraction < 0.5 else 1.0 / (1.0 + fraction)
        assert low == pytest.approx(due, rel=1e-12)


def test_a_joints_figure_of_which_nothing_is_said_may_be_freed(cartpole: Robot) -> None:
    found = Hypothesis(robot=cartpole, step=0.004, knobs=knobs(cartpole))
    (guess,) = (knob for knob in found.knobs if knob.what == "damping")
    assert [math.exp(bound) for bound in guess.bounds] == pytest.approx([0.9, 1.1])
    (free,) = (knob for knob in found.freed().knobs if knob.what == "damping")
    assert [math.exp(bound) for bound in free.bounds] == pytest.approx([0.05, 1.1])
    assert (guess.spread, free.spread) == (0.1, 0.5)
    # What is said of it holds, and so do masses.
    told = replace(found, knobs=knobs(cartpole, {"joint": 0.2}))
    assert told.freed() == told


@pytest.mark.parametrize(
    ("name", "figure", "nominal"),
    [
        ("mass:pole", lambda m: m.body("pole").mass[0], 0.5),
        ("com:pole", lambda m: m.body("pole").ipos[2], -0.25),
        ("inertia:pole", lambda m: m.body("pole").inertia.max(), 0.5 * 0.5**2 / 12.0),
        ("gain:slide", lambda m: m.actuator("slide").gainprm[0], 1.0),
        ("damping:slide", lambda m: np.ravel(m.joint("slide").damping)[0], 0.1),
    ],
)
def test_a_turned_knob_multiplies_its_figure(
    cartpole: Robot, name: str, figure: object, nominal: float
) -> None:
    assert callable(figure)
    (knob,) = (k for k in knobs(cartpole) if k.name == name)
    spec = spec_of(cartpole)
    knob.edit(spec, math.log(1.07))
    assert figure(spec.compile()) == pytest.approx(1.07 * nominal, rel=1e-9)


def test_more_doubt_allows_no_less() -> None:
    fractions = (0.1, 0.25, 0.49, 0.5, 0.6, 0.99, 1.0, 3.0)
    bounds = [Knob(kind="mass", part="pole", what="mass", fraction=f).bounds for f in fractions]
    lows, highs = np.exp(np.array(bounds)).T
    assert lows == pytest.approx([0.9, 0.75, 0.51, 0.5, 0.5, 0.5, 0.5, 0.25])
    assert highs == pytest.approx([1.0 + f for f in fractions])
