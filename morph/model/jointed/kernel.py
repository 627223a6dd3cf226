"""How alike the accelerations of a jointed body are in two states, under two commands."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import torch

from morph.arrays import Array
from morph.model.jointed.landmarks import exponential

WIDEST = 4.0
"""How many standard deviations of its prior a logarithm may be from its middle."""


@dataclass(frozen=True, kw_only=True)
class KernelLayout:
    """Which numbers of a state are looked at, and where each setting of the kernel stands.

    A state is looked at as cos and sin of its turning joints, the positions of its slides if
    they matter, all velocities, and the commands.
    """

    turning: tuple[int, ...]
    """The joints whose positions are angles."""
    sliding: tuple[int, ...]
    """The other joints whose positions matter."""
    joints: int
    """How many joints there are."""
    commands: int
    """How many commands."""
    lawful: bool = True
    """Whether the part that is quadratic in velocities and affine in commands is there."""

    @property
    def places(self) -> int:
        """How many joints' positions are looked at."""
        return len(self.turning) + len(self.sliding)

    @property
    def pairs(self) -> tuple[tuple[int, int], ...]:
        """The pairs of velocities whose products are looked at."""
        return tuple((i, j) for i in range(self.joints) for j in range(i, self.joints))

    @cached_property
    def prior(self) -> tuple[torch.Tensor, torch.Tensor]:
        """Middle and standard deviation of each setting's logarithm, shape (settings,) both.

        Inputs and accelerations come divided by their sizes, so that 1 is a natural length
        and a natural amplitude of anything. The free part is small beside the lawful one.
        """
        free = -4.0 if self.lawful else 0.0
        rows: list[tuple[int, float, float]] = [
            (self.places, 0.3, 0.5),
            (1, -0.5, 1.0),
            (self.joints, -1.5, 1.0),
            (self.joints, -1.5, 1.0),
            (self.commands, -0.5, 1.0),
            (1, free, 1.0),
            (self.places + self.joints + self.commands, 1.0, 0.5),
            (1, -3.0, 1.0),
        ]
        middle = [value for count, value, _ in rows for _ in range(count)]
        spread = [value for count, _, value in rows for _ in range(count)]
        return _tensor(middle), _tensor(spread)

    def scales(self, logs: torch.Tensor) -> Scales:
        """Return the settings of one acceleration from their logarithms, shape (settings,)."""
        middle, spread = self.prior
        bounded = middle + spread * ((logs - middle) / spread).clamp(-WIDEST, WIDEST)
        sizes = (self.places, 1, self.joints, self.joints, self.commands, 1)
        *parts, rest = torch.split(bounded.exp(), [*sizes, len(logs) - sum(sizes)])
        place, constant, speed, product, command, free = parts
        products = [
            product[i] * product[j] * (1.0 if i == j else math.sqrt(2.0)) for i, j in self.pairs
        ]
        return Scales(
            place=self._each_number(place),
            lawful=torch.cat([constant, speed, torch.stack(products), command]),
            free=free[0],
            free_place=self._each_number(rest[: self.places]),
            free_rate=rest[self.places : -1],
            noise=rest[-1],
        )

    def _each_number(self, of_joint: torch.Tensor) -> torch.Tensor:
        """Return one length for each number of a place: an angle's cos and sin share theirs."""
        turning, sliding = of_joint[: len(self.turning)], of_joint[len(self.turning) :]
        return torch.cat([turning, turning, sliding])

    def place(self, position: torch.Tensor) -> torch.Tensor:
        """Return cos, sin and slides, shape (..., numbers)."""
        turning, sliding = self._placed
        angle = position[..., turning]
        return torch.cat([torch.cos(angle), torch.sin(angle), position[..., sliding]], dim=-1)

    def monomials(self, velocity: torch.Tensor, command: torch.Tensor) -> torch.Tensor:
        """Return 1, velocities, their products and commands, shape (..., monomials)."""
        first, second = self._paired
        one = torch.ones_like(velocity[..., :1])
        products = velocity[..., first] * velocity[..., second]
        return torch.cat([one, velocity, products, command], dim=-1)

    @cached_property
    def _paired(self) -> tuple[torch.Tensor, torch.Tensor]:
        first, second = zip(*self.pairs, strict=True)
        return torch.tensor(first), torch.tensor(second)

    @cached_property
    def _placed(self) -> tuple[torch.Tensor, torch.Tensor]:
        return torch.tensor(self.turning, dtype=torch.int64), torch.tensor(
            self.sliding, dtype=torch.int64
        )


@dataclass(frozen=True, kw_only=True)
class Scales:
    """The settings of the kernel of one acceleration."""

    place: torch.Tensor
    """Length of each number of a place, over which the coefficients of the law change."""
    lawful: torch.Tensor
    """Amplitude of each monomial's coefficient."""
    free: torch.Tensor
    """Amplitude of the free part."""
    free_place: torch.Tensor
    """Length of each number of a place, for the free part."""
    free_rate: torch.Tensor
    """Likewise of each velocity and command."""
    noise: torch.Tensor
    """Standard deviation of an acceleration's noise."""


@dataclass(frozen=True, kw_only=True)
class KernelInputs:
    """States and commands as the kernel looks at them, in units of their sizes."""

    place: torch.Tensor
    """Shape (..., numbers)."""
    velocity: torch.Tensor
    """Shape (..., joints)."""
    command: torch.Tensor
    """Shape (..., commands)."""

    @property
    def rate(self) -> torch.Tensor:
        """Velocities and commands together."""
        return torch.cat([self.velocity, self.command], dim=-1)


def gram(
    layout: KernelLayout, scales: Scales, these: KernelInputs, those: KernelInputs
) -> torch.Tensor:
    """Return the covariance of an acceleration in two sets of states, shape (n, m).

    Lagrange's equations give a body of joints, solved for its accelerations,

        a(q, v, u) = sum over c of g_c(q) m_c(v, u),  m = (1, v_i, v_i v_j, u_k),

    whatever its masses and lengths. Each coefficient g_c is a Gaussian process over the posture,
    so that the covariance is exp(-|e - e'|^2 / 2) sum over c of s_c^2 m_c m_c', with e the cos
    and sin of the angles over a length. What is no such law (dry friction, drag, stops) is left
    to a squared exponential of all inputs.

    Source: the form of the equations, Featherstone 2008, eq. 1.1; kernels that hold it,
    Dalla Libera and Carli 2020, IEEE L-CSS 4(1), here with smooth and not polynomial g_c.
    """
    total = scales.free**2 * exponential(
        torch.cat([these.place / scales.free_place, these.rate / scales.free_rate], dim=-1),
        torch.cat([those.place / scales.free_place, those.rate / scales.free_rate], dim=-1),
    )
    if not layout.lawful:
        return total
    alike = exponential(these.place / scales.place, those.place / scales.place)
    one = layout.monomials(these.velocity, these.command) * scales.lawful
    other = layout.monomials(those.velocity, those.command) * scales.lawful
    return total + alike * (one @ other.T)


def _tensor(values: list[float] | Array) -> torch.Tensor:
    return torch.as_tensor(np.asarray(values, dtype=float))
