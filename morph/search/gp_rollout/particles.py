"""Particle rollouts of a policy in posterior samples of the dynamics, differentiated by torch."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch

from morph.arrays import Array
from morph.model.gp.gp import GaussianProcess
from morph.search.gp_rollout.radial import RadialScale
from morph.search.gp_rollout.task import TaskSums

Tensor = torch.Tensor


@dataclass(frozen=True, kw_only=True, eq=False)
class Chance:
    """All that is drawn for a bunch of particles, so that a gradient can be taken through it."""

    start: Tensor
    """Of the first state, shape (particles, 2 joints)."""
    velocity: Tensor
    """Of each change of velocity, shape (periods, particles, joints)."""
    seen: Tensor
    """Of each observation, shape (periods, particles, 2 joints)."""

    @classmethod
    def drawn(cls, view: TaskSums, particles: int, rng: np.random.Generator) -> Chance:
        """Return standard normal numbers for so many particles."""
        size, periods = 2 * view.joints, view.task.samples - 1
        return cls(
            start=torch.from_numpy(rng.standard_normal((particles, size))),
            velocity=torch.from_numpy(rng.standard_normal((periods, particles, view.joints))),
            seen=torch.from_numpy(rng.standard_normal((periods, particles, size))),
        )


class Particles:
    """The mean loss of a policy of radial basis functions over particles.

    A particle's velocity changes by a draw from the process at where it is,

        v' = v + m(x, u) + sqrt(s^2(x, u)) e,    q' = q + h (v + v') / 2,

    so that the mean loss is a smooth function of the policy once every e is drawn. Every step
    is a handful of operations on all particles, outputs and data at once: what such a search
    costs is the number of its operations, not of its particles.

    Source: Amadio, Dalla Libera, Antonello, Nikovski, Carli and Romeres 2022, Model-Based Policy
    Search Using Monte Carlo Gradient Estimation With Real Systems Application, IEEE T-RO 38(6),
    eqs. 9, 14 and 18.
    """

    def __init__(self, view: TaskSums, process: GaussianProcess, scale: RadialScale) -> None:
        """Put all that does not change into tensors."""
        self.view, self.scale = view, scale
        number = torch.from_numpy
        # Divided by its lengths, an input is as far from another as the kernel counts.
        self._inverse = number(1.0 / process.lengths)[:, None, :]
        self._inputs = number(process.inputs)[None] * self._inverse
        self._square = (self._inputs**2).sum(-1)[:, None, :]
        self._signal = number(process.signal**2)[:, None, None]
        self._weights = number(process.weights)[..., None]
        self._precision = number(process.precision)
        self._angles = number(view.lift.angles.T.copy())
        mean, covariance = view.start
        self._start = number(mean), number(_root(covariance))
        low, high = view.bounds
        self._middle, self._half = number((low + high) / 2.0), number((high - low) / 2.0)
        self._costs = [(number(c.A.T.copy()), number(c.b), c.weight, c.norm) for c in view.costs]
        self._slope, self._shift = number(scale.slope), number(scale.shift)

    def loss(self, vector: Tensor, chance: Chance, *, least: float = 0.0) -> Tensor:
        """Return the mean loss, a number.

        Args:
            vector: The policy's numbers in the units of the scale.
            chance: What is drawn.
            least: Least variance of a change of velocity, that roots have slopes.
        """
        numbers = vector * self._slope + self._shift
        units, features = self.scale.units, len(self.scale.spread)
        centre = numbers[: units * features].reshape(units, features)
        width = torch.exp(numbers[units * features :][:features])
        weight = numbers[(units + 1) * features :].reshape(-1, units)
        centre = centre / width
        spread, noise = (centre**2).sum(-1), self.view.task.noise
        mean, root = self._start
        state = mean + chance.start @ root.T
        total = self._cost(self._lifted(state))
        for e, seen in zip(chance.velocity, chance.seen, strict=True):
            z = self._lifted(state)
            o = self._lifted(state + noise * seen)[:, self.view.sees] / width
            near = torch.exp(o @ centre.T - 0.5 * ((o**2).sum(-1, keepdim=True) + spread))
            sine = torch.sin(near @ weight.T)
            command = self._middle + self._half * sine * (1.5 - 0.5 * sine * sine)
            inputs = torch.cat([z, command], dim=-1)[:, self.view.looks]
            state = self._moved(state, inputs, e, least)
            total = total + self._cost(self._lifted(state))
        return total.mean()

    def _lifted(self, state: Tensor) -> Tensor:
        angle = state @ self._angles
        return torch.cat([state, torch.sin(angle), torch.cos(angle)], dim=-1)

    def _moved(self, state: Tensor, inputs: Tensor, e: Tensor, least: float) -> Tensor:
        x = inputs[None] * self._inverse
        far = (x**2).sum(-1, keepdim=True) + self._square
        k = self._signal * torch.exp(torch.baddbmm(-0.5 * far, x, self._inputs.mT))
        mean = (k @ self._weights)[..., 0].T
        known = ((k @ self._precision) * k).sum(-1).T
        variance = self._signal[:, 0, 0] - known
        change = mean + torch.sqrt(torch.clamp(variance, min=least + 1e-12)) * e
        joints = self.view.joints
        q, v = state[:, :joints], state[:, joints:]
        return torch.cat([q + self.view.task.period * (v + 0.5 * change), v + change], dim=-1)

    def _cost(self, z: Tensor) -> Tensor:
        total = torch.zeros(len(z), dtype=z.dtype)
        for A, b, weight, norm in self._costs:
            half = 0.5 * ((z @ A + b) ** 2).sum(-1)
            total = total + weight * (half if norm == "quadratic" else -torch.expm1(-half))
        return total

    def gradient(self, vector: Array, chance: Chance) -> tuple[float, Array]:
        """Return the mean loss and its derivative in the policy's numbers, shape (numbers,)."""
        at = torch.from_numpy(np.array(vector)).requires_grad_()
        loss = self.loss(at, chance)
        (slope,) = torch.autograd.grad(loss, at)
        return float(loss.detach()), slope.numpy()


def _root(covariance: Array) -> Array:
    """Return the symmetric square root of a covariance, which may be that of no chance at all."""
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray((vectors * np.sqrt(np.maximum(values, 0.0))) @ vectors.T)
