"""The study of residuals conceals what it says, and scores forecasts as it says."""

from __future__ import annotations

import numpy as np
import pytest

from experiments.residual import CASES, HORIZONS, concealed, deterministic_forecast, table, world
from experiments.residual_rivals import gaussian_process
from morph.model.latent.run import Run


def test_a_world_is_the_same_for_the_same_seed_and_foresees_other_runs() -> None:
    one, same, other = (world("dry", seed, learned=1, foreseen=2) for seed in (100, 100, 101))
    assert (one.observed == same.observed).all()
    assert one.observed.shape == (6, 21, 4)
    assert one.command.shape == (6, 20, 1)
    assert np.abs(one.learned[0].command - other.learned[0].command).max() > 1.0


@pytest.mark.parametrize("case", CASES)
def test_each_case_conceals_what_it_is_called_after(case: str) -> None:
    names = {effect.name for effect in concealed(case, np.random.default_rng(0))}
    expected = {
        "none": set(),
        "dry": {"coulomb_friction"},
        "drag": {"quadratic_damping"},
        "spring": {"joint_stiffness"},
        "mixed": {"coulomb_friction", "quadratic_damping"},
    }
    assert names == expected[case]


def _drift(seed: int) -> Run:
    """Return a run whose slide goes on at the speed that the command says."""
    rng = np.random.default_rng(seed)
    command = rng.uniform(-1.0, 1.0, (60, 1))
    place = np.concatenate([[0.0], np.cumsum(command[:, 0])])
    states = np.column_stack([place, *np.zeros((3, 61))]) + 1e-3 * rng.normal(size=(61, 4))
    return Run(position=states[:, :2], velocity=states[:, 2:], command=command, period=0.05)


@pytest.mark.parametrize(("shuffle", "near"), [(None, True), (np.random.default_rng(1), False)])
def test_a_residual_foresees_unless_its_targets_are_shuffled(
    shuffle: np.random.Generator | None, near: bool
) -> None:
    run, noise = _drift(2), np.full(4, 1e-3)
    forecast = gaussian_process([_drift(0), _drift(1)], noise, None, shuffle, draws=8)
    states = forecast(run.state[:1], run.command[None, :3], np.random.default_rng(0))
    off = np.abs(states.mean(axis=0)[0, 1, 0] - run.state[1, 0])
    # A command is up to 1, its mean size 1/2; what is shuffled knows only their middle.
    assert (off < 0.1 * np.abs(run.command[0, 0])) == near


def test_a_sure_simulator_doubts_only_the_start() -> None:
    forecast = deterministic_forecast(lambda x, u: 2.0 * x, np.full(4, 0.1))
    states = forecast(np.zeros((1, 4)), np.zeros((1, 2, 1)), np.random.default_rng(0))
    # 64 draws of 4 numbers: their standard deviation errs by 0.1 / sqrt(512) = 0.0044 or 4.4 %.
    assert states[:, 0, 0].std() == pytest.approx(0.1, rel=0.2)
    assert states[:, 0, 2] == pytest.approx(4.0 * states[:, 0, 0])


def test_the_table_has_medians_and_pools_ranks() -> None:
    seeds = [
        {
            "model": {
                "error": [value] * len(HORIZONS),
                "calibration": 0.1,
                "covered": 0.9,
                "ranks": [0.25, 0.75],
                "seconds": 1.0,
            }
        }
        for value in (0.1, 0.2, 0.9)
    ]
    row = table({"dry": seeds}).splitlines()[-1].split()
    assert row[:5] == ["model", *["0.2000"] * 4]
    # Both ranks lie within the central half and more: everything is inside of 0.96.
    assert row[-2] == "1.000"
