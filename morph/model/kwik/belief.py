"""Rival priors on what a model leaves out, and what evidence makes of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.model.gaussian.information import Information

UNCHANGED = 0.3
"""Prior probability that no named figure differs from its description."""

ALONE = (0.03, 0.1, 0.3, 1.0)
"""Widths of priors in which a single named figure differs, in its unit: logarithms of factors."""

TOGETHER = (0.01, 0.03, 0.1, 0.3)
"""Widths of priors in which all of them do."""

UNNAMED = (
    (0.03, 0.03, 0.65),
    (0.03, 3.0, 0.08),
    (0.03, 20.0, 0.07),
    (0.3, 0.3, 0.08),
    (1.5, 3.0, 0.06),
    (6.0, 6.0, 0.03),
    (25.0, 25.0, 0.03),
)
"""Sizes of what no figure says, in epsilons: of the smooth process and of each other law, and the
prior probability of both."""

WIDE = 1.2
"""Width within which even the rejected may lie: beyond a factor of eleven nothing is asked."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Sized:
    """Evidence when the unnamed process has one size: its weights integrated out."""

    information: Information
    """Of named and unnamed together, the named first."""
    named: int
    """How many are named."""
    size: Array
    """Standard deviation of each weight, shape (weights,)."""
    log_prior: float
    """Logarithm of the prior probability of this size."""
    inner: Array
    """Covariance of the weights, given the named, shape (weights, weights)."""
    reduced: Information
    """Of the named alone."""


def sized(information: Information, named: int, size: Array, share: float = 1.0) -> Sized:
    """Return the evidence when each unnamed weight is N(0, size^2), as probable as `share`."""
    reduced, inner = information.with_prior(np.zeros(len(size)), size**2).first(named)
    return Sized(
        information=information,
        named=named,
        size=size,
        log_prior=math.log(share),
        inner=inner,
        reduced=reduced,
    )


def widths(named: int) -> tuple[Array, Array]:
    """Return standard deviations of the named figures under each rival, and log priors.

    Rival 0 changes nothing; then each figure alone, at each width; then all together.

    Returns:
        Shape (rivals, named), and shape (rivals,).
    """
    alone = [width * row for width in ALONE for row in np.eye(named)]
    together = [np.full(named, width) for width in TOGETHER]
    each = 0.5 * (1.0 - UNCHANGED)
    prior = [UNCHANGED] + [each / len(alone)] * len(alone) + [each / len(together)] * len(together)
    return np.array([np.zeros(named), *alone, *together]), np.log(prior)


def evidence(result: Information, width: Array) -> tuple[Array, Array, Array]:
    """Return log evidence, means and covariances of rivals with normal priors about nothing.

    Args:
        result: Of the named figures.
        width: Standard deviations, shape (rivals, named).

    Returns:
        Shapes (rivals,), (rivals, named), (rivals, named, named).
    """
    E = width[:, :, None]
    whole = np.eye(width.shape[1]) + E * result.H * width[:, None, :]
    inverse = np.linalg.inv(whole)
    covariance = E * inverse * width[:, None, :]
    mean = covariance @ result.b
    log = -0.5 * result.c + 0.5 * mean @ result.b - 0.5 * np.linalg.slogdet(whole)[1]
    return log, mean, covariance


@dataclass(frozen=True, kw_only=True, eq=False)
class ModelPosterior:
    """All rivals, weighed by what was seen."""

    parts: tuple[Sized, ...]
    """One for each size of what is not named."""
    log_weight: Array
    """Log of prior times evidence, shape (sizes, rivals)."""
    mean: Array
    """Of the named figures, shape (sizes, rivals, named)."""
    covariance: Array
    """Shape (sizes, rivals, named, named)."""

    @property
    def log_evidence(self) -> float:
        """Logarithm of p(data) under the whole mixture."""
        most = self.log_weight.max()
        return float(most + np.log(np.exp(self.log_weight - most).sum()))

    @property
    def weight(self) -> Array:
        """Posterior probability of each rival, shape (sizes, rivals)."""
        return np.asarray(np.exp(self.log_weight - self.log_evidence))

    @property
    def middle(self) -> Array:
        """Mean of all unknowns, shape (unknowns,)."""
        out = np.zeros(len(self.parts[0].information.b))
        for part, weight, mean in zip(self.parts, self.weight, self.mean, strict=True):
            p, H, b = part.named, part.information.H, part.information.b
            named = weight @ mean
            out[:p] += named
            out[p:] += (weight.sum() * b[p:] - named @ H[:p, p:]) @ part.inner
        return out

    def draws(self, count: int, rng: np.random.Generator) -> Array:
        """Return unknowns drawn from the posterior, shape (count, unknowns)."""
        weight = self.weight.ravel()
        often = rng.multinomial(count, weight / weight.sum()).reshape(self.weight.shape)
        rows = []
        for (at, rival), times in np.ndenumerate(often):
            if times:
                rows.append(self._drawn(at, rival, int(times), rng))
        return np.concatenate(rows)

    def _drawn(self, at: int, rival: int, count: int, rng: np.random.Generator) -> Array:
        part = self.parts[at]
        p, H, b = part.named, part.information.H, part.information.b
        root = _root(self.covariance[at, rival])
        named = self.mean[at, rival] + rng.standard_normal((count, p)) @ root.T
        middle = (b[p:] - named @ H[:p, p:]) @ part.inner
        chance = rng.standard_normal((count, len(b) - p)) @ _root(part.inner).T
        return np.concatenate([named, middle + chance], axis=1)


def _root(covariance: Array) -> Array:
    # A rival's covariance may have no width in some directions: no Cholesky factor.
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))


def belief(
    information: Information,
    named: int,
    unit: Array,
    smooth: int,
    sizes: Sequence[tuple[float, float, float]] = UNNAMED,
) -> ModelPosterior:
    """Return what is believed of the unknowns, given the data.

    Args:
        information: What the data say, the named figures first.
        named: How many are named.
        unit: What a width of 1 means for each of them, shape (named,).
        smooth: How many of the weights, the first, are those of the smooth process.
        sizes: Of the process and of the other laws, with the prior probability of both.
    """
    width, log_prior = widths(named)
    parts, logs, means, covariances = [], [], [], []
    others = len(information.b) - named - smooth
    for of_process, of_laws, share in sizes:
        size = np.repeat([of_process, of_laws], [smooth, others])
        part = sized(information, named, size, share)
        log, mean, covariance = evidence(part.reduced, width * unit)
        parts.append(part)
        logs.append(log + log_prior + part.log_prior)
        means.append(mean)
        covariances.append(covariance)
    return ModelPosterior(
        parts=tuple(parts),
        log_weight=np.array(logs),
        mean=np.array(means),
        covariance=np.array(covariances),
    )
