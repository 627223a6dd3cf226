"""The filter's likelihood is that of one normal distribution over all samples at once."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from morph.arrays import Array
from morph.model.ou_likelihood import likelihood

PERIOD = 0.1
NOISE = np.array([0.02, 0.05, 0.03, 0.04])


def _dense(
    miss: Array, carry: Array, leak: Array, scale: Array, length: float, periods: int
) -> float:
    """Return the log density of all samples of two degrees of freedom, written out."""
    # delta(t) is linear in delta(0), in a(0..t-1) and in the leaks: unrolled, column by column.
    n, m = 4, 2
    times = PERIOD * np.arange(periods)
    kernel = np.exp(-np.abs(times[:, None] - times) / length)
    push = np.concatenate([0.5 * PERIOD**2 * np.eye(m), PERIOD * np.eye(m)])
    mean = np.zeros(n)
    first = np.eye(n)
    forces = np.zeros((n, periods, m))
    leaks = np.zeros((n, periods, n))
    means, rows = [], []
    for t in range(periods):
        mean = carry[t] @ mean + miss[t]
        first = carry[t] @ first
        forces = np.einsum("ij,jtm->itm", carry[t], forces)
        forces[:, t] += push
        leaks = np.einsum("ij,jtm->itm", carry[t], leaks)
        leaks[:, t] += np.eye(n)
        means.append(mean)
        rows.append((first, forces, leaks))
    first = np.concatenate([row[0] for row in rows])
    forces = np.concatenate([row[1] for row in rows])
    leaks = np.concatenate([row[2] for row in rows])
    spread = first @ np.diag(NOISE**2) @ first.T
    spread += np.einsum("itm,ts,jsm,m->ij", forces, kernel, forces, scale**2)
    spread += np.einsum("itm,jtm,tm->ij", leaks, leaks, leak)
    spread += np.diag(np.tile(NOISE**2, periods))
    return float(multivariate_normal(np.concatenate(means), spread).logpdf(np.zeros(n * periods)))


@pytest.mark.parametrize(("scale", "length"), [(0.0, 1.0), (0.7, 0.15), (2.0, 5.0)])
def test_it_is_the_density_of_all_samples_under_a_gaussian_process_over_time(
    scale: float, length: float
) -> None:
    rng = np.random.default_rng(3)
    periods = 7
    carry = np.eye(4) + 0.2 * rng.normal(size=(2, periods, 4, 4))
    miss = 0.1 * rng.normal(size=(2, periods, 4))
    leak = 1e-3 * rng.uniform(size=(2, periods, 4))
    scales = np.array([[scale, 0.5 * scale], [0.3, 0.0]])
    doubt = 0.1 * rng.normal(size=(2, periods, 4, 3))
    found = likelihood(
        miss,
        carry,
        doubt=doubt,
        noise=NOISE,
        leak=leak,
        scale=scales,
        length=np.array([length, 0.4]),
        period=PERIOD,
    )
    assert found.base.shape == (2, 2, periods)
    whole, theta = found.until(periods), rng.normal(size=3)
    for model in range(2):
        for setting, duration in enumerate((length, 0.4)):
            at = (model, setting)
            of = (carry[model], leak[model], scales[setting], duration, periods)
            # 28 numbers; both sides round at 1e-16 times a condition number below 1e6.
            assert whole.base[at] == pytest.approx(_dense(miss[model], *of), abs=1e-7)
            told = whole.base[at] + whole.slope[at] @ theta - 0.5 * theta @ whole.curve[at] @ theta
            moved = miss[model] + doubt[model] @ theta
            assert told == pytest.approx(_dense(moved, *of), abs=1e-7)


def test_a_sample_does_not_hang_on_those_after_it() -> None:
    rng = np.random.default_rng(4)
    miss = 0.1 * rng.normal(size=(1, 9, 2))
    carry = np.broadcast_to(np.array([[1.0, PERIOD], [0.0, 1.0]]), (1, 9, 2, 2))

    def density(periods: int) -> Array:
        return likelihood(
            miss[:, :periods],
            carry[:, :periods],
            doubt=np.zeros((1, periods, 2, 0)),
            noise=np.array([0.02, 0.05]),
            leak=np.zeros((1, periods, 2)),
            scale=np.array([[0.5]]),
            length=np.array([1.0]),
            period=PERIOD,
        ).base

    assert density(9)[..., :4] == pytest.approx(density(4), abs=1e-12)
