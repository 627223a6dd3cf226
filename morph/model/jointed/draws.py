"""Functions drawn from what is believed of a jointed body: what its accelerations may be."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import torch

from morph.model.jointed.jointed import Jointed
from morph.model.jointed.kernel import KernelInputs
from morph.model.jointed.law import JointLaw
from morph.model.jointed.part import AccelerationModel, accelerations, law_of

WAVES = 64
"""Random waves of which the free part of a drawn function consists, before the data correct it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FunctionDraws:
    """Many functions drawn for one acceleration.

    A draw f of the prior becomes one of the posterior by

        f(x) + k(x, X) inv(K + s^2 I) (y - f(X) - e),  e ~ N(0, s^2 I).

    Far from the data the spread is the prior's, and where the data are it is what they leave
    open.

    Source: Wilson and others 2020, Efficiently Sampling Functions from Gaussian Process
    Posteriors, ICML, eqs. 12 and 13 (Matheron's rule); waves: Rahimi and Recht 2007.
    """

    part: AccelerationModel
    """What the data add to each draw, and the lawful part of the draw itself."""
    turn: torch.Tensor
    """How fast each wave of the free part changes with its inputs, shape (numbers, waves)."""
    phase: torch.Tensor
    """Where each begins, shape (waves,)."""
    height: torch.Tensor
    """How high each is in each draw, shape (draws, waves, 1)."""

    def waves(self, seen: KernelInputs) -> torch.Tensor:
        """Return the free part before the data, shape (draws, rows)."""
        waves = torch.cos(self.part.freely(seen) @ self.turn + self.phase)
        return (waves @ self.height)[..., 0]


@dataclass(frozen=True, kw_only=True, eq=False)
class Draws:
    """Bodies that the data allow: each draw has its own function for every acceleration."""

    model: Jointed
    """What they are drawn from."""
    count: int
    """How many there are."""
    drawn: tuple[FunctionDraws, ...]
    """The functions of each joint."""

    def accelerate(
        self, position: torch.Tensor, velocity: torch.Tensor, command: torch.Tensor
    ) -> torch.Tensor:
        """Return accelerations by each draw's own functions, shape (draws, rows, joints)."""
        model = self.model
        seen = model.look(position, velocity, command)
        total = accelerations(model.layout, self.parts, self.law, seen)
        if any(part.scales.free > 0.0 for part in self.parts):
            total = total + torch.stack([each.waves(seen) for each in self.drawn], dim=-1)
        count = total * model.size
        return count if model.base is None else count + model.base(position, velocity, command)

    @cached_property
    def parts(self) -> tuple[AccelerationModel, ...]:
        """What the data add to each draw, and the lawful parts of the draws."""
        return tuple(each.part for each in self.drawn)

    @cached_property
    def law(self) -> JointLaw | None:
        """The lawful part of all accelerations of each draw."""
        return law_of(self.parts) if self.model.layout.lawful else None


def draw(model: Jointed, count: int, rng: np.random.Generator) -> Draws:
    """Return bodies drawn from a model."""
    drawn = tuple(_drawn(model, at, count, rng) for at in range(model.layout.joints))
    return Draws(model=model, count=count, drawn=drawn)


def _drawn(model: Jointed, at: int, count: int, rng: np.random.Generator) -> FunctionDraws:
    part, layout, data = model.parts[at], model.layout, model.seen
    scales, n = part.scales, len(model.target)

    def normal(*shape: int) -> torch.Tensor:
        return torch.as_tensor(rng.standard_normal(shape))

    drawn = FunctionDraws(
        part=part,
        turn=normal(part.data.shape[1], WAVES),
        phase=torch.as_tensor(rng.uniform(0.0, 2.0 * math.pi, WAVES)),
        height=normal(count, WAVES, 1) * scales.free * math.sqrt(2.0 / WAVES),
    )
    left = model.target[:, at] - scales.noise * normal(count, n) - drawn.waves(data)
    if not layout.lawful:
        return FunctionDraws(**{**vars(drawn), "part": part.conditioned(layout, data, left)})
    features, monomials = part.lawful(layout, data)
    prior = normal(count, features.shape[1], monomials.shape[1])
    left = left - ((features @ prior) * monomials).sum(-1)
    return FunctionDraws(**{**vars(drawn), "part": part.conditioned(layout, data, left, prior)})
