"""What is named from one run: the change that was made, and nothing where none was."""

from __future__ import annotations

import numpy as np
import pytest

from morph.body.robot import Robot
from morph.model.gaussian.information import Information
from morph.model.latent.parameter_attribution import explain
from morph.model.latent.subsets import subsets
from morph.model.latent.unknowns import turned
from morph.physics import EFFECTS

NOISE = np.full(4, 0.01)
KINDS = {each.name: each for each in EFFECTS}


def named(cartpole: Robot, run) -> list[str]:
    found = explain(cartpole, [run], NOISE, step=0.01, integrator="rk4")
    return [each.name for each in found.differences]


@pytest.mark.parametrize("seed", [11, 12])
def test_nothing_is_named_where_nothing_changed(cartpole: Robot, shown, seed: int) -> None:
    assert named(cartpole, shown(cartpole, seed=seed)) == []


@pytest.mark.parametrize("name", ["length:pole", "weight:cart", "gravity:world"])
def test_the_one_figure_that_changed_is_named(cartpole: Robot, shown, name: str) -> None:
    assert named(cartpole, shown(turned(cartpole, {name: 1.7}), seed=13)) == [name]


def test_a_missing_effect_is_named_beside_a_changed_figure(cartpole: Robot, shown) -> None:
    dry = KINDS["coulomb_friction"](joint="slide", c=1.5)
    run = shown(turned(cartpole, {"length:pole": 1.5}), (dry,), seed=14)
    found = explain(cartpole, [run], NOISE, step=0.01, integrator="rk4")
    values = {each.name: each for each in found.differences}
    assert set(values) == {"length:pole", "coulomb_friction@slide:c"}
    assert values["length:pole"].value == pytest.approx(1.5, rel=0.02)
    assert values["coulomb_friction@slide:c"].value == pytest.approx(1.5, rel=0.1)
    assert found.evidence > 10.0


def test_a_late_command_is_named(cartpole: Robot, shown) -> None:
    late = KINDS["actuator_delay"](actuator="slide", T=0.035)
    assert named(cartpole, shown(cartpole, (late,), seed=15)) == ["actuator_delay@slide:T"]


def test_sets_are_weighed_as_exact_normal_integrals_weigh_them() -> None:
    # One parameter seen once with deviation 0.1 at the value 0.5: its evidence is that of a
    # normal distribution of variance 0.01 + prior, so wide over narrow is
    # N(0.5; 0, 0.01 + 1) / N(0.5; 0, 0.01 + 0.0025).
    likelihood = Information(H=np.array([[100.0]]), b=np.array([50.0]), c=0.0)
    order = subsets(likelihood, np.array([1.0]), np.array([400.0]), 1)
    by_set = {each.changed: each.evidence for each in order}

    def log_normal(variance: float) -> float:
        return -0.5 * (0.25 / variance + np.log(2.0 * np.pi * variance))

    expected = log_normal(1.01) - log_normal(0.0125) - 2.0
    assert by_set[(0,)] - by_set[()] == pytest.approx(expected, abs=1e-9)
    assert order[0].changed == (0,)
