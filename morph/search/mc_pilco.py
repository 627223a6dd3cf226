"""MC-PILCO: a policy improved by the gradient of its mean loss over particles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import torch

from morph.arrays import Array
from morph.errors import SearchError
from morph.model.gp.gp import GaussianProcess
from morph.policy.radial import Radial
from morph.search.gp_rollout.memory import Memory
from morph.search.gp_rollout.particles import Chance, Particles
from morph.search.gp_rollout.radial import radial_of, scale_of
from morph.search.gp_rollout.search import BeliefSearch, Improved
from morph.search.gp_rollout.task import TaskSums

SMALLEST_SHARE = 0.1
"""Share of the step size that is left at the last step."""


@dataclass(frozen=True, kw_only=True)
class McPilco(BeliefSearch):
    """Radial basis functions, improved by Adam on particles that are drawn anew each step.

    Source: Amadio and others 2022, IEEE T-RO 38(6), algorithm 1, with kernels of one kind, no
    dropout, and steps that shrink as a cosine instead of by watching the loss.
    """

    name: ClassVar[str] = "mc-pilco"
    kind = Radial

    units: int = 50
    """Basis functions."""
    particles: int = 100
    """Particles."""
    steps: int = 200
    """Steps of Adam after each trial."""
    size: float = 0.05
    """First step, in the units of the policy's numbers."""
    starts: int = 8
    """Policies by chance that are looked at before the best of them is improved."""

    def __post_init__(self) -> None:
        """Check the settings."""
        super().__post_init__()
        least = min(self.units, self.particles, self.steps, self.starts)
        if least < 1 or not 0.0 < self.size <= 1.0:
            raise SearchError(
                f"it has {self.units} units, {self.particles} particles, {self.steps} steps of "
                f"{self.size:g} and {self.starts} starts",
                where=f"search {self.name}",
                fix="give 1 or more of each, and a step size above 0 and at most 1",
            )

    def improved(
        self, view: TaskSums, process: GaussianProcess, memory: Memory, rng: np.random.Generator
    ) -> Improved:
        """Return the policy after the steps."""
        scale = scale_of(view, memory, self.units)
        bunch = Particles(view, process, scale)
        chance = Chance.drawn(view, self.particles, rng)
        begun = [scale.drawn(rng) for _ in range(self.starts)]
        if memory.numbers is not None:
            begun.append(scale.packed(memory.numbers))
        with torch.no_grad():
            first = [float(bunch.loss(torch.from_numpy(each), chance)) for each in begun]
        vector = self._descended(bunch, begun[int(np.argmin(first))], view, rng)
        with torch.no_grad():
            expected = float(bunch.loss(torch.from_numpy(vector), chance))
        return Improved(
            policy=radial_of(view, scale.numbers(vector)),
            numbers=scale.unpacked(vector),
            expected=expected,
        )

    def _descended(
        self, bunch: Particles, start: Array, view: TaskSums, rng: np.random.Generator
    ) -> Array:
        at = torch.from_numpy(start.copy()).requires_grad_()
        first, second = torch.zeros_like(at), torch.zeros_like(at)
        low, high = torch.from_numpy(np.array(bunch.scale.bounds).T.copy())
        for step in range(self.steps):
            share = 0.5 * (1.0 + np.cos(np.pi * step / self.steps))
            size = self.size * max(share, SMALLEST_SHARE)
            at.grad = None
            loss = bunch.loss(at, Chance.drawn(view, self.particles, rng))
            loss.backward()  # type: ignore[no-untyped-call]
            torch.nn.utils.clip_grad_norm_([at], 10.0)
            with torch.no_grad():
                first, second, change = adam(first, second, at.grad, step)
                at.copy_(torch.maximum(torch.minimum(at - size * change, high), low))
        return np.asarray(at.detach().numpy())


def adam(
    first: torch.Tensor, second: torch.Tensor, slope: torch.Tensor | None, step: int
) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Return the moments of a gradient after one more, and the change in steps of size one.

    torch's own brings its compiler along, which takes seconds to load, and where torch is built
    for graphics cards it loads libraries that crash beside those of other packages.

    Source: Kingma and Ba 2015, Adam, ICLR, algorithm 1.

    Args:
        first: Mean of gradients, which fades, shape (n,).
        second: Mean of their squares, likewise.
        slope: The gradient; None for none, which changes nothing.
        step: How many came before.
    """
    here = torch.zeros_like(first) if slope is None else slope
    first, second = 0.9 * first + 0.1 * here, 0.999 * second + 0.001 * here**2
    middle, spread = first / (1.0 - 0.9 ** (step + 1)), second / (1.0 - 0.999 ** (step + 1))
    return first, second, middle / (spread.sqrt() + 1e-8)
