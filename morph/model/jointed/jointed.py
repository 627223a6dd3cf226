"""The accelerations of a jointed body, learned from trials alone as Gaussian processes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import torch

from morph.arrays import Array
from morph.model.jointed.kernel import KernelInputs, KernelLayout
from morph.model.jointed.law import JointLaw
from morph.model.jointed.part import AccelerationModel, accelerations, law_of

Accelerations = Callable[[torch.Tensor, torch.Tensor, torch.Tensor], torch.Tensor]
"""From position, velocity (..., joints) and command (..., commands) to acceleration."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Jointed:
    """Accelerations as Gaussian processes of posture, velocity and command, one a joint."""

    layout: KernelLayout
    """What the kernel looks at."""
    logs: torch.Tensor
    """Logarithms of the kernel's settings, shape (joints, settings)."""
    parts: tuple[AccelerationModel, ...]
    """What the data say of each acceleration."""
    seen: KernelInputs
    """Where the periods' accelerations were seen."""
    target: torch.Tensor
    """Those accelerations in units of their size, shape (n, joints)."""
    velocity_size: torch.Tensor
    """Unit of velocities, shape (joints,)."""
    command_size: torch.Tensor
    """Unit of commands, shape (commands,)."""
    size: torch.Tensor
    """Unit of accelerations, shape (joints,)."""
    period: float
    """Length of a period, s."""
    base: Accelerations | None = None
    """What was believed of the accelerations before any data; None for nothing."""

    @property
    def velocity_noise(self) -> Array:
        """Standard deviation of the velocities' noise that the data show, shape (joints,).

        The acceleration of a period is a difference of two velocities over its length.
        """
        noise = torch.stack([each.scales.noise for each in self.parts]) * self.size
        return np.asarray(noise.numpy() * self.period / np.sqrt(2.0))

    def look(
        self, position: torch.Tensor, velocity: torch.Tensor, command: torch.Tensor
    ) -> KernelInputs:
        """Return states and commands as the kernel looks at them."""
        return KernelInputs(
            place=self.layout.place(position),
            velocity=velocity / self.velocity_size,
            command=command / self.command_size,
        )

    def mean(
        self, position: torch.Tensor, velocity: torch.Tensor, command: torch.Tensor
    ) -> torch.Tensor:
        """Return the mean accelerations, shape (..., joints); differentiable."""
        seen = self.look(position, velocity, command)
        learned = accelerations(self.layout, self.parts, self.law, seen) * self.size
        return learned if self.base is None else learned + self.base(position, velocity, command)

    @cached_property
    def law(self) -> JointLaw | None:
        """The lawful part of all accelerations."""
        return law_of(self.parts) if self.layout.lawful else None

    def variance(
        self, position: torch.Tensor, velocity: torch.Tensor, command: torch.Tensor
    ) -> torch.Tensor:
        """Return the accelerations' variances, without noise, shape (rows, joints)."""
        seen = self.look(position, velocity, command)
        results = []
        for part in self.parts:
            across = part.covariance(self.layout, self.seen, seen)
            known = torch.linalg.solve_triangular(part.factor, across, upper=False)
            results.append((part.variance(self.layout, seen) - (known**2).sum(0)).clamp(min=0.0))
        return torch.stack(results, dim=-1) * self.size**2


def through(
    accelerate: Accelerations,
    position: torch.Tensor,
    velocity: torch.Tensor,
    command: torch.Tensor,
    period: float,
) -> tuple[torch.Tensor, torch.Tensor]:
    """Return position and velocity a control period later, shape (..., joints) each.

    One step of the classical Runge-Kutta method; the command is held. What the step errs, the
    fit takes into the accelerations.
    """
    h, q, v = period, position, velocity
    first = accelerate(q, v, command)
    v_second = v + 0.5 * h * first
    second = accelerate(q + 0.5 * h * v, v_second, command)
    v_third = v + 0.5 * h * second
    third = accelerate(q + 0.5 * h * v_second, v_third, command)
    v_fourth = v + h * third
    fourth = accelerate(q + h * v_third, v_fourth, command)
    return (
        q + h / 6.0 * (v + 2.0 * v_second + 2.0 * v_third + v_fourth),
        v + h / 6.0 * (first + 2.0 * second + 2.0 * third + fourth),
    )
