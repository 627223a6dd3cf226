"""What trials say of each other: held against the conditional of a Gaussian."""

import numpy as np
import pytest

from morph.policy_transfer.gait.landscape import NOISE, PRIOR, SCALE, Landscape


@pytest.fixture
def trials() -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(0)
    point = rng.random((12, 4))
    return point, np.sin(3.0 * point[:, 0]) * point[:, 1]


def test_it_is_the_posterior_of_a_gaussian(trials: tuple[np.ndarray, np.ndarray]) -> None:
    point, share = trials
    asked = np.random.default_rng(1).random((20, 4))
    every = np.concatenate([asked, point])
    # Rasmussen and Williams 2006, eq. 2.25 and 2.26, written out: of jointly Gaussian values some
    # are read with noise.
    apart = ((every[:, None] - every) ** 2).sum(axis=2)
    joint = PRIOR**2 * np.exp(-0.5 * apart / SCALE**2)
    gain = np.linalg.solve(joint[20:, 20:] + NOISE**2 * np.eye(12), joint[20:, :20]).T
    spread = np.sqrt(np.diag(joint[:20, :20] - gain @ joint[20:, :20]))
    known = Landscape(point=point, share=share)
    np.testing.assert_allclose(known.mean(asked), gain @ share, atol=1e-9)
    np.testing.assert_allclose(known.spread(asked), spread, atol=1e-6)


def test_without_a_trial_the_prior_stands() -> None:
    none = Landscape(point=np.zeros((0, 4)), share=np.zeros(0))
    asked = np.random.default_rng(1).random((20, 4))
    assert none.mean(asked) == pytest.approx(np.zeros(20), abs=1e-15)
    assert none.spread(asked) == pytest.approx(np.full(20, PRIOR), abs=1e-12)


def test_far_from_every_trial_what_was_foreseen_stands(
    trials: tuple[np.ndarray, np.ndarray],
) -> None:
    point, share = trials
    before = Landscape(point=point, share=share)
    after = Landscape(point=np.full((1, 4), 30.0), share=np.array([0.7]), foreseen=before)
    np.testing.assert_allclose(after.mean(point), before.mean(point), atol=1e-9)
    # One trial of prior 0.3 and noise 0.02 is believed to 0.09 / (0.09 + 0.0004) = 0.9956.
    assert after.mean(np.full((1, 4), 30.0)) == pytest.approx(0.7 * 0.9956, abs=1e-4)


def test_what_promises_most_is_drawn_by_sampling(trials: tuple[np.ndarray, np.ndarray]) -> None:
    point, share = trials
    known = Landscape(point=point, share=share)
    asked = np.random.default_rng(2).random((5, 4))
    draws = known.mean(asked) + known.spread(asked) * np.random.default_rng(3).standard_normal(
        (200_000, 5)
    )
    sampled = np.maximum(draws - share.max(), 0.0).mean(axis=0)
    # The standard error of a mean of 200,000 draws below 0.3 is below 0.001.
    np.testing.assert_allclose(known.promise(asked), sampled, atol=3e-3)
