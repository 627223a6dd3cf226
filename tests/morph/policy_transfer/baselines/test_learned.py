"""What rivals learn from runs of laws that are known in closed form."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest
import torch

from morph.arrays import Array
from morph.model.jointed.jointed import Jointed
from morph.policy_transfer.baselines.alone import Alone
from morph.policy_transfer.baselines.carried import Carried
from morph.policy_transfer.baselines.ladder import share_expected
from morph.policy_transfer.baselines.learner import Learner, told
from morph.policy_transfer.baselines.pooled import Pooled
from morph.policy_transfer.baselines.prior import SourcePrior
from morph.policy_transfer.baselines.source import Source
from morph.search.learned_dynamics.memory import SearchCheckpoint
from morph.search.target import Experience
from morph.sim.threads import one_thread

Made = Callable[..., Experience]


def weak(q: Array, v: Array, u: Array) -> Array:
    return 5.0 * u - 0.5 * v


def strong(q: Array, v: Array, u: Array) -> Array:
    return 15.0 * u - 0.5 * v


def pushed(model: Jointed) -> float:
    """Return by how much a command of 0.5 more accelerates, by the mean of a model."""
    still = torch.zeros(2, 1, dtype=torch.float64)
    a = model.mean(still, still, torch.tensor([[-0.25], [0.25]], dtype=torch.float64))
    return float(a[1] - a[0])


def learned(rival: Learner, source: Source, made: Made) -> Jointed:
    """Return what a rival learns, the source being weak and the target strong."""
    lent = replace(source, experience=(made(weak, seed=1),))
    memory = SearchCheckpoint(experience=(made(strong, seed=2),))
    return rival.learned(lent, memory, told(source.task))


@pytest.fixture(scope="module")
def alone(source: Source, made: Made) -> Jointed:
    with one_thread():
        return learned(Alone(), source, made)


@pytest.fixture(scope="module")
def pooled(source: Source, made: Made) -> Jointed:
    with one_thread():
        return learned(Pooled(), source, made)


def test_the_target_alone_shows_its_own_law(alone: Jointed) -> None:
    # 15 * 0.5 = 7.5; noise of 0.01 in velocities over 0.05 s is 0.3 in an acceleration of
    # spread 15 / sqrt(3) = 8.7, and 60 periods leave 0.04 of it.
    assert pushed(alone) == pytest.approx(7.5, abs=0.4)


def test_pooled_data_show_the_mean_of_both_laws(pooled: Jointed) -> None:
    # Between 2.5 and 7.5, and neither: the same commands were seen to do both.
    assert 3.5 < pushed(pooled) < 6.5


def test_pooled_data_take_the_difference_for_noise(alone: Jointed, pooled: Jointed) -> None:
    # Half the difference, 5 u, has a spread of 5 / sqrt(3) = 2.9: as noise of a velocity,
    # 2.9 * 0.05 / sqrt(2) = 0.1, ten times what was there.
    assert alone.velocity_noise[0] < 0.02
    assert pooled.velocity_noise[0] > 3.0 * alone.velocity_noise[0]


def test_a_sample_of_the_target_replaces_the_sources_nearby(
    source: Source, made: Made, alone: Jointed
) -> None:
    # All of the source's samples are near: none is left.
    assert pushed(learned(Carried(near=100.0), source, made)) == pushed(alone)


def test_samples_are_kept_where_the_target_was_not(
    source: Source, made: Made, pooled: Jointed
) -> None:
    # No sample is replaced: what is learned is what pooled data say.
    kept = learned(Carried(near=0.0), source, made)
    assert pushed(kept) == pytest.approx(pushed(pooled), rel=0.05)


def test_where_the_target_was_seen_a_wrong_prior_gives_way(source: Source, made: Made) -> None:
    model = learned(SourcePrior(), source, made)
    assert model.base is not None
    assert pushed(model) == pytest.approx(7.5, abs=0.6)


def test_a_run_of_the_same_law_is_expected_and_one_of_another_is_not(
    source: Source, made: Made, alone: Jointed
) -> None:
    same = share_expected([alone], made(strong, seed=3), source.task)
    other = share_expected([alone], made(weak, seed=3), source.task)
    # 3 standard deviations hold 99.7 % of a Gaussian.
    assert same > 0.9
    assert other < 0.5
