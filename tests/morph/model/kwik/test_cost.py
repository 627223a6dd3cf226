"""Costs foretold: what a task cares about, and what it does not."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from morph.errors import DiagnosisError
from morph.model.hypothesis import Hypothesis
from morph.model.kwik.certify import judge
from morph.model.kwik.cost import foretell
from morph.model.latent.run import Run
from morph.policy.observing import observations_of
from morph.policy.policy import actions_of
from morph.policy.track import Track
from morph.task.task import Task

Recorded = Callable[..., Run]


def told(task: Task, command: float) -> Track:
    """Return a policy that pushes one way for a second, whatever it sees, then not at all."""
    commands = np.zeros((21, 1))
    commands[:20] = command
    return Track(
        nominal=np.zeros((21, 4)),
        command=commands,
        gain=np.zeros((21, 1, 4)),
        action=actions_of(task.robot),
        observation=observations_of(task.robot),
        period=task.period,
    )


def test_a_wrong_model_foretells_the_cost_of_hanging_still(
    task: Task, hypothesis: Hypothesis, recorded: Recorded
) -> None:
    run = recorded({"weight:cart": 1.3})
    rng = np.random.default_rng(100)
    noise = np.full(4, 0.01)
    assert judge(hypothesis, [run], noise, integrator="rk4", rng=rng).verdict == "not good"
    found = foretell(hypothesis, [run], task, told(task, 0.0), rng=rng)
    assert found.verdict == "good"
    # Hanging, the tip is 1 m from the top: 1 - exp(-(1 / 0.25)^2 / 2) = 0.9997 at 61 samples.
    assert found.model == pytest.approx(61.0, rel=1e-3)
    np.testing.assert_allclose(found.targets, found.model, rtol=0.01)


def test_a_tight_tolerance_is_not_met_where_the_mass_matters(
    task: Task, hypothesis: Hypothesis, recorded: Recorded
) -> None:
    run = recorded({"weight:cart": 2.0})
    rng = np.random.default_rng(101)
    found = foretell(hypothesis, [run], task, told(task, 10.0), within=1e-5, rng=rng)
    assert found.verdict == "not good"
    assert "within the tolerance" in found.text


def test_a_tolerance_is_a_positive_number(
    task: Task, hypothesis: Hypothesis, recorded: Recorded
) -> None:
    with pytest.raises(DiagnosisError, match=r"a tolerance of 0"):
        foretell(
            hypothesis,
            [recorded()],
            task,
            told(task, 0.0),
            within=0.0,
            rng=np.random.default_rng(0),
        )
