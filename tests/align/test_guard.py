"""What the guard foresees of a falling pendulum whose law is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from morph.alignment.arrays import Array
from morph.alignment.belief import mechanical
from morph.alignment.errors import SettingError
from morph.alignment.guard import GONE, Law, PredictedScores, TrialTask, foreseen, judge
from morph.alignment.metric import apart, certain, promise

PERIOD = 0.02


def falling(command: float = 5.0) -> Array:
    """The law of a pendulum that falls at 19.62 /s2, under commands of so many rad/s2."""
    base, lift, _ = mechanical(1, np.ones(1), PERIOD)
    return np.asarray(base + lift @ (PERIOD * np.array([[19.62, 0.0, command]])))


def trial(periods: int = 100) -> TrialTask:
    return TrialTask(
        outcome=np.array([[4.0, 0.0], [0.0, 0.8]]),
        starts=np.array([[0.05, 0.0], [-0.05, 0.1]]),
        low=np.array([-20.0]),
        high=np.array([20.0]),
        periods=periods,
        period=PERIOD,
    )


def linear(gain: float, damping: float) -> Law:
    return lambda x, time: -(gain * x[:, :1] + damping * x[:, 1:])


def ahead(law: Law, *, noise: float = 1e-3) -> PredictedScores:
    known = certain(falling(), noise=np.full(2, noise))
    return foreseen(known, law, trial(), np.random.default_rng(0), draws=8)


def test_holding_still_scores_until_the_pendulum_has_fallen_as_eigenvalues_say() -> None:
    # x' = M x with a = 19.62 q held through a period; M^k by its eigenvalues. The score is the
    # mean of exp(-(4 q)^2 / 2) until 4 q reaches GONE.
    one = replace(trial(), starts=np.array([[0.05, 0.0]]))
    known = certain(falling(), noise=np.full(2, 1e-6))
    found = foreseen(known, linear(0.0, 0.0), one, np.random.default_rng(0), draws=2)
    a = 19.62
    values, vectors = np.linalg.eig(
        np.array([[1.0 + 0.5 * a * PERIOD**2, PERIOD], [a * PERIOD, 1.0]])
    )
    parts = np.linalg.solve(vectors, np.array([0.05, 0.0])) * vectors[0]
    z = 4.0 * (values ** np.arange(100)[:, None] @ parts)
    expected = np.where(z < GONE, np.exp(-0.5 * z**2), 0.0).mean()
    assert found.still == pytest.approx(expected, abs=1e-9)
    assert found.score == pytest.approx(found.still, abs=1e-12)


def test_a_policy_that_holds_is_foreseen_to_do_better_and_its_negative_worse() -> None:
    # Held if 5 gain > 19.62, so 10 holds; with its sign wrong it falls faster than alone.
    good, bad = ahead(linear(10.0, 2.0)), ahead(linear(-10.0, -2.0))
    assert good.gain.min() > 0.4
    assert bad.gain.max() < 0.0
    assert good.share < 0.1 < 0.9 < bad.share


def test_bounds_of_commands_make_a_good_policy_useless() -> None:
    # At 0.05 rad gravity asks for 19.62 * 0.05 = 0.98 rad/s2, and 0.01 * 5 = 0.05 is allowed.
    weak = replace(trial(), low=np.array([-0.01]), high=np.array([0.01]))
    known = certain(falling(), noise=np.full(2, 1e-3))
    found = foreseen(known, linear(10.0, 2.0), weak, np.random.default_rng(0), draws=4)
    assert np.abs(found.gain).max() < 0.02


def test_doubt_about_the_sign_of_the_command_is_half_a_chance_of_harm() -> None:
    known = certain(falling(0.0), noise=np.full(2, 1e-3))
    root = np.zeros((6, 6))
    # The effect of the command on the speed, and by half a period on the place, of either sign.
    root[2, 5], root[5, 5] = 0.5 * PERIOD * 0.1, 0.1
    unsure = replace(known, root=root)
    found = foreseen(unsure, linear(10.0, 2.0), trial(), np.random.default_rng(0), draws=200)
    # 200 throws of a fair coin: 0.5 within four times 0.5 / sqrt(200) = 0.14.
    assert found.share == pytest.approx(0.5, abs=0.14)


def test_verdicts_follow_the_probability() -> None:
    good, bad = ahead(linear(10.0, 2.0)), ahead(linear(-10.0, -2.0))
    assert judge(good).verdict == "safe"
    assert judge(bad).verdict == "unsafe"
    assert judge(good).probability < judge(bad).probability
    assert judge(good, safe=0.0, unsafe=1.0).verdict == "unsure"


def test_thresholds_out_of_order_are_refused() -> None:
    with pytest.raises(SettingError, match=r"safe is 0\.6 and unsafe 0\.5"):
        judge(ahead(linear(10.0, 2.0)), safe=0.6)


def test_a_trial_whose_starts_do_not_fit_the_outcome_is_refused() -> None:
    with pytest.raises(SettingError, match=r"give starts of as many numbers"):
        replace(trial(), starts=np.zeros((1, 3)))


def test_a_policy_promises_what_was_foreseen_of_it() -> None:
    known = certain(falling(), noise=np.full(2, 1e-3))
    worth = [
        promise(known, linear(gain, 2.0), trial(), np.random.default_rng(0), draws=4)
        for gain in (-10.0, 0.0, 10.0)
    ]
    assert worth[0] < worth[1] < worth[2]


def test_a_shift_of_a_cloud_is_its_distance() -> None:
    # Along a line at an angle a a shift of d in the plane is d cos a, whose mean square is d^2 / 2;
    # all is in spreads. Two clouds of one number each along 2000 lines: within a few hundredths.
    rng = np.random.default_rng(0)
    cloud = rng.standard_normal((500, 2))
    both = np.concatenate([cloud, cloud + np.array([1.0, 0.0])])
    expected = 1.0 / both[:, 0].std() / np.sqrt(2.0)
    found = apart(cloud, cloud + np.array([1.0, 0.0]), rng, lines=2000)
    assert found == pytest.approx(expected, abs=0.03)
    assert apart(cloud, cloud, rng) == pytest.approx(0.0, abs=1e-12)
