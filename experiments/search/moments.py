"""Moment matching against a million samples, and its gradient's price against particles."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from morph.arrays import JSON
from morph.body.load import load
from morph.model.gp.gp import GaussianProcess
from morph.search.gp_rollout.laws import RadialLaw
from morph.search.gp_rollout.memory import Memory
from morph.search.gp_rollout.particles import Chance, Particles
from morph.search.gp_rollout.radial import scale_of
from morph.search.gp_rollout.rollout import imagine
from morph.search.gp_rollout.task import TaskSums, view_of
from morph.search.mc_pilco import McPilco
from morph.search.moments.moments import ProcessMoments
from morph.search.target import Simulated
from morph.sim.threads import one_thread
from morph.task.tasks import task

PEER = 0.65
"""MC-PILCO's own step of 100 particles on a loaded core, s, as its measurement was handed down."""


def learned(trials: int) -> tuple[TaskSums, Memory, GaussianProcess]:
    """Return what so many trials with random commands show of the cart-pole."""
    wanted = task("swing-up", load("cartpole"))
    target = Simulated(task=wanted, simulator=wanted.simulator())
    search, view, memory = McPilco(), view_of(wanted), Memory()
    rng = np.random.default_rng(100)
    for _ in range(trials):
        memory = memory.after(target.trial(search.random(view, rng), rng))
    return view, memory, search.learned(view, memory)


def errors(view: TaskSums, memory: Memory, process: GaussianProcess, *, samples: int) -> JSON:
    """Return the greatest error of means, in standard deviations, and of variances, relative.

    The inputs are as uncertain as a belief becomes in a swing: a tenth of what was seen.
    """
    inputs, _ = memory.data(view)
    rng = np.random.default_rng(0)
    worst = {"mean": 0.0, "variance": 0.0}
    for at in rng.integers(len(inputs), size=2):
        m, S = inputs[at], np.diag((0.1 * inputs.std(axis=0)) ** 2)
        found, _ = ProcessMoments(process).forward(m, S)
        total, square, own = (np.zeros_like(found.mean) for _ in range(3))
        parts = max(1, samples // 50_000)
        for _ in range(parts):
            x = rng.multivariate_normal(m, S, size=samples // parts)
            y, variance = process.predict(x)
            total, square = total + y.mean(axis=0), square + (y**2).mean(axis=0)
            own = own + variance.mean(axis=0)
        mean = total / parts
        variance = square / parts - mean**2 + own / parts
        off = np.abs(found.mean - mean) / np.sqrt(variance)
        worst["mean"] = max(worst["mean"], float(off.max()))
        wide = np.abs(np.diag(found.covariance) / variance - 1.0)
        worst["variance"] = max(worst["variance"], float(wide.max()))
    return worst


def steps(view: TaskSums, memory: Memory, process: GaussianProcess, *, repeats: int) -> JSON:
    """Return the time of one gradient step by moments and by 100 particles, by turns, s."""
    rng = np.random.default_rng(1)
    m, S = view.start
    plant = view.plant(process)
    scale = scale_of(view, memory, 30)
    vector = scale.drawn(rng)
    law = RadialLaw(scale.numbers(vector))
    bunch = Particles(view, process, scale)
    chance = Chance.drawn(view, 100, rng)
    periods = view.task.samples - 1
    ways: dict[str, Callable[[], object]] = {
        "moments": lambda: imagine(plant, law, view.costs, m, S, periods),
        "particles": lambda: bunch.gradient(vector, chance),
    }
    taken: dict[str, list[float]] = {name: [] for name in ways}
    with one_thread():
        for _ in range(repeats + 1):
            for name, way in ways.items():
                began = time.process_time()
                way()
                taken[name].append(time.process_time() - began)
    # The first of each also made what is kept.
    return {name: float(np.median(each[1:])) for name, each in taken.items()}


def measured(*, quick: bool) -> JSON:
    """Return the figures for two and three trials of data."""
    found: JSON = {}
    for trials in (1,) if quick else (2, 3):
        view, memory, process = learned(trials)
        samples = 20_000 if quick else 1_000_000
        found[str(len(process.inputs))] = {
            **errors(view, memory, process, samples=samples),
            **steps(view, memory, process, repeats=2 if quick else 15),
        }
    return found


def report(found: JSON) -> None:
    """Print the figures."""
    for data, row in found.items():
        print(
            f"moments, {data} data: means off by {row['mean']:.2%} of a standard deviation, "
            f"variances by {row['variance']:.2%}; a gradient step takes "
            f"{1e3 * row['moments']:.0f} ms of a core, {PEER / row['moments']:.1f} times less than "
            f"MC-PILCO's {PEER} s and {row['particles'] / row['moments']:.1f} times less than our "
            f"own 100 particles ({1e3 * row['particles']:.0f} ms)"
        )
