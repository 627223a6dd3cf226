"""Verdicts where nothing may be claimed: a model no better than the description, and no name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.inference.diagnose import diagnose
from morph.model.diagnosis import Diagnosis


@pytest.fixture(scope="module")
def refuted(recorded: Callable[..., Any]) -> Diagnosis:
    """Friction in every run to learn from, and none in those held out: it came off since."""
    rubbing = recorded(friction=0.06, seeds=range(3), seconds=3.0)
    free = recorded(seeds=(8, 9), seconds=3.0)
    return diagnose(load("pendulum"), rubbing.recordings, held_out=free.recordings, seed=0)


def test_a_model_worse_than_the_description_is_never_accepted(refuted: Diagnosis) -> None:
    assert refuted.verdict == "unknown"
    assert refuted.held_out_rmse["corrected"] == refuted.held_out_rmse["nominal"]
    assert refuted.improvement_low90 == 0.0
    assert refuted.refit == {}
    assert refuted.corrected_effects == ()
    model = mujoco.MjModel.from_xml_string(refuted.corrected)
    assert float(model.dof_frictionloss[0]) == 0.0
    # What was left unfitted is the description's own: the runs are as described, so its error is
    # that of the estimated starts, far from what 0.06 N m do in a second (1.5e-2 rad).
    assert refuted.held_out_rmse["nominal"]["hinge.position"] < 5e-3
    for trace in refuted.traces:
        there = ~np.isnan(trace.time)
        nominal, corrected = trace.models["nominal"][there], trace.models["corrected"][there]
        assert corrected.tolist() == nominal.tolist()


def test_what_held_out_runs_speak_against_is_said_and_counts_half(refuted: Diagnosis) -> None:
    assert [finding.effect.label for finding in refuted.findings] == ["coulomb_friction@hinge"]
    assert refuted.summary()[-1].endswith("worse than the description: it is rejected.")
    errors = refuted.held_out_rmse
    assert errors["rejected"]["hinge.position"] > errors["nominal"]["hinge.position"]
    assert refuted.probabilities["unknown"] == pytest.approx(0.55)
    assert refuted.probabilities["coulomb_friction@hinge"] <= 0.5
    for finding in refuted.findings:
        assert finding.probability == refuted.probabilities[finding.effect.label]
    assert sum(refuted.probabilities.values()) == pytest.approx(1.0, abs=0.1)


@pytest.fixture(scope="module")
def windy(recorded: Callable[..., Any]) -> Diagnosis:
    """A hand that pushes by up to 1 N m in another way in each run: no effect has that force."""

    def hand(seed: int) -> Callable[[Array], Array]:
        rng = np.random.default_rng([seed, 7])
        rate, phase = rng.uniform(0.5, 2.5, 5), rng.uniform(0.0, 2.0 * np.pi, 5)
        return lambda t: 0.2 * np.sin(2.0 * np.pi * t[:, None] * rate + phase).sum(axis=1)

    seeds = range(4)
    runs = recorded(seeds=seeds, push=[hand(seed) for seed in seeds])
    return diagnose(load("pendulum"), runs.recordings, seed=0)


def test_what_no_effect_explains_is_unknown(windy: Diagnosis) -> None:
    assert windy.findings == ()
    assert windy.verdict == "unknown"
    # The rest is for a law of the library that the search missed.
    assert windy.probabilities["unknown"] == pytest.approx(0.55)
    assert windy.probabilities["none"] < 0.01
    assert "has no name" in windy.summary()[0]
    # 0.3 N m of RMS at rates about 1 Hz on 0.25 kg m2 move it by about 0.3 / 0.25 / 40 = 0.03 rad,
    # a hundred times the noise.
    errors = {model: row["hinge.position"] for model, row in windy.held_out_rmse.items()}
    assert errors["corrected"] > 30.0 * errors["noise_floor"]


def test_the_likeliest_effects_are_listed_where_none_is_surely_missing(windy: Diagnosis) -> None:
    listed = {label: p for label, p in windy.probabilities.items() if "@" in label}
    # A sensor's scale is likelier than all else by more than 7 nats: none of that has .01.
    assert list(listed) == ["sensor_scale@hinge.position"]
    # With `none` and `unknown` they are no more than a posterior, whose rest is of other effects.
    assert sum(windy.probabilities.values()) <= 1.0 + 1e-9
    assert windy.summary()[1:] == tuple(f"Perhaps {x.replace('@', ' at ')}." for x in listed)
