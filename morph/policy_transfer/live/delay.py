"""How long after it is told a body obeys: commands correlated with what they should have done."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.sim.rollout import Variant, rollout
from morph.sim.simulator import Simulator

MOST_PERIODS = 4
"""Longest delay that is looked for, in control periods."""

FEWEST = 15
"""Fewest transitions that tell a delay."""


@dataclass(frozen=True, kw_only=True)
class Delay:
    """A delay, as a run shows it."""

    seconds: float
    """How late commands are, s."""
    error: float
    """Its standard error, s."""

    @property
    def certain(self) -> bool:
        """Whether there surely is one: more than three standard errors, and 5 ms."""
        return self.seconds > max(3.0 * self.error, 0.005)


def delay_of(
    simulator: Simulator, position: Array, velocity: Array, command: Array, period: float
) -> Delay | None:
    """Return by how much a body obeys late; None if the run does not tell.

    With dv_k the change of velocity over a period, as observed, and e_d what the command of d
    periods ago would change in the model of the body, dv_k - (the model's with no command) is
    fitted as sum over d of w_d e_d + c. Commands that are late by tau, held, are w_d of which
    the mean, sum d w_d / sum w_d, is tau in periods: a cross-correlation with the command's
    expected effect as its template, so that it needs no test signal.

    Args:
        simulator: The body as it is described.
        position: `qpos`, shape (samples, nq).
        velocity: `qvel`, shape (samples, nv).
        command: What was told, shape (samples - 1, nu).
        period: Time between samples, s.
    """
    result = responses(simulator, position, velocity, command, period)
    return None if result is None else _centre(*result, period)


def responses(
    simulator: Simulator, position: Array, velocity: Array, command: Array, period: float
) -> tuple[Array, Array] | None:
    """Return what commands should have changed, to fit what changed by; None of a short run.

    The arguments are those of `delay_of`.

    Returns:
        The change of velocity over each period less the model's with no command, (rows, nv), and
        what the commands of 0, 1, ... periods ago would add to it, (MOST_PERIODS + 1, rows, nv).
    """
    rows = np.arange(MOST_PERIODS, len(command))
    if len(rows) < FEWEST:
        return None
    past = np.stack([command[rows - d] for d in range(MOST_PERIODS + 1)])
    still = np.zeros_like(past[:1])
    commanded = np.concatenate([still, past])
    steps = round(period / simulator.step)
    count = len(commanded)
    _, after = rollout(
        [Variant(model=simulator.model, effects=simulator.effects)],
        np.zeros(count * len(rows), dtype=np.int64),
        np.tile(position[rows], (count, 1)),
        np.tile(velocity[rows], (count, 1)),
        np.repeat(commanded.reshape(-1, 1, commanded.shape[-1]), steps, axis=1),
    )
    reached = after[:, -1].reshape(count, len(rows), -1)
    return velocity[rows + 1] - reached[0], reached[1:] - reached[0]


def _centre(left: Array, effect: Array, period: float) -> Delay | None:
    """Return the mean delay of weights fitted to what is left (rows, nv)."""
    # Every degree of freedom counts by its own scatter, without a constant of its own.
    left = left - left.mean(axis=0)
    effect = effect - effect.mean(axis=1, keepdims=True)
    moved = effect.std(axis=(0, 1)) > 1e-9
    scale = np.where(moved, left.std(axis=0), np.inf)
    scale[scale < 1e-12] = np.inf
    y = (left / scale).ravel()
    X = (effect / scale).reshape(len(effect), -1).T
    gram = X.T @ X
    if not (np.isfinite(gram).all() and np.isfinite(y).all()) or np.linalg.cond(gram) > 1e8:
        return None
    weight = np.linalg.solve(gram, X.T @ y)
    total = float(weight.sum())
    # Commands that are not obeyed at all have no delay.
    if not total >= 0.1:
        return None
    lags = np.arange(len(weight))
    mean = float(lags @ weight) / total
    rest = y - X @ weight
    scatter = float(rest @ rest) / max(len(y) - len(weight), 1)
    slope = (lags - mean) / total
    error = float(np.sqrt(scatter * slope @ np.linalg.solve(gram, slope)))
    # A run that hardly excites leaves any delay possible.
    return Delay(seconds=period * mean, error=period * error) if error < 1.0 else None
