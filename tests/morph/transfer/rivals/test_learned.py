"""What rivals learn from runs of laws that are known in closed form."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest
import torch

from morph.arrays import Array
from morph.model.jointed.jointed import Jointed
from morph.search.dream.memory import Memory
from morph.search.target import Experience
from morph.transfer.rivals.alone import Alone
from morph.transfer.rivals.carried import Carried
from morph.transfer.rivals.ladder import share_expected
from morph.transfer.rivals.learner import Learner, told
from morph.transfer.rivals.pooled import Pooled
from morph.transfer.rivals.prior import Prior
from morph.transfer.rivals.source import Source

Made = Callable[..., Experience]


def weak(q: Array, v: Array, u: Array) -> Array:
    return 5.0 * u - 0.5 * v


def strong(q: Array, v: Array, u: Array) -> Array:
    return 15.0 * u - 0.5 * v


def pushed(model: Jointed, *, fast: float = 0.0) -> float:
    """Return by how much a command of 0.5 more accelerates, by the mean of a model."""
    q, v = torch.zeros(2, 1, dtype=torch.float64), torch.full((2, 1), fast, dtype=torch.float64)
    a = model.mean(q, v, torch.tensor([[-0.25], [0.25]], dtype=torch.float64))
    return float(a[1] - a[0])


def learned(rival: Learner, source: Source, made: Made, *, fast: float = 0.0) -> Jointed:
    """Return what a rival learns, the source being weak and the target strong."""
    lent = replace(source, experience=(made(weak, seed=1),))
    memory = Memory(experience=(made(strong, seed=2, fast=fast),))
    return rival.learned(lent, memory, told(source.task))


def test_the_target_alone_shows_its_own_law(source: Source, made: Made) -> None:
    # 15 * 0.5 = 7.5; noise of 0.01 in velocities over 0.05 s is 0.3 in an acceleration of
    # spread 15 / sqrt(3) = 8.7, and 60 periods leave 0.04 of it.
    assert pushed(learned(Alone(), source, made)) == pytest.approx(7.5, abs=0.4)


def test_pooled_data_show_the_mean_of_both_laws(source: Source, made: Made) -> None:
    model = learned(Pooled(), source, made)
    # Between 2.5 and 7.5, and neither: the same commands were seen to do both.
    assert 3.5 < pushed(model) < 6.5


def test_pooled_data_take_the_difference_for_noise(source: Source, made: Made) -> None:
    noise = [learned(rival, source, made).velocity_noise[0] for rival in (Alone(), Pooled())]
    # Half the difference, 5 u, has a spread of 5 / sqrt(3) = 2.9: as noise of a velocity,
    # 2.9 * 0.05 / sqrt(2) = 0.1, ten times what was there.
    assert noise[0] < 0.02
    assert noise[1] > 3.0 * noise[0]


def test_a_sample_of_the_target_replaces_the_sources_nearby(source: Source, made: Made) -> None:
    # All of the source's samples are near: none is left.
    near = learned(Carried(near=100.0), source, made)
    assert pushed(near) == pushed(learned(Alone(), source, made))


def test_samples_are_kept_where_the_target_was_not(source: Source, made: Made) -> None:
    # No sample is replaced: what is learned is what pooled data say.
    kept = learned(Carried(near=0.0), source, made)
    pooled = learned(Pooled(), source, made)
    assert pushed(kept) == pytest.approx(pushed(pooled), rel=0.05)


def test_a_prior_is_believed_until_the_target_shows_otherwise(source: Source, made: Made) -> None:
    model = learned(Prior(), source, made)
    assert model.base is not None
    # Where the target was seen, its own law holds whatever was believed before.
    assert pushed(model) == pytest.approx(7.5, abs=0.6)


def test_a_run_of_the_same_law_is_expected_and_one_of_another_is_not(
    source: Source, made: Made
) -> None:
    model = learned(Alone(), source, made)
    same = share_expected([model], made(strong, seed=3), source.task)
    other = share_expected([model], made(weak, seed=3), source.task)
    # 3 standard deviations hold 99.7 % of a Gaussian.
    assert same > 0.9
    assert other < 0.5
