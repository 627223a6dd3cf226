"""The gate on cart-poles whose changes are known."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from morph.errors import DiagnosisError
from morph.model.hypothesis import Hypothesis
from morph.model.kwik.certify import ModelVerdict, judge, watch
from morph.model.kwik.transition_evidence import visit
from morph.model.latent.run import Run
from morph.model.latent.transition_model import Transit
from morph.task.task import Task

Recorded = Callable[..., Run]
NOISE = np.full(4, 0.01)


def asked(hypothesis: Hypothesis, runs: list[Run], **other: object) -> ModelVerdict:
    rng = np.random.default_rng(100)
    return judge(hypothesis, runs, NOISE, integrator="rk4", rng=rng, **other)  # type: ignore[arg-type]


def test_a_model_of_the_target_itself_is_good(hypothesis: Hypothesis, recorded: Recorded) -> None:
    found = asked(hypothesis, [recorded()])
    assert found.verdict == "good"
    assert found.probability > 0.95
    assert found.transitions.shape == (60,)
    assert "good enough here" in found.text


@pytest.mark.parametrize(
    "changed", [{"weight:cart": 1.1}, {"weight:pole": 0.9}, {"length:pole": 1.1}]
)
def test_ten_percent_off_is_not_good(
    hypothesis: Hypothesis, recorded: Recorded, changed: dict[str, float]
) -> None:
    found = asked(hypothesis, [recorded(changed)])
    assert found.verdict == "not good"
    assert found.probability < 0.05
    assert "repair the model" in found.text


def test_what_is_not_good_for_a_fine_epsilon_is_good_for_a_coarse_one(
    hypothesis: Hypothesis, recorded: Recorded
) -> None:
    run = recorded({"weight:cart": 1.1})
    # A tenth of the mass changes velocities by at most 0.05 m/s and 0.2 rad/s in one period of a
    # full push of 10 N: 10 N / 0.5 kg * 0.05 s = 1 m/s at most, 5 % of which is 0.05.
    coarse = asked(hypothesis, [run], epsilon=np.array([0.1, 0.1, 0.5, 1.5]))
    assert asked(hypothesis, [run]).verdict == "not good"
    assert coarse.verdict == "good"


def test_a_few_samples_do_not_say(hypothesis: Hypothesis, recorded: Recorded) -> None:
    run = recorded()
    few = Run(
        position=run.position[:5],
        velocity=run.velocity[:5],
        command=run.command[:4],
        period=run.period,
    )
    assert asked(hypothesis, [few]).verdict == "cannot say"


def test_the_last_moment_is_the_whole_run(hypothesis: Hypothesis, recorded: Recorded) -> None:
    run = recorded({"weight:pole": 1.05})
    rng = np.random.default_rng(100)
    (last,) = watch(hypothesis, [run], NOISE, [60], integrator="rk4", rng=rng)
    whole = asked(hypothesis, [run])
    assert (last.verdict, last.for_good) == (whole.verdict, whole.for_good)
    np.testing.assert_array_equal(last.transitions, whole.transitions)


def test_two_runs_say_more_than_one(hypothesis: Hypothesis, recorded: Recorded) -> None:
    small = {"weight:cart": 0.997}
    one = asked(hypothesis, [recorded(small)])
    two = asked(hypothesis, [recorded(small), recorded(small, seed=101)])
    # Evidence adds up: the bet against "not good" grows with the second run.
    assert two.for_good > one.for_good


def test_the_error_of_a_small_change_is_that_of_the_two_simulations(
    task: Task, hypothesis: Hypothesis, recorded: Recorded
) -> None:
    transit = Transit(hypothesis=hypothesis, period=task.period, integrator="rk4")
    run = recorded(noise=np.zeros(4))
    seen = visit(transit, [run], NOISE, np.ones(4))
    named = hypothesis.names.index("weight:cart")
    change = 1e-3 * np.eye(hypothesis.size)[named]
    there = transit.ahead(change, run, run.state)
    here = transit.ahead(np.zeros_like(change), run, run.state)
    # The slope is a forward difference of the same step: they agree to rounding over the step,
    # 1e-12 / 1e-3; a second figure would differ in the first digit.
    np.testing.assert_allclose(1e-3 * seen.error[:, :, named], there - here, atol=1e-9)


def test_noise_and_epsilon_must_be_above_zero(hypothesis: Hypothesis, recorded: Recorded) -> None:
    with pytest.raises(DiagnosisError, match=r"noise is \[0\.0"):
        judge(hypothesis, [recorded()], np.zeros(4), rng=np.random.default_rng(0))
    with pytest.raises(DiagnosisError, match=r"epsilon \[0\.0"):
        asked(hypothesis, [recorded()], epsilon=np.zeros(4))


def test_no_run_is_no_evidence(hypothesis: Hypothesis) -> None:
    with pytest.raises(DiagnosisError, match=r"there is no run"):
        asked(hypothesis, [])


def test_runs_share_one_clock(hypothesis: Hypothesis, recorded: Recorded) -> None:
    run = recorded()
    slow = Run(
        position=run.position, velocity=run.velocity, command=run.command, period=2 * run.period
    )
    with pytest.raises(DiagnosisError, match=r"control periods of \[0\.05, 0\.1\] s"):
        asked(hypothesis, [run, slow])


@pytest.mark.parametrize("delta", [0.0, 0.5, float("nan")])
def test_delta_is_a_small_share(hypothesis: Hypothesis, recorded: Recorded, delta: float) -> None:
    with pytest.raises(DiagnosisError, match=r"delta is"):
        asked(hypothesis, [recorded()], delta=delta)
