"""Two pieces of physics left out at once."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from morph.body.load import load
from morph.inference.diagnose import diagnose
from morph.model.diagnosis import Diagnosis

TRUE = {"torque_scale": ("gain", 1.4), "coulomb_friction": ("c", 0.06)}


@pytest.fixture(scope="module")
def found(recorded: Callable[..., Any]) -> Diagnosis:
    gain, friction = (value for _, value in TRUE.values())
    runs = recorded(gain=gain, friction=friction, seeds=range(4), seconds=3.0)
    return diagnose(load("pendulum"), runs.recordings, seed=0)


def test_both_are_found_the_larger_first(found: Diagnosis) -> None:
    assert found.verdict == "mismatch"
    labels = [finding.effect.label for finding in found.findings]
    # A motor 40 % too strong explains more than 0.06 N m of friction beside 3 N m of torque.
    assert labels == ["torque_scale@hinge", "coulomb_friction@hinge"]
    gains = [finding.gain for finding in found.findings]
    assert gains == sorted(gains, reverse=True)
    assert all(0.5 < gain < 1.0 for gain in gains)


def test_each_interval_belongs_to_its_own_effect(found: Diagnosis) -> None:
    for finding in found.findings:
        symbol, value = TRUE[finding.effect.name]
        estimate = finding.parameters[symbol]
        # Mass and gain are known to 10 and 5 % only, and the motion tells their ratio: to either
        # side 1.645 of (0.1^2 + 0.05^2)^0.5 = 18 % at most, 26 % at a temperature of 2.
        assert estimate.value == pytest.approx(value, rel=0.05)
        assert estimate.low90 < estimate.value < estimate.high90
        assert getattr(finding.effect, symbol) == pytest.approx(estimate.value)
        assert estimate.high90 - estimate.low90 < 0.54 * value


def test_each_is_likelier_than_its_rivals(found: Diagnosis) -> None:
    for finding in found.findings:
        # A lighter rod swings as one with a stronger motor does: some say that instead.
        assert finding.probability > 0.5
        assert found.probabilities[finding.effect.label] == finding.probability
        chances = [rival.probability for rival in finding.rivals]
        assert chances == sorted(chances, reverse=True)
        assert finding.effect.label not in {f"{r.effect}@{r.where}" for r in finding.rivals}
    assert found.probabilities["none"] < 0.1


def test_the_corrected_model_leaves_a_small_part_of_the_error(found: Diagnosis) -> None:
    error = {model: row["hinge.position"] for model, row in found.held_out_rmse.items()}
    # Measured: 2e-3 of 0.17 rad.
    assert error["corrected"] < 0.1 * error["nominal"]
    assert found.improvement_low90 > 1.0 - 0.1**2
    assert np.isfinite(list(error.values())).all()
