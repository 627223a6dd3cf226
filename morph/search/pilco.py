"""PILCO: a policy improved by the gradient of its expected loss on what is believed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.optimize import minimize

from morph.arrays import Array
from morph.model.gp.gp import GaussianProcess
from morph.policy.radial import Radial
from morph.search.gp_rollout.laws import RadialLaw
from morph.search.gp_rollout.memory import Memory
from morph.search.gp_rollout.radial import RadialScale, radial_of, scale_of
from morph.search.gp_rollout.rollout import imagine
from morph.search.gp_rollout.search import BeliefSearch, Improved
from morph.search.gp_rollout.task import TaskSums


@dataclass(frozen=True, kw_only=True)
class Pilco(BeliefSearch):
    """Radial basis functions, improved by L-BFGS on the analytic gradient.

    Source: Deisenroth and Rasmussen 2011, PILCO: A Model-Based and Data-Efficient Approach to
    Policy Search, ICML, algorithm 1; with one length for all basis functions of a feature.
    """

    name: ClassVar[str] = "pilco"
    kind = Radial

    units: int = 30
    """Basis functions."""
    steps: int = 100
    """Most steps of the search for a better policy, after each trial."""
    short: int = 25
    """Steps after which the best of several starts is chosen."""
    starts: int = 2
    """Policies from which each search begins: the one before, and others by chance."""

    def improved(
        self, view: TaskSums, process: GaussianProcess, memory: Memory, rng: np.random.Generator
    ) -> Improved:
        """Return the policy of the least expected loss that was found."""
        plant, (m, S) = view.plant(process), view.start
        periods = view.task.samples - 1
        scale = scale_of(view, memory, self.units)

        def cost(numbers: Array) -> tuple[float, Array]:
            law = RadialLaw(scale.numbers(numbers))
            result = imagine(plant, law, view.costs, m, S, periods)
            return float(result.loss), result.gradient * scale.slope

        begun = [scale.packed(memory.numbers)] if memory.numbers is not None else []
        while len(begun) < self.starts:
            begun.append(scale.drawn(rng))
        tried = [_descended(cost, start, scale, self.short) for start in begun]
        best = min(tried, key=lambda run: run[0])
        value, numbers = _descended(cost, best[1], scale, self.steps)
        result = scale.numbers(numbers)
        return Improved(
            policy=radial_of(view, result), numbers=scale.unpacked(numbers), expected=value
        )


def _descended(
    cost: Callable[[Array], tuple[float, Array]], start: Array, scale: RadialScale, steps: int
) -> tuple[float, Array]:
    """Return the least cost that L-BFGS finds in so many steps, and where."""
    run = minimize(
        cost,
        np.clip(start, *np.array(scale.bounds).T),
        jac=True,
        method="L-BFGS-B",
        bounds=scale.bounds,
        options={"maxiter": steps, "maxfun": 2 * steps, "maxcor": 20},
    )
    return float(run.fun), np.asarray(run.x)
