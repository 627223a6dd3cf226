"""Which runs decide whether a learned force is used."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.inference.diagnose import diagnose
from morph.model.diagnosis import Diagnosis
from morph.record.recording import Recording

HEAVY = 1.15
"""True mass by that described: a refit beats the description on every run."""


def sided(k: float) -> Callable[[Array, Array], Array]:
    """Return the torque -k q v, which no effect has: it drives on one side."""
    return lambda q, v: -k * q * v


@pytest.fixture(scope="module")
def learned_from(recorded: Callable[..., Any]) -> list[Recording]:
    runs: list[Recording] = recorded(force=sided(0.6), seeds=range(4), mass=HEAVY).recordings
    return runs


@pytest.fixture(scope="module")
def like_the_training(recorded: Callable[..., Any], learned_from: list[Recording]) -> Diagnosis:
    runs = recorded(force=sided(0.6), seeds=(4, 5), mass=HEAVY)
    return diagnose(load("pendulum"), learned_from, held_out=runs.recordings, seed=0)


@pytest.fixture(scope="module")
def unlike_the_training(recorded: Callable[..., Any], learned_from: list[Recording]) -> Diagnosis:
    """The force is turned round in the runs held out: what was learned makes them worse."""
    runs = recorded(force=sided(-0.2), seeds=(4, 5), mass=HEAVY)
    return diagnose(load("pendulum"), learned_from, held_out=runs.recordings, seed=0)


def test_a_force_without_a_name_is_learned(like_the_training: Diagnosis) -> None:
    errors = {m: row["hinge.position"] for m, row in like_the_training.held_out_rmse.items()}
    assert like_the_training.verdict == "unknown"
    assert like_the_training.residual
    assert errors["corrected_plus_residual"] < 0.8 * errors["corrected"]


def test_held_out_runs_do_not_choose_the_residual_whose_error_they_tell(
    like_the_training: Diagnosis, unlike_the_training: Diagnosis
) -> None:
    errors = {m: row["hinge.position"] for m, row in unlike_the_training.held_out_rmse.items()}
    assert errors["corrected"] < errors["nominal"]
    assert errors["corrected_plus_residual"] > errors["corrected"]
    ours, theirs = like_the_training.residual, unlike_the_training.residual
    assert set(ours) == set(theirs)
    for name, values in ours.items():
        assert np.array_equal(values, theirs[name]), name


def test_a_residual_goes_with_the_model_beside_which_it_was_learned(
    recorded: Callable[..., Any], learned_from: list[Recording]
) -> None:
    # The pendulum held out is as described: the heavier one that was learned is worse.
    as_described = recorded(seeds=(4, 5)).recordings
    found = diagnose(load("pendulum"), learned_from, held_out=as_described, seed=0)
    assert found.held_out_rmse["corrected"] == found.held_out_rmse["nominal"]
    assert "corrected_plus_residual" not in found.held_out_rmse
    assert found.residual == {}
