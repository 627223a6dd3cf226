"""Cart-poles in a formula, and others that differ from one in a single known way."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_discrete_are

from morph.alignment.arrays import Array
from morph.alignment.maps.affine_map import AffineMap
from morph.alignment.samples import Transitions

PERIOD = 0.02
"""Of control, s."""

STEPS = 250
"""Control periods of a run, 5 s."""

PUSHED = np.array([0.0, 0.0, 0.6, 0.0])
"""Speed of the cart by which a run begins, m/s."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CartPole:
    """x = (place, tilt, speed, rate of tilt) of a uniform pole on a cart that a force moves.

    (M + m) p'' + m h cos(q) q'' = u - b p' + m h q'^2 sin(q), and
    4/3 h q'' + cos(q) p'' = g sin(q), with h half the pole's length.

    Source: Barto, Sutton and Anderson 1983, IEEE SMC 13(5), appendix (its equations, and friction
    at the slide alone).
    """

    length: float = 0.5
    """Of the pole, m."""
    pole: float = 0.5
    """m, kg."""
    cart: float = 0.5
    """M, kg."""
    friction: float = 0.1
    """b, N s / m."""

    def step(self, x: Array, u: Array) -> Array:
        """Return states (m, 4) after a control period of two steps under forces (m, 1)."""
        p, q, v, w = x.T
        h = 0.5 * self.length
        for _ in range(2):
            sin, cos = np.sin(q), np.cos(q)
            push = u[:, 0] - self.friction * v + self.pole * h * w**2 * sin
            faster = (9.81 * sin - cos * push / (self.cart + self.pole)) / (
                h * (4.0 / 3.0 - self.pole * cos**2 / (self.cart + self.pole))
            )
            along = (push - self.pole * h * cos * faster) / (self.cart + self.pole)
            v, w = v + 0.5 * PERIOD * along, w + 0.5 * PERIOD * faster
            p, q = p + 0.5 * PERIOD * v, q + 0.5 * PERIOD * w
        return np.stack([p, q, v, w], axis=1)

    def gain(self) -> Array:
        """Return feedback u = K x that balances it: the linear regulator of its own slopes."""
        eye = 1e-6 * np.concatenate([np.eye(4), -np.eye(4)])
        slope = self.step(eye, np.zeros((8, 1)))
        A = (slope[:4] - slope[4:]).T / 2e-6
        B = (self.step(np.zeros((1, 4)), np.full((1, 1), 1e-3)) * 1e3).T
        Q, R = np.diag([1.0, 16.0, 0.04, 0.64]), 0.01 * np.eye(1)
        P = solve_discrete_are(A, B, Q, R)
        return np.asarray(-np.linalg.solve(R + B.T @ P @ B, B.T @ P @ A))


@dataclass(frozen=True, kw_only=True, eq=False)
class Worn:
    """A cart-pole that is seen as y = bend(T (x, e) / s) + noise, e moving by themselves.

    bend(z) = z + bend z^2: beyond |z| = 1 / (2 bend) two states look the same in a number.
    """

    body: CartPole
    """What moves."""
    basis: Array
    """T, shape (4 + extra, 4 + extra)."""
    spread: Array
    """s, of the four numbers, shape (4,)."""
    bend: float
    """How much it is bent."""
    noise: float
    """Standard deviation of every number seen, in spreads."""
    mirror: float
    """1, or -1 if commands act the other way."""

    @property
    def extra(self) -> int:
        """How many numbers move by themselves."""
        return len(self.basis) - 4

    def seen(self, x: Array, e: Array, rng: np.random.Generator) -> Array:
        """Return what is seen of states (m, 4) and the rest (m, extra)."""
        z = np.concatenate([x / self.spread, e], axis=1) @ self.basis.T
        return np.asarray(z + self.bend * z**2 + self.noise * rng.standard_normal(z.shape))

    @property
    def law(self) -> Array:
        """The true x = law y if nothing is bent, shape (4, 4 + extra)."""
        return np.asarray(self.spread[:, None] * np.linalg.inv(self.basis)[:4])

    def transitions(self, count: int, rng: np.random.Generator) -> Transitions:
        """Return so many transitions of random commands, begun anew where it has tilted far."""
        rows = []
        x, e = _begun(rng), rng.standard_normal((1, self.extra))
        now = self.seen(x, e, rng)
        for _ in range(count):
            u = 1.5 * rng.standard_normal((1, 1))
            x = self.body.step(x, self.mirror * u)
            e = 0.9 * e + np.sqrt(1.0 - 0.81) * rng.standard_normal(e.shape)
            after = self.seen(x, e, rng)
            rows.append((now[0], u[0], after[0]))
            if abs(x[0, 1]) > 0.25 or abs(x[0, 0]) > 1.0:
                x = _begun(rng)
                after = self.seen(x, e, rng)
            now = after
        state, command, following = (np.array(each) for each in zip(*rows, strict=True))
        turns = np.zeros(state.shape[1], dtype=bool)
        return Transitions(state=state, command=command, after=following, turns=turns)

    def score(self, found: AffineMap, gain: Array, rng: np.random.Generator) -> float:
        """Return how well a source's feedback balances it through a map, 0 to 1.

        The measure is that of `morph.task.upright`: the mean of a bell of tilt and place, 0 from
        the moment of a fall.
        """
        x = PUSHED + 0.02 * rng.standard_normal((12, 4))
        e = rng.standard_normal((12, self.extra))
        alive, total = np.ones(12, dtype=bool), np.zeros(12)
        for _ in range(STEPS):
            y = self.seen(x, e, rng)
            u = np.clip(found.action(y, found.state(y) @ gain.T), -20.0, 20.0)
            x = self.body.step(x, self.mirror * u)
            e = 0.9 * e + np.sqrt(1.0 - 0.81) * rng.standard_normal(e.shape)
            alive &= (np.abs(x[:, 1]) < 0.8) & (np.abs(x[:, 0]) < 3.0)
            x = np.where(alive[:, None], x, 0.0)
            bell = np.exp(-0.5 * (x[:, 1] / 0.25) ** 2 - 0.5 * x[:, 0] ** 2)
            total += np.where(alive, bell, 0.0)
        return float(total.mean() / STEPS)


def _begun(rng: np.random.Generator) -> Array:
    return np.asarray(rng.standard_normal((1, 4)) * np.array([0.1, 0.05, 0.1, 0.1]))


SPREAD = np.array([0.1, 0.1, 0.2, 0.5])
"""About how far the four numbers move under random commands."""


def worn(body: CartPole, extra: int, bend: float, noise: float, rng: np.random.Generator) -> Worn:
    """Return a body in a basis drawn by chance, half of it its own numbers with other signs."""
    n = 4 + extra
    turn = np.linalg.qr(rng.standard_normal((n, n)))[0]
    signs = np.diag(rng.choice([-1.0, 1.0], size=n))
    basis = signs @ (np.eye(n) + 0.3 * turn)
    mirror = float(rng.choice([-1.0, 1.0]))
    return Worn(body=body, basis=basis, spread=SPREAD, bend=bend, noise=noise, mirror=mirror)


def plain(body: CartPole, noise: float) -> Worn:
    """Return a body seen as it is, in its spreads."""
    return Worn(body=body, basis=np.eye(4), spread=SPREAD, bend=0.0, noise=noise, mirror=1.0)
