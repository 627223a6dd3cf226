"""What no figure of a model says, in a few numbers: a smooth process, frictions, late commands."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array

WAVES = 12
"""Random waves for each joint."""

LENGTH = 1.5
"""Length scale of the process, in standard deviations of each state and command of the runs."""

SHARP = 10.0
"""Dry friction is c tanh(10 v / v_usual): at a tenth of its usual speed three quarters of c."""

FASTEST = 4.0
"""Speed, in deviations of the runs, beyond which friction is taken as it is there: a law that was
never seen so fast may not drive a body to infinity."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Unnamed:
    """Changes of a state in one control period, one for each weight of what is not named.

    The first weights belong to random waves: with w_k ~ N(0, 1 / length^2) and b_k uniform,
    f(x) = sqrt(2 / K) sum_k beta_k cos(w_k x + b_k) and beta_k ~ N(0, 1) has about the covariance
    exp(-|x - x'|^2 / (2 length^2)), one such process for the acceleration of each joint. The
    others belong to forces of every joint (dry, viscous and quadratic friction) and to commands
    that arrive a period late, passed on by the masses of the model.

    Source: Rahimi and Recht 2007, Random features for large-scale kernel machines, algorithm 1.
    """

    epsilon: Array
    """Unit of errors, of each state, shape (2 nv,)."""
    period: float
    """Control period, s."""
    middle: Array
    """Subtracted from a state with its command, shape (2 nv + nu,)."""
    spread: Array
    """What the rest is divided by."""
    frequency: Array
    """w, shape (2 nv + nu, K)."""
    phase: Array
    """b, shape (K,)."""
    usual: Array
    """What each force is divided by, so that its greatest effect on the runs has an RMS of one
    epsilon, shape (3 nv + 1,)."""

    @property
    def smooth(self) -> int:
        """How many weights, the first, are those of the smooth process."""
        return len(self.epsilon) // 2 * len(self.phase)

    def __call__(self, model: Any, state: Array, command: Array, before: Array) -> Array:
        """Return the changes of states, with their commands and the commands a period before.

        Args:
            model: The compiled `mujoco.MjModel`.
            state: Positions and velocities, shape (points, 2 nv).
            command: Shape (points, nu).
            before: Shape (points, nu).

        Returns:
            Shape (points, 2 nv, weights).
        """
        forced = forces(model, state, command, before, self.spread) / self.usual
        smooth = self._smooth(np.concatenate([state, command], axis=1))
        faster = np.concatenate([smooth, self.period * forced], axis=2)
        # An acceleration that is constant over a period moves a position by half of it.
        return np.concatenate([0.5 * self.period * faster, faster], axis=1)

    def _smooth(self, inputs: Array) -> Array:
        angle = ((inputs - self.middle) / self.spread) @ self.frequency + self.phase
        wave = np.sqrt(2.0 / len(self.phase)) * np.cos(angle)
        joints = len(self.epsilon) // 2
        out = np.zeros((len(inputs), joints, joints, wave.shape[1]))
        for joint in range(joints):
            out[:, joint, joint] = self.epsilon[joints + joint] * wave
        return out.reshape(len(inputs), joints, -1)


def unnamed(
    model: Any, state: Array, command: Array, before: Array, *, epsilon: Array, period: float
) -> Unnamed:
    """Return what is not named, scaled to what runs visited; the same runs give the same waves."""
    # Which waves is no question of chance for the user: a verdict is the same every time.
    rng = np.random.default_rng(12)
    inputs = np.concatenate([state, command], axis=1)
    spread = inputs.std(axis=0) + 1e-9
    change = period * forces(model, state, command, before, spread)
    greatest = np.abs(change / epsilon[model.nv :, None]).max(axis=1)
    usual = np.sqrt(np.mean(greatest**2, axis=0))
    return Unnamed(
        epsilon=epsilon,
        period=period,
        middle=inputs.mean(axis=0),
        spread=spread,
        frequency=rng.normal(scale=1.0 / LENGTH, size=(inputs.shape[1], WAVES)),
        phase=rng.uniform(0.0, 2.0 * np.pi, size=WAVES),
        usual=np.where(usual > 0.0, usual, 1.0),
    )


def forces(model: Any, state: Array, command: Array, before: Array, spread: Array) -> Array:
    """Return accelerations by frictions of each joint and by late commands.

    Returns:
        Shape (points, nv, 3 nv + 1): dry, viscous, quadratic, late.
    """
    nv = model.nv
    relative = np.clip(state[:, nv:] / spread[nv : 2 * nv], -FASTEST, FASTEST)
    shapes = (np.tanh(SHARP * relative), relative, relative * np.abs(relative))
    data, unit = mujoco.MjData(model), np.eye(nv)
    inverse, late = np.empty((len(state), nv, nv)), np.empty((len(state), nv))
    for at, place in enumerate(state):
        data.qpos[:], data.qvel[:] = place[:nv], place[nv:]
        data.ctrl[:] = before[at]
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        mujoco.mj_fwdActuation(model, data)
        late[at] = data.qfrc_actuator
        data.ctrl[:] = command[at]
        mujoco.mj_fwdActuation(model, data)
        late[at] -= data.qfrc_actuator
        mujoco.mj_solveM(model, data, inverse[at], unit)
    columns = [-inverse[:, :, joint] * law[:, joint, None] for law in shapes for joint in range(nv)]
    return np.stack([*columns, np.einsum("tij,tj->ti", inverse, late)], axis=2)
