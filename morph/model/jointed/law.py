"""The lawful part of all accelerations of a body at once, in two products and one exponential."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import torch

from morph.model.jointed.kernel import KernelInputs, KernelLayout
from morph.model.jointed.landmarks import Landmarks


@dataclass(frozen=True, kw_only=True, eq=False)
class JointLaw:
    """a_i = sum over c of m_c(v, u) sum over landmarks z of exp(-|e - z|^2 / 2) w_zic.

    The exponent is linear in the numbers of a place and in their squares, whatever each
    acceleration's lengths are; so one product gives those of all landmarks.
    """

    slope: torch.Tensor
    """Of the exponents in places and their squares, shape (2 numbers, landmarks)."""
    offset: torch.Tensor
    """Of the exponents, shape (landmarks,)."""
    coefficient: torch.Tensor
    """Shape (..., landmarks, monomials times joints); zero for other joints' landmarks."""

    def told(self, layout: KernelLayout, seen: KernelInputs) -> torch.Tensor:
        """Return accelerations in units of their sizes, shape (..., joints)."""
        place = torch.cat([seen.place, seen.place * seen.place], dim=-1)
        near = torch.exp(place @ self.slope + self.offset)
        monomials = layout.monomials(seen.velocity, seen.command)
        shape = (*monomials.shape, layout.joints)
        many = (near @ self.coefficient).reshape(shape)
        return (monomials[..., None, :] @ many)[..., 0, :]


def law(
    postures: Sequence[Landmarks], lengths: Sequence[torch.Tensor], weights: Sequence[torch.Tensor]
) -> JointLaw:
    """Return the law that landmarks and their weights make.

    Args:
        postures: The landmarks of each acceleration, over its lengths.
        lengths: Those lengths, shape (numbers,) each.
        weights: Of each landmark in each coefficient, shape (..., landmarks, monomials) each.
    """
    slopes, offsets, rows = [], [], []
    for at, (marks, length, weight) in enumerate(zip(postures, lengths, weights, strict=True)):
        one = torch.ones(len(marks.points), dtype=torch.float64)
        across = length[:, None]
        slopes.append(torch.cat([marks.points.T / across, -0.5 * one / across**2]))
        offsets.append(-0.5 * (marks.points**2).sum(-1))
        wide = torch.zeros((*weight.shape, len(weights)), dtype=torch.float64)
        wide[..., at] = weight
        rows.append(wide.flatten(-2))
    return JointLaw(
        slope=torch.cat(slopes, dim=-1).contiguous(),
        offset=torch.cat(offsets),
        coefficient=torch.cat(rows, dim=-2).contiguous(),
    )
