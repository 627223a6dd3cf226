"""The choice among models by Bayes' rule, where neighbouring samples share their errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import mujoco
import numpy as np
from scipy.special import logsumexp
from scipy.stats import norm

from morph.arrays import Array
from morph.errors import EvidenceError
from morph.model.ou_likelihood import Likelihood, likelihood
from morph.model.transitions import ModelTransitions

WHOLE = 2
"""Kinds of motion up to which a body is looked at as one; a larger one joint by joint."""

ROUNDS = 30
"""Turns of settings and figures in doubt; they settle in ten."""

STILL = 1e-6
"""Least acceleration that is taken for typical: of what does not move, m/s2 or rad/s2."""


def posterior(log_evidence: Array, log_prior: Array) -> Array:
    """Return how probable each model is, given a recording.

    Source: Gamboa Higuera 2015, eq. 13, in logs so that long recordings do not underflow.

    Args:
        log_evidence: log p(recording | model), shape (..., models).
        log_prior: log p(model), shape (models,).

    Returns:
        Probabilities that sum to 1, shape (..., models).

    Raises:
        EvidenceError: Every model holds the recording to be impossible.
    """
    score = log_evidence + log_prior
    best = score.max(axis=-1, keepdims=True)
    if not np.isfinite(best).all():
        raise EvidenceError(
            f"none of {score.shape[-1]} models can produce this recording",
            where="a choice among models",
            fix="look for a number that is not finite, or add a model to the ensemble",
        )
    weight = np.exp(score - best)
    return np.asarray(weight / weight.sum(axis=-1, keepdims=True))


@dataclass(frozen=True, kw_only=True)
class Unsaid:
    """What a model may leave out before any data: an acceleration of unknown size and length.

    Its size is told as a share of the acceleration that models typically tell of the same kind
    of motion in the same run. All sizes, and all lengths, are as probable as each other; no run
    tells them exactly, so all of them take part, each as far as it explains the run.

    Raises:
        EvidenceError: There is no share or no length, or one is out of range.
    """

    shares: tuple[float, ...] = (0.0, 0.02, 0.05, 0.1, 0.2, 0.4, 1.0)
    """Standard deviation by typical acceleration."""
    lengths: tuple[float, ...] = (0.2, 2.0)
    """For how long it lasts, s."""
    limit: float = 0.3
    """Share above which a model does not fit."""
    far: float = 4.0
    """Standard deviations beyond which a figure in doubt is more than doubtful: no fit either."""

    def __post_init__(self) -> None:
        """Check that every number can be used."""
        fine = bool(self.shares) and min(self.shares) >= 0.0 and np.isfinite(self.shares).all()
        if not (fine and self.lengths and min(self.lengths) > 0.0):
            raise EvidenceError(
                f"shares {self.shares} or lengths {self.lengths} s are out of range",
                where="what a model may leave out",
                fix="give shares of 0 or more and lengths above 0",
            )


@dataclass(frozen=True, kw_only=True, eq=False)
class Block:
    """A part of a body whose motion is looked at together."""

    dof: Array
    """Its degrees of freedom, shape (m,)."""
    kinds: tuple[tuple[int, ...], ...]
    """Those of one kind of motion, by their places in `dof`: each kind has a share of its own."""

    def settings(self, unsaid: Unsaid) -> tuple[Array, Array]:
        """Return every share of each degree of freedom, (settings, m), and length, (settings,).

        With nothing left out the lengths are alike, and stand there all the same: so the prior
        is uniform over both.
        """
        shares, lengths = [], []
        for *each, length in product(*[unsaid.shares] * len(self.kinds), unsaid.lengths):
            share = np.empty(len(self.dof))
            for kind, value in zip(self.kinds, each, strict=True):
                share[list(kind)] = value
            shares.append(share)
            lengths.append(length)
        return np.array(shares), np.array(lengths)


def blocks(model: Any) -> tuple[Block, ...]:
    """Return the parts of a body that are looked at together, in the order of its joints.

    A floating body moves in two kinds, straight and turning, a ball joint turns, and each hinge
    or slide is a kind of its own. Up to two kinds are one block, so that nothing is left out.
    """
    joints = []
    for kind, at in zip(model.jnt_type, model.jnt_dofadr, strict=True):
        if kind == mujoco.mjtJoint.mjJNT_FREE:
            joints.append([range(at, at + 3), range(at + 3, at + 6)])
        else:
            joints.append([range(at, at + (3 if kind == mujoco.mjtJoint.mjJNT_BALL else 1))])
    if sum(map(len, joints)) <= WHOLE:
        joints = [[kind for joint in joints for kind in joint]]
    results = []
    for joint in joints:
        dof = [index for kind in joint for index in kind]
        kinds = tuple(tuple(dof.index(index) for index in kind) for kind in joint)
        results.append(Block(dof=np.array(dof), kinds=kinds))
    return tuple(results)


def courses(
    model: Any, seen: ModelTransitions, noise: Array, unsaid: Unsaid
) -> tuple[Likelihood, ...]:
    """Return how probable a run is, up to each of its samples, under each setting of each block.

    Between blocks noise leaks as if it were independent from one sample to the next; what models
    predict is that of the whole body.

    Args:
        model: The compiled `mujoco.MjModel`.
        seen: The run's transitions under all models.
        noise: Standard deviation of each observed number, positions and then velocities as
            `qvel` has them, shape (2 nv,).
        unsaid: What models may leave out.

    Returns:
        For each block the likelihood up to each sample, (models, settings, periods).
    """
    nv = seen.change.shape[2]
    rates = np.median(np.mean((seen.change / seen.period) ** 2, axis=1), axis=0)
    results = []
    for block in blocks(model):
        here = np.concatenate([block.dof, block.dof + nv])
        there = np.setdiff1d(np.arange(2 * nv), here)
        share, length = block.settings(unsaid)
        typical = np.empty(len(block.dof))
        for kind in block.kinds:
            of_kind = list(kind)
            typical[of_kind] = max(np.sqrt(rates[block.dof[of_kind]].mean()), STILL)
        carry = seen.carry[:, :, here]
        results.append(
            likelihood(
                seen.miss[:, :, here],
                carry[..., here],
                doubt=seen.doubt[:, :, here],
                noise=noise[here],
                leak=(carry[..., there] ** 2) @ noise[there] ** 2,
                scale=share * typical,
                length=length,
                period=seen.period,
            )
        )
    return tuple(results)


@dataclass(frozen=True, kw_only=True, eq=False)
class WeighedModels:
    """How probable runs are under each model, and what each model has to leave out."""

    log_evidence: Array
    """log p(runs | model), shape (models, ...)."""
    settings: tuple[Array, ...]
    """How probable each setting of each block is, shape (models, settings, ...) each."""
    doubt: Array
    """Mean of the figures in doubt, by their standard deviations, (models, ..., doubts)."""
    doubt_left: Array
    """How uncertain they still are, as a share of what they were, same shape."""

    def too_much(self, model: Any, unsaid: Unsaid) -> Array:
        """Return how probable it is that a model leaves out more than the limit, (models, ...).

        It does where any kind of motion has a share above `unsaid.limit`, or where a figure in
        doubt is farther off than `unsaid.far`.
        """
        near = norm.cdf((unsaid.far - np.abs(self.doubt)) / self.doubt_left)
        fine = np.prod(near, axis=-1)
        for block, weight in zip(blocks(model), self.settings, strict=True):
            share, _ = block.settings(unsaid)
            fine = fine * weight[:, share.max(axis=1) <= unsaid.limit].sum(axis=1)
        return np.asarray(np.clip(1.0 - fine, 0.0, 1.0))


def weighed(parts: Sequence[Likelihood]) -> WeighedModels:
    """Return the evidence of likelihoods by block, over all settings and figures in doubt.

    All settings are as probable as each other, and figures in doubt are normal. One block is
    integrated exactly, setting by setting. Several blocks share the figures in doubt: there the
    evidence is the lower bound of a mean field, settings of each block and figures apart, which
    is exact where no figure is in doubt.

    Source: Bishop 2006, Pattern recognition and machine learning, section 10.1.
    """
    if len(parts) == 1 or parts[0].slope.shape[-1] == 0:
        return _exactly(parts)
    weight = _exactly(parts).settings
    for _ in range(ROUNDS):
        mean, spread = _doubts(parts, weight)
        logs = [_expected(part, mean, spread) for part in parts]
        weight = tuple(np.exp(log - logsumexp(log, axis=1, keepdims=True)) for log in logs)
    size = mean.shape[-1]
    away = np.trace(spread, axis1=-2, axis2=-1) + np.sum(mean**2, axis=-1) - size
    price = 0.5 * (away - np.linalg.slogdet(spread)[1])
    bound = sum((_mixed(log) for log in logs), start=np.zeros(1))
    left = np.sqrt(np.diagonal(spread, axis1=-2, axis2=-1))
    return WeighedModels(log_evidence=bound - price, settings=weight, doubt=mean, doubt_left=left)


def _exactly(parts: Sequence[Likelihood]) -> WeighedModels:
    """Return what each block says by itself, figures in doubt integrated in each setting."""
    total, settings = np.zeros(1), []
    for part in parts:
        precision = np.eye(part.slope.shape[-1]) + part.curve
        best = np.linalg.solve(precision, part.slope[..., None])[..., 0]
        log = part.base + 0.5 * np.sum(best * part.slope, axis=-1)
        log = log - 0.5 * np.linalg.slogdet(precision)[1]
        total = total + _mixed(log)
        settings.append(np.exp(log - logsumexp(log, axis=1, keepdims=True)))
    # Only one block has figures in doubt here, or none has.
    weight = settings[-1][..., None]
    doubt = np.sum(weight * best, axis=1)
    own = np.diagonal(np.linalg.inv(precision), axis1=-2, axis2=-1)
    left = np.sqrt(np.sum(weight * (own + (best - doubt[:, None]) ** 2), axis=1))
    return WeighedModels(log_evidence=total, settings=tuple(settings), doubt=doubt, doubt_left=left)


def _doubts(parts: Sequence[Likelihood], weight: Sequence[Array]) -> tuple[Array, Array]:
    """Return mean and covariance of the figures in doubt, settings being as weighed."""
    both = list(zip(parts, weight, strict=True))
    curve = sum((np.sum(w[..., None, None] * p.curve, axis=1) for p, w in both), np.zeros(1))
    slope = sum((np.sum(w[..., None] * p.slope, axis=1) for p, w in both), np.zeros(1))
    spread = np.linalg.inv(np.eye(slope.shape[-1]) + curve)
    return (spread @ slope[..., None])[..., 0], spread


def _expected(part: Likelihood, mean: Array, spread: Array) -> Array:
    """Return a block's expected log density under figures so distributed, by setting."""
    second = spread + mean[..., :, None] * mean[..., None, :]
    linear = np.sum(part.slope * mean[:, None], axis=-1)
    return np.asarray(
        part.base + linear - 0.5 * np.sum(part.curve * second[:, None], axis=(-2, -1))
    )


def _mixed(log: Array) -> Array:
    """Return the log of the mean over settings, (models, settings, ...) to (models, ...)."""
    return np.asarray(logsumexp(log, axis=1) - np.log(log.shape[1]))
