"""Gaussian process from a closed-loop simulator's predictions to the transitions that follow."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import cho_solve
from scipy.optimize import minimize

from morph.arrays import Array, Integers
from morph.errors import DiagnosisError
from morph.model.latent.run import Run

Simulate = Callable[[Array, Array], Array]
"""From states (rows, n) and commands (rows, nu) to states one control period later, (rows, n)."""

MOST_NUMBERS = 3000
"""Most numbers that are learned from, periods times those of a state: 9 million covariances."""

NUDGE = 1e-4
"""Difference of a state of which the simulator's slope is made."""

WAVES = 256
"""Waves of which a function before data is drawn."""

STEPS = 40
"""Most steps of the search for the settings."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Mapped:
    """A map G from predictions to what comes: x' = G(x, u, f(x, u)) = f + g, g Gaussian processes.

    With z = (cosines and sines of the angles, other places, velocities, u, and the prediction
    likewise) over their sizes, each number of the state has a g of its own, with the covariance
    s^2 exp(-|z - z'|^2 / 2), z over lengths that are shared. The mean of G is the prediction.

    Source: Gamboa Higuera 2015, eq. 10; draws by Wilson et al. 2020, ICML, eq. 12.
    """

    simulate: Simulate
    """f."""
    angles: Integers
    """Which numbers of a state are angles."""
    center: Array
    """Middle of the inputs, shape (d,)."""
    length: Array
    """Lengths, in the inputs' units, shape (d,)."""
    signal: Array
    """s, shape (n,)."""
    jump: Array
    """Standard deviation of what stays unexplained in a period, shape (n,)."""
    noise: Array
    """Standard deviation of the observations, shape (n,)."""
    inputs: Array
    """z of the periods, shape (periods, d)."""
    missed: Array
    """What came less what was predicted, shape (periods, n)."""
    spread: Array
    """Covariance of the noise in all of `missed`, shape (periods * n,) twice."""

    @cached_property
    def factor(self) -> Array:
        """Lower Cholesky factor of the covariance of `missed`."""
        return _factor(self.inputs, self.signal, self.jump, self.spread)

    @cached_property
    def weight(self) -> Array:
        """What each period adds to the mean, shape (periods, n)."""
        solved = cho_solve((self.factor, True), self.missed.ravel())
        return np.asarray(solved.reshape(self.missed.shape) * self.signal**2)

    def look(self, state: Array, command: Array, predicted: Array) -> Array:
        """Return z."""
        raw = looked(state, command, predicted, self.angles)
        return np.asarray((raw - self.center) / self.length)

    def mean(self, state: Array, command: Array) -> Array:
        """Return what is expected one control period later, shape (rows, n)."""
        predicted = self.simulate(state, command)
        near = _alike(self.look(state, command, predicted), self.inputs)
        return np.asarray(predicted + near @ self.weight)

    def variance(self, state: Array, command: Array) -> Array:
        """Return its variance, jumps included and noise not, shape (rows, n)."""
        n = len(self.signal)
        near = _alike(self.look(state, command, self.simulate(state, command)), self.inputs)
        result = np.empty((len(state), n))
        for at in range(n):
            across = np.zeros((len(state), len(self.inputs), n))
            across[..., at] = near * self.signal[at] ** 2
            flat = across.reshape(len(state), -1)
            known = np.linalg.solve(self.factor, flat.T)
            result[:, at] = self.signal[at] ** 2 - (known**2).sum(axis=0)
        return np.maximum(result, 0.0) + self.jump**2

    def foresee(
        self, start: Array, command: Array, rng: np.random.Generator, *, draws: int = 64
    ) -> Array:
        """Return possible true states of many runs, shape (draws, runs, periods + 1, n).

        Each draw has one g of its own through all runs and periods.

        Args:
            start: Where each run begins, as observed, shape (runs, n).
            command: Shape (runs, periods, nu).
            rng: Chance.
            draws: How many of each run.
        """
        law = self._drawn(draws, rng)
        runs, count = command.shape[:2]
        now = start + self.noise * rng.normal(size=(draws, runs, start.shape[1]))
        result = np.empty((draws, runs, count + 1, start.shape[1]))
        result[:, :, 0] = now
        for at in range(count):
            commands = np.broadcast_to(command[:, at], (draws, *command[:, at].shape))
            flat = now.reshape(draws * runs, -1)
            predicted = self.simulate(flat, commands.reshape(draws * runs, -1))
            z = self.look(flat, commands.reshape(draws * runs, -1), predicted)
            more = law(z.reshape(draws, runs, -1))
            now = predicted.reshape(now.shape) + more + self.jump * rng.normal(size=now.shape)
            result[:, :, at + 1] = now
        return result

    def _drawn(self, draws: int, rng: np.random.Generator) -> Callable[[Array], Array]:
        """Return functions drawn from the posterior, from (draws, rows, d) to (draws, rows, n).

        A function drawn before the data, of waves, is put right by what it and drawn noise miss
        of the data.
        """
        n, count = len(self.signal), len(self.inputs)
        waves = rng.normal(size=(self.inputs.shape[1], WAVES))
        phase = rng.uniform(0.0, 2.0 * np.pi, WAVES)
        prior = rng.normal(size=(draws, WAVES, n)) * self.signal
        features = _waves(self.inputs, waves, phase)
        before = np.einsum("tw,dwn->dtn", features, prior)
        whole = self.spread + 1e-12 * np.eye(len(self.spread))
        noise = (np.linalg.cholesky(whole) @ rng.normal(size=(len(whole), draws))).T
        noise = noise.reshape(draws, count, n) + self.jump * rng.normal(size=(draws, count, n))
        left = (self.missed - before - noise).reshape(draws, -1)
        put = cho_solve((self.factor, True), left.T).T.reshape(draws, count, n) * self.signal**2

        def law(z: Array) -> Array:
            return np.asarray(
                np.einsum("drw,dwn->drn", _waves(z, waves, phase), prior)
                + np.einsum("drt,dtn->drn", _alike(z, self.inputs), put)
            )

        return law


def fit_map(
    simulate: Simulate, runs: Sequence[Run], noise: Array, angles: Sequence[int] = ()
) -> Mapped:
    """Return the map from a simulator's predictions to what runs show.

    Only the simulator's answers are used. The noise of an observation enters the error of the
    period that it ends and, through the simulator's slope, that of the period that it begins: all
    its covariances are in the likelihood, by which lengths, signals and jumps are chosen.

    Args:
        simulate: The simulator.
        runs: What was recorded.
        noise: Standard deviation of the observations, shape (n,).
        angles: Which numbers of a state are angles that turn.

    Raises:
        DiagnosisError: There is no run, or more than can be learned from.
    """
    n = len(noise)
    numbers = sum(len(run.command) for run in runs) * n
    if not runs or numbers > MOST_NUMBERS or any(run.state.shape[1] != n for run in runs):
        raise DiagnosisError(
            f"{len(runs)} runs have {numbers} numbers, with a noise of {n}",
            where="runs to learn a map of predictions from",
            fix=f"give runs of {n} numbers a state, with {MOST_NUMBERS} in all at most",
        )
    which = np.array(sorted(angles), dtype=np.int64)
    parts = [_periods(simulate, run, noise) for run in runs]
    state, command, predicted = (np.concatenate([p[k] for p in parts]) for k in range(3))
    missed = np.concatenate([run.state[1:] for run in runs]) - predicted
    raw = looked(state, command, predicted, which)
    size = np.maximum(raw.std(axis=0), 1e-6)
    center = raw.mean(axis=0)
    spread = _block([p[3] for p in parts])
    group = _groups(n, len(which), command.shape[1])
    logs = _settled((raw - center) / size, group, missed, spread, noise)
    groups = int(group.max()) + 1
    length = size * np.exp(logs[:groups])[group]
    scale = np.maximum(missed.std(axis=0), 1e-9)
    return Mapped(
        simulate=simulate,
        angles=which,
        center=center,
        length=length,
        signal=scale * np.exp(logs[groups : groups + n]),
        jump=noise * np.exp(logs[groups + n :]),
        noise=noise,
        inputs=(raw - center) / length,
        missed=missed,
        spread=spread,
    )


def looked(state: Array, command: Array, predicted: Array, angles: Integers) -> Array:
    """Return what a map looks at, before sizes: shape (rows, 2 n + 2 angles + nu)."""

    def seen(x: Array) -> list[Array]:
        return [np.cos(x[:, angles]), np.sin(x[:, angles]), np.delete(x, angles, axis=1)]

    return np.concatenate([*seen(state), command, *seen(predicted)], axis=1)


def _groups(n: int, angles: int, commands: int) -> Integers:
    """Return which length each input has: one for states, one for commands, one for predictions."""
    each = n + angles
    return np.array([0] * each + [1] * commands + [2] * each, dtype=np.int64)


def _periods(simulate: Simulate, run: Run, noise: Array) -> tuple[Array, Array, Array, Array]:
    """Return states, commands, predictions, and the covariance of the noise in the errors."""
    begin, count, n = run.state[:-1], len(run.command), len(noise)
    many = np.repeat(begin[:, None], n + 1, axis=1)
    many[:, 1:] += NUDGE * np.eye(n)
    end = simulate(many.reshape(-1, n), np.repeat(run.command, n + 1, axis=0))
    end = end.reshape(count, n + 1, n)
    slope = np.swapaxes(end[:, 1:] - end[:, :1], 1, 2) / NUDGE
    # The error of period t is noise_{t+1} - A_t noise_t.
    enters = np.zeros((count, n, count + 1, n))
    for at in range(count):
        enters[at, :, at + 1] = np.eye(n)
        enters[at, :, at] = -slope[at]
    flat = enters.reshape(count * n, -1) * np.tile(noise, count + 1)
    return begin, run.command, end[:, 0], flat @ flat.T


def _block(parts: Sequence[Array]) -> Array:
    whole = np.zeros((sum(map(len, parts)),) * 2)
    at = 0
    for part in parts:
        whole[at : at + len(part), at : at + len(part)] = part
        at += len(part)
    return whole


def _settled(unit: Array, group: Integers, missed: Array, spread: Array, noise: Array) -> Array:
    """Return logarithms of lengths, signals and jumps, in sizes, spreads and noises."""
    groups, n = int(group.max()) + 1, missed.shape[1]
    scale = np.maximum(missed.std(axis=0), 1e-9)
    middle = np.concatenate([np.full(groups, 1.2), np.full(n, -0.5), np.full(n, -1.5)])
    width = np.concatenate([np.full(groups, 0.7), np.full(n, 1.0), np.full(n, 1.0)])

    def unlikeliness(logs: Array) -> float:
        signal = scale * np.exp(logs[groups : groups + n])
        z = unit / np.exp(logs[:groups])[group]
        L = _factor(z, signal, noise * np.exp(logs[groups + n :]), spread)
        weight = cho_solve((L, True), missed.ravel())
        value = 0.5 * float(missed.ravel() @ weight) + float(np.log(np.diag(L)).sum())
        return value + 0.5 * float((((logs - middle) / width) ** 2).sum())

    bounds = list(zip(middle - 4.0 * width, middle + 4.0 * width, strict=True))
    result = minimize(
        unlikeliness, middle, method="L-BFGS-B", bounds=bounds, options={"maxiter": STEPS}
    )
    return np.asarray(result.x)


def _factor(z: Array, signal: Array, jump: Array, spread: Array) -> Array:
    alike, n = _alike(z, z), len(signal)
    K = spread.copy()
    for at in range(n):
        K[at::n, at::n] += signal[at] ** 2 * alike
    # A little beside the signal, as smooth functions leave a covariance that rounding breaks.
    K[np.diag_indices(len(K))] += np.tile(jump**2 + 1e-8 * signal**2, len(z))
    return np.asarray(np.linalg.cholesky(K))


def _alike(z: Array, other: Array) -> Array:
    """Return exp(-|z - z'|^2 / 2) of all pairs, shape (..., rows, others)."""
    far = np.square(z).sum(-1)[..., None] + np.square(other).sum(-1) - 2.0 * (z @ other.T)
    return np.asarray(np.exp(-0.5 * np.maximum(far, 0.0)))


def _waves(z: Array, waves: Array, phase: Array) -> Array:
    return np.asarray(np.sqrt(2.0 / WAVES) * np.cos(z @ waves + phase))
