"""One acceleration of a jointed body, as a Gaussian process that has seen data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import torch

from morph.model.jointed.kernel import KernelInputs, KernelLayout, Scales
from morph.model.jointed.landmarks import Landmarks, exponential
from morph.model.jointed.law import JointLaw, law


@dataclass(frozen=True, kw_only=True, eq=False)
class AccelerationModel:
    """One acceleration: what the data say of it."""

    scales: Scales
    """The kernel; `free` is zero if the data do not ask for the free part."""
    postures: Landmarks
    """Features of the posture, over which the coefficients of the law change."""
    factor: torch.Tensor
    """Lower Cholesky factor of the data's covariance, shape (n, n)."""
    coefficient: torch.Tensor
    """Of the exponentials about each landmark, in each coefficient, shape (..., m, monomials)."""
    data: torch.Tensor
    """The data as the free part sees them, over its lengths, shape (n, numbers)."""
    weight: torch.Tensor
    """The inverse covariance times the targets, shape (..., n)."""

    def free(self, seen: KernelInputs) -> torch.Tensor:
        """Return what the data add by the free part, shape (...,)."""
        near = exponential(self.freely(seen), self.data)
        return self.scales.free**2 * (near @ self.weight[..., None])[..., 0]

    def freely(self, seen: KernelInputs) -> torch.Tensor:
        """Return states and commands over the lengths of the free part."""
        scales = self.scales
        return torch.cat([seen.place / scales.free_place, seen.rate / scales.free_rate], dim=-1)

    def lawful(self, layout: KernelLayout, seen: KernelInputs) -> tuple[torch.Tensor, torch.Tensor]:
        """Return features of postures (n, m), and monomials times their amplitudes."""
        features = self.postures.features(seen.place / self.scales.place)
        return features, layout.monomials(seen.velocity, seen.command) * self.scales.lawful

    def covariance(
        self, layout: KernelLayout, these: KernelInputs, those: KernelInputs
    ) -> torch.Tensor:
        """Return the covariance of the acceleration in two sets of states, shape (n, m)."""
        total = self.scales.free**2 * exponential(self.freely(these), self.freely(those))
        if layout.lawful:
            f, m = self.lawful(layout, these)
            f_, m_ = self.lawful(layout, those)
            total = total + (f @ f_.T) * (m @ m_.T)
        return total

    def variance(self, layout: KernelLayout, seen: KernelInputs) -> torch.Tensor:
        """Return the acceleration's variance before the data, shape (n,)."""
        total = self.scales.free**2 * torch.ones(len(seen.place), dtype=torch.float64)
        if layout.lawful:
            features, monomials = self.lawful(layout, seen)
            total = total + (features**2).sum(-1) * (monomials**2).sum(-1)
        return total

    def conditioned(
        self,
        layout: KernelLayout,
        data: KernelInputs,
        left: torch.Tensor,
        prior: torch.Tensor | None = None,
    ) -> AccelerationModel:
        """Return the part once it has seen what is left of the targets, shape (..., n).

        Args:
            layout: What the kernel looks at.
            data: Where the targets were seen.
            left: Targets less what the part said before.
            prior: What the part said before, as coefficients of the features, shape
                (..., m, monomials); None for nothing.
        """
        weight = torch.cholesky_solve(left.reshape(-1, left.shape[-1]).T, self.factor).T
        weight = weight.reshape(left.shape).contiguous()
        if not layout.lawful:
            return replace(self, weight=weight)
        features, monomials = self.lawful(layout, data)
        information = features.T @ (weight[..., None] * monomials)
        if prior is not None:
            information = information + prior
        return replace(
            self, weight=weight, coefficient=self.postures.whiten @ information * self.scales.lawful
        )


def law_of(parts: Sequence[AccelerationModel]) -> JointLaw:
    """Return the lawful part of all accelerations at once."""
    return law(
        [each.postures for each in parts],
        [each.scales.place for each in parts],
        [each.coefficient for each in parts],
    )


def accelerations(
    layout: KernelLayout,
    parts: Sequence[AccelerationModel],
    lawful: JointLaw | None,
    seen: KernelInputs,
) -> torch.Tensor:
    """Return what all parts say, in units of their sizes, shape (..., joints)."""
    total = torch.zeros(seen.velocity.shape, dtype=torch.float64)
    if lawful is not None:
        total = lawful.told(layout, seen)
    if any(part.scales.free > 0.0 for part in parts):
        # Each has few lengths in common with the others; there is nothing to fuse.
        zero = torch.zeros(seen.velocity.shape[:-1], dtype=torch.float64)
        free = [part.free(seen) if part.scales.free > 0.0 else zero for part in parts]
        total = total + torch.stack(free, dim=-1)
    return total
