"""State distribution under Gaussian-process dynamics, step by step, with its adjoint."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from morph.arrays import Array, Integers
from morph.search.moments.moment_matching_rff import Lift, LiftTape, Squasher
from morph.search.moments.moments import Moments, ProcessMoments


class ControlLaw(ABC):
    """A function from what is seen to numbers that are squashed to commands."""

    @abstractmethod
    def forward(self, m: Array, S: Array) -> tuple[Moments, Any]:
        """Return its moments at what is seen ~ N(m, S), and what the adjoint needs."""

    @abstractmethod
    def backward(
        self, tape: Any, mean: Array, covariance: Array, slope: Array
    ) -> tuple[Array, Array, Array]:
        """Return the adjoints of m, S and its numbers, the latter as one vector."""


class StepTape(NamedTuple):
    """What the adjoint of one step needs."""

    lift: LiftTape
    z: Array
    C: Array
    law: Any
    told: Moments
    squash: Any
    gain: Array
    known: Array
    towards: Array
    beside: Array
    process: Any
    change: Moments


@dataclass(frozen=True, kw_only=True, eq=False)
class GPPlant:
    """A body of joints whose change of velocity in a period is a Gaussian process.

    The state is x = (q, v), and q' = q + h (v + v') / 2: positions need no process of their own.
    """

    process: ProcessMoments
    """The change of velocity, shape (joints,), of some of (x, sin a, cos a, u)."""
    looks: Integers
    """Which of (x, sin a, cos a, u) the process looks at."""
    sees: Integers
    """Which of (x, sin a, cos a) the policy sees, in the order of its features."""
    lift: Lift
    """Which angles have a sine and a cosine."""
    squash: Squasher
    """What makes commands out of the policy's numbers."""
    noise: Array
    """Variance of what disturbs each change of velocity, shape (joints,)."""
    blur: Array
    """Variance of the noise in each number that the policy sees, shape (features,)."""
    period: float
    """h, s."""

    @cached_property
    def _joints(self) -> int:
        return len(self.noise)

    @cached_property
    def _parts(self) -> tuple[Array, ...]:
        """What picks from z and from y = (z, u), F and B of x' = F x + B change, and noise."""
        j, n = self._joints, self.lift.size
        actions = int(self.looks.max()) + 1 - n
        F, h = np.eye(2 * j), self.period
        F[:j, j:] += h * np.eye(j)
        B = np.concatenate([0.5 * h * np.eye(j), np.eye(j)])
        # A product with columns of the unit matrix costs a fifth of an indexing.
        seen, looked = np.eye(n)[:, self.sees], np.eye(n + actions)[:, self.looks]
        return seen, looked, F, B, np.diag(self.blur), np.diag(self.noise)

    def forward(self, m: Array, S: Array, law: ControlLaw) -> tuple[Array, Array, StepTape]:
        """Return mean and covariance of the state after a period, and the tape.

        Args:
            m: Shape (..., 2 joints).
            S: Shape (..., 2 joints, 2 joints).
            law: The policy.
        """
        seen, looked, F, B, blur, noise = self._parts
        n = self.lift.size
        z, C, lift = self.lift.forward(m, S)
        towards = C @ seen
        command, law_tape = law.forward(z @ seen, seen.T @ towards + blur)
        u, Cu, gain, squash = self.squash.forward(command.mean, command.covariance)
        # By Stein's lemma the covariance of z with any function is that with its input times
        # the function's mean slope; the same again through the squashing.
        known = towards @ command.slope.mT
        across = known * gain[..., None, :]
        y = np.concatenate([z, u], axis=-1)
        Y = np.empty((*y.shape, y.shape[-1]))
        Y[..., :n, :n], Y[..., n:, n:] = C, Cu
        Y[..., :n, n:], Y[..., n:, :n] = across, across.mT
        beside = Y @ looked
        change, process = self.process.forward(y @ looked, looked.T @ beside)
        beside = beside[..., : len(F), :]
        turned = F @ (beside @ change.slope.mT) @ B.T
        after = F @ S @ F.T + turned + turned.mT + B @ (change.covariance + noise) @ B.T
        mean = m @ F.T + change.mean @ B.T
        tape = StepTape(
            lift, z, C, law_tape, command, squash, gain, known, towards, beside, process, change
        )
        return mean, after, tape

    def backward(
        self, tape: StepTape, law: ControlLaw, mean: Array, covariance: Array, z: Array, C: Array
    ) -> tuple[Array, Array, Array]:
        """Return the adjoints of m, S and the policy's numbers.

        Args:
            tape: What `forward` gave.
            law: The policy.
            mean: Derivative of some number with respect to the mean after, shape (..., d).
            covariance: Likewise, symmetric, shape (..., d, d).
            z: Likewise with respect to the mean of (x, sin a, cos a) before, as costs have it.
            C: Likewise with respect to its covariance, symmetric.
        """
        seen, looked, F, B, _, _ = self._parts
        n, D = self.lift.size, len(F)
        back = F.T @ covariance
        into_cross = 2.0 * back @ B
        into_slope = into_cross.mT @ tape.beside
        first, second = self.process.backward(
            tape.process, mean @ B, B.T @ covariance @ B, into_slope
        )
        into_y = first @ looked.T
        into_Y = looked @ second @ looked.T
        into_Y[..., :D, :] += into_cross @ tape.change.slope @ looked.T

        across = into_Y[..., :n, n:] + into_Y[..., n:, :n].mT
        into_known = across * tape.gain[..., None, :]
        into_gain = (across * tape.known).sum(axis=-2)
        r, R = self.squash.backward(tape.squash, into_y[..., n:], into_Y[..., n:, n:], into_gain)
        p, P, numbers = law.backward(tape.law, r, R, into_known.mT @ tape.towards)
        into_z = into_y[..., :n] + z + p @ seen.T
        into_C = (seen @ P + into_known @ tape.told.slope) @ seen.T + into_Y[..., :n, :n] + C
        into_m, into_S = self.lift.backward(tape.lift, into_z, 0.5 * (into_C + into_C.mT))
        return into_m + mean @ F, into_S + back @ F, numbers
