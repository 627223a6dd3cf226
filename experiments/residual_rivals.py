"""Models that a simulator with a missing force is compared with, as forecasts."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from morph.arrays import Array
from morph.model.gp.fit import fit
from morph.model.latent.run import Run
from morph.model.missing_force.periods import Periods
from morph.model.transition_gp import fit_map

Simulate = Callable[[Array, Array], Array]
"""From states (rows, n) and commands (rows, nu) to states one control period later, (rows, n)."""

Forecast = Callable[[Array, Array, np.random.Generator], Array]
"""From starts (runs, n), commands (runs, periods, nu) and chance to states (draws, ...)."""

HINGE = 1
"""Which number of a cart-pole's state is an angle."""


def deterministic(periods: Periods, point: Array) -> Simulate:
    """Return a simulator at a point as a function."""
    models = periods.models([point])

    def simulate(state: Array, command: Array) -> Array:
        return periods.within(models, state, command, np.zeros((len(state), periods.nv)))[:, -1]

    return simulate


def gaussian_process(
    runs: Sequence[Run],
    noise: Array,
    simulate: Simulate | None,
    shuffle: np.random.Generator | None,
    *,
    draws: int,
) -> Forecast:
    """Return the usual residual: what a period's observed end misses, each period by itself.

    Source: Deisenroth and Rasmussen 2011, ICML (alone, the state itself being the mean).

    Args:
        runs: What to learn from.
        noise: Standard deviation of the observations, shape (n,).
        simulate: The mean; None for the state as it is.
        shuffle: Chance by which targets are put in another order; None to leave them.
        draws: Possible runs that each forecast is made of.
    """
    mean = simulate or (lambda state, command: state)
    state = np.concatenate([run.state[:-1] for run in runs])
    command = np.concatenate([run.command for run in runs])
    target = np.concatenate([run.state[1:] for run in runs]) - mean(state, command)
    if shuffle is not None:
        target = shuffle.permutation(target)
    learned = fit(_looked(state, command), target)

    def forecast(start: Array, told: Array, rng: np.random.Generator) -> Array:
        now = np.tile(start, (draws, 1)) + noise * rng.normal(size=(draws * len(start), len(noise)))
        found = [now]
        for at in range(told.shape[1]):
            push = np.tile(told[:, at], (draws, 1))
            middle, variance = learned.predict(_looked(now, push))
            chance = np.sqrt(variance) * rng.normal(size=now.shape)
            now = np.clip(mean(now, push) + middle + chance, -1e4, 1e4)
            found.append(now)
        return np.stack(found, axis=1).reshape(draws, len(start), -1, len(noise))

    return forecast


def mapped(runs: Sequence[Run], noise: Array, simulate: Simulate, *, draws: int) -> Forecast:
    """Return the learned map of a closed simulator's predictions."""
    found = fit_map(simulate, runs, noise, angles=(HINGE,))
    return lambda start, command, rng: found.foresee(start, command, rng, draws=draws)


def _looked(state: Array, command: Array) -> Array:
    angle = state[:, HINGE]
    return np.column_stack([np.cos(angle), np.sin(angle), state[:, 2:], command])
