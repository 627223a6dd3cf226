"""Probabilities of models come true as often as they say, also where errors last."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from morph.arrays import Array
from morph.body.load import load
from morph.body.spec import spec_of
from morph.errors import EvidenceError
from morph.model.ou_likelihood import Likelihood
from morph.model.select import Unsaid, blocks, courses, posterior, weighed
from morph.model.transitions import ModelTransitions

PERIOD = 0.1
NOISE = np.array([0.02, 0.02])
PUSH = np.array([0.5 * PERIOD**2, PERIOD])


def _model(body: str) -> Any:
    return spec_of(load(body)).compile()


def test_a_long_recording_does_not_underflow() -> None:
    log_evidence = np.array([-1e6, -1e6 + np.log(3.0), -2e6])
    probability = posterior(log_evidence, np.log(np.array([0.5, 0.25, 0.25])))
    # Odds of 0.5 to 0.75.
    assert probability == pytest.approx([0.4, 0.6, 0.0])


def test_a_model_without_prior_is_never_chosen_and_all_impossible_is_refused() -> None:
    with np.errstate(divide="ignore"):
        prior = np.log(np.array([0.0, 1.0]))
    assert posterior(np.array([0.0, -50.0]), prior) == pytest.approx([0.0, 1.0])
    with pytest.raises(EvidenceError, match="none of 2 models can produce this recording"):
        posterior(np.array([-np.inf, -np.inf]), prior)


@pytest.mark.parametrize("body", ["cartpole", "hexapod_swimmer", "humanoid"])
def test_every_degree_of_freedom_is_in_one_block_and_of_one_kind(body: str) -> None:
    model = _model(body)
    found = blocks(model)
    assert sorted(np.concatenate([each.dof for each in found])) == list(range(model.nv))
    for each in found:
        assert sorted(at for kind in each.kinds for at in kind) == list(range(len(each.dof)))
    assert len(found) == {"cartpole": 1, "hexapod_swimmer": 7}.get(body, len(found))


def _worlds(
    rng: np.random.Generator, *, left_out: float, off: float
) -> tuple[int, ModelTransitions]:
    """Return one of two worlds, and a run in it, of a point pushed by 0 or by 0.1 m/s2.

    Models tell a wave besides, so that a typical acceleration is 1. What they leave out has a
    standard deviation of `left_out` and lasts 2 s; a doubtful push is off by `off`.
    """
    right, periods = int(rng.integers(2)), 50
    keep = np.exp(-PERIOD / 2.0)
    pushes, doubtful = np.array([0.0, 0.1]), off * rng.normal()
    wave = np.sqrt(2.0) * np.sin(2.0 * np.arange(periods) * PERIOD)
    step = np.array([[1.0, PERIOD], [0.0, 1.0]])
    state, force = np.zeros(2), left_out * rng.normal()
    states = [state]
    for t in range(periods):
        state = step @ state + PUSH * (wave[t] + pushes[right] + force + doubtful)
        force = keep * force + np.sqrt(1.0 - keep**2) * left_out * rng.normal()
        states.append(state)
    seen = np.array(states) + NOISE * rng.normal(size=(periods + 1, 2))
    told = wave[None] + pushes[:, None]
    miss = seen[:-1] @ step.T + told[..., None] * PUSH - seen[1:]
    doubt = np.broadcast_to(0.2 * PUSH[:, None], (2, periods, 2, 1))
    return right, ModelTransitions(
        period=PERIOD,
        miss=miss,
        change=PERIOD * told[..., None],
        carry=np.broadcast_to(step, (1, periods, 2, 2)),
        doubt=doubt,
    )


def _judged(cases: int, unsaid: Unsaid, doubts: int, **world: float) -> tuple[Array, Array]:
    """Return the probability of the answer given, and whether it was right; each (cases,)."""
    model, rng = _model("pendulum"), np.random.default_rng(5)
    sure, right = np.empty(cases), np.empty(cases)
    for case in range(cases):
        truth, seen = _worlds(rng, **world)
        part = courses(model, seen, NOISE, unsaid)[0].until(50)
        fewer = Likelihood(
            base=part.base,
            slope=part.slope[..., :doubts],
            curve=part.curve[..., :doubts, :doubts],
        )
        told = posterior(weighed([fewer]).log_evidence, np.zeros(2))
        sure[case], right[case] = told.max(), told.argmax() == truth
    return sure, right


def test_probabilities_come_true_where_errors_last_and_those_of_exact_models_do_not() -> None:
    sure, right = _judged(150, Unsaid(), 0, left_out=0.1, off=0.0)
    # The gap is a mean of 150 numbers within 1: a standard error of at most 0.5 / sqrt(150).
    assert abs(sure.mean() - right.mean()) < 3.0 * 0.041
    assert 0.55 < right.mean() < 0.95
    sure, right = _judged(150, Unsaid(shares=(0.0,), lengths=(1.0,)), 0, left_out=0.1, off=0.0)
    assert sure.mean() - right.mean() > 0.1


def test_probabilities_come_true_where_a_figure_is_in_doubt_and_without_the_doubt_do_not() -> None:
    exact = Unsaid(shares=(0.0,), lengths=(1.0,))
    sure, right = _judged(150, exact, 1, left_out=0.0, off=0.2)
    assert abs(sure.mean() - right.mean()) < 3.0 * 0.041
    sure, right = _judged(150, exact, 0, left_out=0.0, off=0.2)
    assert sure.mean() - right.mean() > 0.1


def test_what_is_left_out_is_found_and_told_to_be_too_much() -> None:
    model, rng, unsaid = _model("pendulum"), np.random.default_rng(6), Unsaid()
    for left_out, expected in ((0.0, 0.0), (2.0, 1.0)):
        _, seen = _worlds(rng, left_out=left_out, off=0.0)
        part = courses(model, seen, NOISE, unsaid)[0].until(50)
        bad = weighed([part]).too_much(model, unsaid)
        assert bad == pytest.approx(np.full(2, expected), abs=0.05)


def _drawn(rng: np.random.Generator, doubts: int) -> tuple[Likelihood, Array, Array]:
    """Return three normal readings of doubtful figures, with their slopes and readings."""
    slope = rng.normal(size=(3, doubts))
    reading = rng.normal(size=3)
    base = multivariate_normal(np.zeros(3), np.eye(3)).logpdf(reading)
    part = Likelihood(
        base=np.full((1, 1), base),
        slope=(slope.T @ reading)[None, None],
        curve=(slope.T @ slope)[None, None],
    )
    return part, slope, reading


def test_figures_in_doubt_that_blocks_share_are_counted_once() -> None:
    rng = np.random.default_rng(8)
    (one, a, x), (other, b, y) = _drawn(rng, 2), _drawn(rng, 2)
    both, readings = np.concatenate([a, b]), np.concatenate([x, y])
    expected = multivariate_normal(np.zeros(6), np.eye(6) + both @ both.T).logpdf(readings)
    # With one setting the mean field's bound is the evidence itself.
    assert weighed([one, other]).log_evidence == pytest.approx([expected], abs=1e-9)
    mean = np.linalg.solve(np.eye(2) + both.T @ both, both.T @ readings)
    assert weighed([one, other]).doubt[0] == pytest.approx(mean, abs=1e-9)
    # Apart, their evidences would be another number.
    apart = weighed([one]).log_evidence + weighed([other]).log_evidence
    assert abs(float(apart[0]) - expected) > 0.01


def test_with_several_settings_the_bound_is_below_the_evidence_and_near() -> None:
    rng = np.random.default_rng(9)
    pairs = [[_drawn(rng, 1)[0] for _ in range(2)] for _ in range(2)]
    parts = [
        Likelihood(
            base=np.concatenate([each.base for each in pair], axis=1),
            slope=np.concatenate([each.slope for each in pair], axis=1),
            curve=np.concatenate([each.curve for each in pair], axis=1),
        )
        for pair in pairs
    ]
    theta = np.linspace(-8.0, 8.0, 4001)
    log = -0.5 * theta**2 - 0.5 * np.log(2.0 * np.pi)
    for part in parts:
        values = (
            part.base[0, :, None] + part.slope[0] * theta - 0.5 * part.curve[0, ..., 0] * theta**2
        )
        log = log + np.log(np.exp(values).mean(axis=0))
    exact = np.log(np.trapezoid(np.exp(log), theta))
    found = float(weighed(parts).log_evidence[0])
    assert exact - 0.3 < found < exact + 1e-9


def test_no_share_or_no_length_is_refused() -> None:
    with pytest.raises(EvidenceError, match=r"shares \(-1\.0,\) or lengths"):
        Unsaid(shares=(-1.0,))
    with pytest.raises(EvidenceError, match=r"or lengths \(\) s are out of range"):
        Unsaid(lengths=())
