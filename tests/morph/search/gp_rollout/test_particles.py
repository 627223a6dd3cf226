"""Particles against finite differences, against one body without chance, and against moments."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from morph.arrays import Array
from morph.body.load import load
from morph.errors import SearchError
from morph.model.gp.gp import GaussianProcess
from morph.search.gp_rollout.laws import RadialLaw
from morph.search.gp_rollout.memory import Memory
from morph.search.gp_rollout.particles import Chance, Particles
from morph.search.gp_rollout.radial import RadialScale, radial_of, scale_of
from morph.search.gp_rollout.rollout import imagine
from morph.search.gp_rollout.task import TaskSums, view_of
from morph.search.mc_pilco import McPilco, adam
from morph.search.search import Problem
from morph.search.target import Simulated
from morph.task.tasks import task


@pytest.fixture(scope="module")
def known() -> tuple[TaskSums, GaussianProcess, RadialScale]:
    """What a trial with random commands shows of the cart-pole."""
    wanted = task("swing-up", load("cartpole"))
    target = Simulated(task=wanted, simulator=wanted.simulator())
    rng, view, memory = np.random.default_rng(100), view_of(wanted), Memory()
    search = McPilco(units=10)
    memory = memory.after(target.trial(search.random(view, rng), rng))
    return view, search.learned(view, memory), scale_of(view, memory, search.units)


def test_the_gradient_is_that_of_finite_differences(
    known: tuple[TaskSums, GaussianProcess, RadialScale],
) -> None:
    view, process, scale = known
    rng = np.random.default_rng(1)
    bunch, chance = Particles(view, process, scale), Chance.drawn(view, 20, rng)
    vector = scale.drawn(rng)
    vector[-scale.units :] *= 3.0
    _, slope = bunch.gradient(vector, chance)
    for _ in range(3):
        way = rng.standard_normal(len(vector))
        h = 1e-5

        def at(share: float, way: Array = way) -> float:
            with torch.no_grad():
                return float(bunch.loss(torch.from_numpy(vector + share * way), chance))

        # Centred differences err by h^2 and by rounding, 60 * 1e-13 / h: 1e-6 of slopes near 1.
        assert slope @ way == pytest.approx((at(h) - at(-h)) / (2.0 * h), rel=1e-3, abs=1e-4)


def test_without_chance_a_particle_is_the_mean_stepped_by_hand(
    known: tuple[TaskSums, GaussianProcess, RadialScale],
) -> None:
    view, process, scale = known
    rng = np.random.default_rng(2)
    vector = scale.drawn(rng)
    none = Chance(
        start=torch.zeros((1, 4), dtype=torch.float64),
        velocity=torch.zeros((60, 1, 2), dtype=torch.float64),
        seen=torch.zeros((60, 1, 4), dtype=torch.float64),
    )
    with torch.no_grad():
        found = float(Particles(view, process, scale).loss(torch.from_numpy(vector), none))
    policy = radial_of(view, scale.numbers(vector))
    x, total = view.start[0].copy(), 0.0
    for at in range(61):
        tip = np.array([x[0] + 0.5 * np.sin(x[1]), -0.5 * np.cos(x[1]) - 0.5])
        total += 1.0 - np.exp(-(tip @ tip) / (2.0 * 0.25**2))
        u = policy.act(x, np.array(0.05 * at))
        inputs = np.concatenate([view.lifted(x), u])[view.looks]
        change = process.mean(inputs[None])[0]
        x[:2] += 0.05 * (x[2:] + change / 2.0)
        x[2:] += change
    # The same sums in another order, through 60 steps that double an error at most.
    assert found == pytest.approx(total, rel=1e-8)


def test_their_mean_loss_is_near_that_of_moment_matching(
    known: tuple[TaskSums, GaussianProcess, RadialScale],
) -> None:
    view, process, scale = known
    rng = np.random.default_rng(3)
    vector = scale.drawn(rng)
    short = 5
    chance = Chance.drawn(view, 4000, rng)
    chance = Chance(start=chance.start, velocity=chance.velocity[:short], seen=chance.seen[:short])
    with torch.no_grad():
        found = float(Particles(view, process, scale).loss(torch.from_numpy(vector), chance))
    m, S = view.start
    law = RadialLaw(scale.numbers(vector))
    expected = float(imagine(view.plant(process), law, view.costs, m, S, short).loss)
    # Six samples of a loss near 1 each, of which 4000 particles know the mean to 1e-3.
    assert found == pytest.approx(expected, rel=5e-3)


def test_a_search_improves_what_it_believes_and_goes_on_after_a_kill() -> None:
    wanted = task("swing-up", load("cartpole"))
    problem = Problem(task=wanted, target=Simulated(task=wanted, simulator=wanted.simulator()))
    search = McPilco(units=8, particles=20, steps=6, starts=2)
    states = []
    whole = search.run(
        problem, seed=101, trials=2, progress=lambda trial, state: states.append(dict(state))
    )
    resumed = search.run(problem, seed=101, trials=2, state=states[1])
    assert [trial.number for trial in whole.trials] == [0, 1, 2]
    assert resumed.trials[-1].loss == whole.trials[-1].loss
    assert whole.trials[-1].experience == pytest.approx(9.0)


def test_settings_that_make_no_sense_are_refused() -> None:
    with pytest.raises(SearchError, match="0 particles"):
        McPilco(particles=0)


def test_under_a_slope_that_stays_every_step_of_adam_is_one() -> None:
    # Moments corrected for their start are g and g^2 whenever the slope always was g, so that
    # every change is g / |g|. Without any slope nothing changes.
    slope = torch.tensor([3.0, -0.02, 0.0], dtype=torch.float64)
    first, second = torch.zeros_like(slope), torch.zeros_like(slope)
    for step in range(10):
        first, second, change = adam(first, second, slope, step)
        # The 1e-8 beside |g| = 0.02 takes 5e-7 of a step.
        assert torch.allclose(change, torch.sign(slope), atol=1e-6)
    _, _, change = adam(torch.zeros(2), torch.zeros(2), None, 0)
    assert not change.any()
