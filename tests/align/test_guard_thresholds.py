"""What probabilities the guard calls safe, and the law from what was foreseen to a probability."""

from __future__ import annotations

import numpy as np
import pytest

from morph.alignment.guard import LEAST, PredictedScores, TrialTask, foreseen, judge
from morph.alignment.metric import certain


def alike(ratio: float) -> PredictedScores:
    """Return scores on nine bodies that all have one logarithm of the ratio of scores."""
    still = np.full(9, 0.2)
    return PredictedScores(score=still * np.exp(ratio) - LEAST, still=still - LEAST)


def probability(ratio: float, share: float) -> float:
    """Return the law of docs/guard.md where lowest tenth, middle and highest tenth are alike."""
    score = -0.37 + 0.44 * np.log(share / (1.0 - share)) + (-0.88 - 1.03 + 0.35) * ratio
    return float(1.0 / (1.0 + np.exp(-score)))


def ratio_for(wanted: float, share: float) -> float:
    """Return the ratio at which the law gives a probability."""
    odds = np.log(wanted / (1.0 - wanted))
    return float((odds + 0.37 - 0.44 * np.log(share / (1.0 - share))) / (-0.88 - 1.03 + 0.35))


# None of nine bodies is harmed: (0 + 0.5) / (9 + 1) = 0.05.
@pytest.mark.parametrize(
    ("wanted", "verdict"),
    [(0.01, "safe"), (0.045, "safe"), (0.055, "unsure"), (0.15, "unsure")],
)
def test_a_policy_is_safe_up_to_one_chance_in_twenty_of_harm(wanted: float, verdict: str) -> None:
    found = alike(ratio_for(wanted, 0.05))
    assert found.gain.min() > 0.0
    assert found.share == pytest.approx(0.05)
    told = judge(found)
    assert told.probability == pytest.approx(wanted, abs=1e-9)
    assert told.verdict == verdict


@pytest.mark.parametrize(("share", "verdict"), [(0.25, "unsure"), (0.75, "unsafe")])
def test_a_policy_is_unsafe_from_an_even_chance_on(share: float, verdict: str) -> None:
    # Scores so near that their ratio says nothing; a hair decides which bodies are harmed.
    harmed = round(share * 10 - 0.5)
    gain = np.where(np.arange(9) < harmed, -1e-12, 1e-12)
    still = np.full(9, 0.2)
    found = PredictedScores(score=still + gain, still=still)
    assert found.share == pytest.approx((harmed + 0.5) / 10.0)
    told = judge(found)
    assert told.probability == pytest.approx(probability(0.0, found.share), abs=1e-9)
    assert told.verdict == verdict


def test_lowest_middle_and_highest_tenth_stand_in_this_order() -> None:
    # Eleven bodies: the tenths are the second, the sixth and the tenth of them.
    ratio = np.linspace(-0.5, 1.5, 11)
    still = np.full(11, 0.2)
    found = PredictedScores(score=(still + LEAST) * np.exp(ratio) - LEAST, still=still)
    # Those at -0.5, -0.3 and -0.1 are harmed.
    share = (3 + 0.5) / 12.0
    expected = [1.0, np.log(share / (1.0 - share)), 0.5, -0.3, 1.3]
    assert found.features == pytest.approx(np.array(expected))


def test_a_bad_lowest_tenth_makes_harm_likelier_than_a_good_one() -> None:
    still = np.full(11, 0.2)
    low, high = still.copy(), still.copy()
    low[:2], high[:2] = 0.21, 0.6
    rest = np.full(9, 0.8)
    bad = PredictedScores(score=np.concatenate([low[:2], rest]), still=still)
    good = PredictedScores(score=np.concatenate([high[:2], rest]), still=still)
    assert judge(bad).probability > judge(good).probability


def test_a_policy_acts_on_readings_with_their_noise_as_a_random_walk_does() -> None:
    # Told to stay where it reads that it is, a body walks by the noise of each reading: after t
    # periods it is N(0, 0.09 t), and the mean of exp(-x^2 / 2) is 1 / sqrt(1 + 0.09 t).
    known = certain(np.array([[0.0, 1.0]]), noise=np.array([0.3]))
    trial = TrialTask(
        outcome=np.array([[1.0], [0.0]]),
        starts=np.zeros((1, 1)),
        low=np.array([-9.0]),
        high=np.array([9.0]),
        periods=20,
        period=0.05,
    )
    found = foreseen(known, lambda x, time: x, trial, np.random.default_rng(0), draws=4000)
    expected = float(np.mean(1.0 / np.sqrt(1.0 + 0.09 * np.arange(20))))
    # Four standard errors, at most 4 * 0.35 / sqrt(4000) = 0.022, and at most 2 % of the walks
    # are lost beyond 3.1, which is 2.4 deviations of the longest.
    assert found.score.mean() == pytest.approx(expected, abs=0.03)
    assert expected < 0.8
    assert found.still.mean() == pytest.approx(1.0, abs=1e-12)
