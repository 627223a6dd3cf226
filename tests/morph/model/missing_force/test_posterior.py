from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from morph.arrays import Array
from morph.model.missing_force.periods import PeriodSlopes
from morph.model.missing_force.posterior import Reduced, reduced

PERIODS, N, JOINTS, SIZE = 5, 4, 2, 3


@pytest.fixture
def slopes() -> PeriodSlopes:
    rng = np.random.default_rng(3)
    return PeriodSlopes(
        state=rng.normal(size=(PERIODS + 1, N)),
        missed=rng.normal(size=(PERIODS, N)),
        of_state=np.eye(N) + 0.2 * rng.normal(size=(PERIODS, N, N)),
        of_point=rng.normal(size=(PERIODS, N, SIZE)),
        of_force=rng.normal(size=(PERIODS, N, JOINTS)),
        inside=np.zeros((PERIODS, 1, N)),
        point=rng.normal(size=SIZE),
        force=rng.normal(size=(PERIODS, JOINTS)),
    )


NOISE = np.array([0.3, 0.5, 0.4, 0.7])
JUMP = np.array([0.02, 0.05, 0.04, 0.03])


def _seen(slopes: PeriodSlopes) -> Array:
    return slopes.state + np.random.default_rng(4).normal(size=slopes.state.shape)


def _log_likelihood(slopes: PeriodSlopes, seen: Array, h: Array) -> float:
    """Return log p(y_1 .. y_T | y_0, h) as one normal distribution, states never appearing.

    The first state has no prior, so that given y_0 it is normal about it with the noise.
    """
    force = h[SIZE:].reshape(PERIODS, JOINTS)
    mean, cov = [seen[0]], np.diag(NOISE**2)
    whole = np.zeros(((PERIODS + 1) * N,) * 2)
    whole[:N, :N] = cov
    for t in range(PERIODS):
        A = slopes.of_state[t]
        end = slopes.state[t + 1] - slopes.missed[t]
        end = end + A @ (mean[-1] - slopes.state[t])
        end = end + slopes.of_point[t] @ (h[:SIZE] - slopes.point)
        mean.append(end + slopes.of_force[t] @ (force[t] - slopes.force[t]))
        a, b, c = t * N, (t + 1) * N, (t + 2) * N
        whole[b:c, :b] = A @ whole[a:b, :b]
        whole[:b, b:c] = whole[b:c, :b].T
        whole[b:c, b:c] = A @ whole[a:b, a:b] @ A.T + np.diag(JUMP)
    covariance = whole[N:, N:] + np.diag(np.tile(NOISE**2, PERIODS))
    return float(multivariate_normal.logpdf(seen[1:].ravel(), np.concatenate(mean[1:]), covariance))


def _minus_twice(part: Reduced, h: Array) -> float:
    return part.information.missed(h)


def test_the_states_taken_out_leave_the_likelihood_of_one_big_normal(slopes: PeriodSlopes) -> None:
    seen = _seen(slopes)
    part = reduced(slopes, seen, NOISE, JUMP)
    rng = np.random.default_rng(5)
    # Ours leaves out the constant of T n normal numbers.
    constant = PERIODS * N * np.log(2.0 * np.pi)
    for _ in range(3):
        h = rng.normal(size=SIZE + PERIODS * JOINTS)
        ours = -0.5 * (_minus_twice(part, h) + constant)
        assert ours == pytest.approx(_log_likelihood(slopes, seen, h), rel=1e-9)


def test_the_likeliest_states_have_no_gradient(slopes: PeriodSlopes) -> None:
    seen = _seen(slopes)
    h = np.random.default_rng(6).normal(size=SIZE + PERIODS * JOINTS)
    off = reduced(slopes, seen, NOISE, JUMP).states(h).reshape(PERIODS + 1, N)
    force = h[SIZE:].reshape(PERIODS, JOINTS)

    def cost(x: Array) -> float:
        move = x - slopes.state
        jump = slopes.missed + move[1:] - np.einsum("tij,tj->ti", slopes.of_state, move[:-1])
        jump = jump - slopes.of_point @ (h[:SIZE] - slopes.point)
        jump = jump - np.einsum("tij,tj->ti", slopes.of_force, force - slopes.force)
        return float((((seen - x) / NOISE) ** 2).sum() + (jump**2 / JUMP).sum())

    best = slopes.state + off
    for t in range(PERIODS + 1):
        for at in range(N):
            step = np.zeros_like(best)
            step[t, at] = 1e-4
            # The cost is quadratic: centred differences are exact but for rounding, 1e-16 * 1e4
            # over 1e-4.
            assert cost(best + step) - cost(best - step) == pytest.approx(0.0, abs=1e-8)


def test_forces_of_features_are_seen_through_them(slopes: PeriodSlopes) -> None:
    seen = _seen(slopes)
    part = reduced(slopes, seen, NOISE, JUMP)
    rng = np.random.default_rng(7)
    features, weight = rng.normal(size=(PERIODS, JOINTS, 6)), rng.normal(size=(JOINTS, 6))
    p = rng.normal(size=SIZE)
    told = part.through(features)
    w = np.concatenate([p, weight.ravel()])
    h = np.concatenate([p, (features * weight).sum(-1).ravel()])
    assert told.missed(w) == pytest.approx(_minus_twice(part, h))
