"""Invertible warpings of features before an affine map: identity, curves, or a small network."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from scipy.special import erf

from morph.alignment.arrays import Array
from morph.alignment.errors import MapError

LEAST_SLOPE = 0.1
"""Least slope of a curve, and least distance of a network's Lipschitz constant from 1."""

ROUNDS = 200
"""Of the inverse of a network, whose error falls at least to 0.9 of itself in each."""

CLOSE = 1e-12
"""An inverse that moves less than this, in spreads, is found."""

NEWTON = 5
"""Rounds of the inverse of a curve; from a table, each doubles the digits."""


@dataclass(frozen=True, kw_only=True, eq=False)
class InvertibleWarp(ABC):
    """A map z(t) of numbers in their spreads, about 0, that has an inverse everywhere."""

    @property
    @abstractmethod
    def parameters(self) -> Array:
        """Its parameters, shape (p,); all 0 where z is t."""

    @property
    @abstractmethod
    def size(self) -> int:
        """How many numbers it straightens, m."""

    @abstractmethod
    def weights(self) -> Mapping[str, Array]:
        """Return all its numbers by name, as `straight_of` takes them."""

    @abstractmethod
    def value(self, t: Array) -> Array:
        """Return z, shape (rows, m)."""

    @abstractmethod
    def slope(self, t: Array) -> Array:
        """Return the slopes of z by each parameter, shape (rows, m, p)."""

    @abstractmethod
    def steep(self, t: Array) -> Array:
        """Return the slopes of z by t, shape (rows, m, m)."""

    @abstractmethod
    def at(self, parameters: Array) -> Self:
        """Return this with other parameters, mended so far that it can be inverted."""

    @abstractmethod
    def back(self, z: Array) -> Array:
        """Return t of z, shape (rows, m)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Curves(InvertibleWarp):
    """z_i = t_i + sum_kj (sqrt(pi) / 2) w erf((t_i - c_k) / w) cos(pi j (k + 1/2) / K) h_ij.

    Each number has its curve. Its slope is 1 and a sum of K Gaussian kernels of width w, whose
    heights are a sum of cosines j = 1, 2, ... along the kernels. There is no cosine 0: slopes are
    1 on the average, so that a curve cannot scale, and beyond the data, where it goes on straight.
    """

    height: Array
    """h, shape (m, cosines)."""
    centre: Array
    """c, shape (kernels,)."""
    width: float
    """w."""

    @property
    def parameters(self) -> Array:
        """h, row by row."""
        return np.asarray(self.height.ravel())

    @property
    def size(self) -> int:
        """The number of curves."""
        return len(self.height)

    def weights(self) -> Mapping[str, Array]:
        """Return heights, centres and width."""
        return {"height": self.height, "centre": self.centre, "width": np.array(self.width)}

    def value(self, t: Array) -> Array:
        """Return z."""
        return np.asarray(t + (self._steps(t) * self.height).sum(axis=-1))

    def slope(self, t: Array) -> Array:
        """Return the slopes: each curve has its own parameters."""
        steps, (m, cosines) = self._steps(t), self.height.shape
        slope = np.zeros((len(t), m, m, cosines))
        for i in range(m):
            slope[:, i, i] = steps[:, i]
        return slope.reshape(len(t), m, m * cosines)

    def steep(self, t: Array) -> Array:
        """Return the slopes by t: 1 and the kernels, on the diagonal."""
        slope = 1.0 + (self._bumps(t) * self.height).sum(axis=-1)
        return np.asarray(slope[:, :, None] * np.eye(len(self.height)))

    def at(self, parameters: Array) -> Curves:
        """Return curves with these heights, each shrunk until it is monotone."""
        height = parameters.reshape(self.height.shape)
        if not height.size:
            return self
        grid = np.linspace(self.centre[0] - 2.0, self.centre[-1] + 2.0, 101)
        least = (height @ self._bumps(grid).T).min(axis=1)
        share = np.minimum(1.0, (1.0 - LEAST_SLOPE) / np.maximum(-least, 1e-12))
        return replace(self, height=height * share[:, None])

    def back(self, z: Array) -> Array:
        """Return t of z, by Newton's rule from a table, held between what is too low and high."""
        if not self.height.size:
            return np.asarray(z)
        # A step is at most w sqrt(pi) / 2 high and a cosine 1: z - t is at most the sum of all.
        far = np.abs(self.height).sum(axis=1) * self.width * len(self.centre)
        low, high = z - far, z + far
        grid = np.linspace(2.0 * self.centre[0], 2.0 * self.centre[-1], 200)
        table = self.value(np.repeat(grid[:, None], self.size, axis=1))
        columns = [np.interp(z[:, i], table[:, i], grid) for i in range(self.size)]
        t = np.clip(np.stack(columns, axis=1), low, high)
        for _ in range(NEWTON):
            off = self.value(t) - z
            low, high = np.where(off < 0.0, t, low), np.where(off < 0.0, high, t)
            t = t - off / (1.0 + (self._bumps(t) * self.height).sum(axis=-1))
            t = np.where((t < low) | (t > high), 0.5 * (low + high), t)
        return np.asarray(t)

    @property
    def _cosines(self) -> Array:
        kernels, cosines = len(self.centre), self.height.shape[1]
        place = (np.arange(kernels)[:, None] + 0.5) / max(kernels, 1)
        return np.asarray(np.cos(np.pi * place * np.arange(1, cosines + 1)))

    def _bumps(self, t: Array) -> Array:
        bumps = np.exp(-(((t[..., None] - self.centre) / self.width) ** 2))
        return np.asarray(bumps @ self._cosines)

    def _steps(self, t: Array) -> Array:
        half = 0.5 * np.sqrt(np.pi) * self.width
        return np.asarray(half * erf((t[..., None] - self.centre) / self.width) @ self._cosines)


def no_curves(m: int) -> Curves:
    """Return what leaves m numbers as they are."""
    return Curves(height=np.zeros((m, 0)), centre=np.zeros(0), width=1.0)


def flat_curves(m: int, cosines: int, reach: float) -> Curves:
    """Return curves that are still straight, with two kernels a cosine from -reach to reach."""
    centre = np.linspace(-reach, reach, 2 * cosines)
    width = 1.2 * float(centre[1] - centre[0])
    return Curves(height=np.zeros((m, cosines)), centre=centre, width=width)


@dataclass(frozen=True, kw_only=True, eq=False)
class NetworkWarp(InvertibleWarp):
    """z = t + V (tanh(W t + b) - tanh(b)): one hidden layer beside the straight way through.

    Source: Behrmann, Grathwohl, Chen, Duvenaud and Jacobsen 2019, ICML (a residual block whose
    branch has a Lipschitz constant below 1 is inverted by fixed-point iteration).
    """

    out: Array
    """V, shape (m, hidden)."""
    into: Array
    """W, shape (hidden, m)."""
    bias: Array
    """b, shape (hidden,)."""

    @property
    def parameters(self) -> Array:
        """V, W and b, one after another."""
        return np.concatenate([self.out.ravel(), self.into.ravel(), self.bias])

    @property
    def size(self) -> int:
        """The width of what goes in."""
        return len(self.out)

    def weights(self) -> Mapping[str, Array]:
        """Return V, W and b."""
        return {"out": self.out, "into": self.into, "bias": self.bias}

    def value(self, t: Array) -> Array:
        """Return z."""
        return np.asarray(t + self._branch(t))

    def slope(self, t: Array) -> Array:
        """Return the slopes by V, W and b."""
        (m, hidden), rows = self.out.shape, len(t)
        wave, rest = np.tanh(t @ self.into.T + self.bias), np.tanh(self.bias)
        by_out = np.zeros((rows, m, m, hidden))
        for i in range(m):
            by_out[:, i, i] = wave - rest
        steep = (1.0 - wave**2)[:, None, :] * self.out
        by_into = steep[..., None] * t[:, None, None, :]
        by_bias = steep - (1.0 - rest**2) * self.out
        parts = [by_out, by_into, by_bias]
        return np.concatenate([part.reshape(rows, m, -1) for part in parts], axis=2)

    def steep(self, t: Array) -> Array:
        """Return the slopes by t, 1 + V diag(1 - tanh^2) W."""
        bent = 1.0 - np.tanh(t @ self.into.T + self.bias) ** 2
        return np.asarray(np.eye(len(self.out)) + (self.out * bent[:, None, :]) @ self.into)

    def at(self, parameters: Array) -> NetworkWarp:
        """Return the network of these parameters, V shrunk until it can be inverted."""
        m, hidden = self.out.shape
        out, into, bias = np.split(parameters, [m * hidden, 2 * m * hidden])
        V, W = out.reshape(m, hidden), into.reshape(hidden, m)
        steep = float(np.linalg.norm(V, 2) * np.linalg.norm(W, 2))
        V = V * min(1.0, (1.0 - LEAST_SLOPE) / max(steep, 1e-12))
        return replace(self, out=V, into=W, bias=bias)

    def back(self, z: Array) -> Array:
        """Return t of z, by fixed-point iteration."""
        t = z
        for _ in range(ROUNDS):
            before, t = t, z - self._branch(t)
            if np.abs(t - before).max(initial=0.0) < CLOSE:
                break
        return np.asarray(t)

    def _branch(self, t: Array) -> Array:
        wave = np.tanh(t @ self.into.T + self.bias) - np.tanh(self.bias)
        return np.asarray(wave @ self.out.T)


def idle_network(m: int, hidden: int, rng: np.random.Generator) -> NetworkWarp:
    """Return a network of which nothing comes out yet."""
    return NetworkWarp(
        out=np.zeros((m, hidden)),
        into=rng.standard_normal((hidden, m)) / np.sqrt(m),
        bias=rng.uniform(-1.0, 1.0, size=hidden),
    )


def straight_of(weights: Mapping[str, Array]) -> InvertibleWarp:
    """Return the curves or the network that these numbers make.

    Raises:
        MapError: They make neither, or what they make cannot be inverted.
    """
    w = {name: np.asarray(value, dtype=float) for name, value in weights.items()}
    result: InvertibleWarp | None = None
    if set(w) == {"height", "centre", "width"} and w["height"].ndim == 2 and not w["width"].ndim:
        kernels, cosines = w["centre"].shape, w["height"].shape[1]
        spaced = bool((np.diff(w["centre"]) > 0.0).all()) if len(kernels) == 1 else False
        if spaced and w["width"] > 0.0 and kernels[0] == 2 * cosines:
            result = Curves(height=w["height"], centre=w["centre"], width=float(w["width"]))
    if set(w) == {"out", "into", "bias"} and w["out"].ndim == 2:
        m, hidden = w["out"].shape
        if w["into"].shape == (hidden, m) and w["bias"].shape == (hidden,):
            result = NetworkWarp(out=w["out"], into=w["into"], bias=w["bias"])
    whole = result is not None and np.isfinite(result.parameters).all()
    if result is None or not whole or not _kept(result):
        raise MapError(
            f"{', '.join(sorted(w)) or 'nothing'} makes no curves and no network with an inverse",
            where="what straightens a bent map",
            fix="give height, centre and width, or out, into and bias, as they were written",
        )
    return result


def _kept(result: InvertibleWarp) -> bool:
    """Return whether nothing has to be mended before it can be inverted."""
    mended = result.at(result.parameters).parameters
    return bool(np.allclose(mended, result.parameters, rtol=1e-6, atol=1e-12))
