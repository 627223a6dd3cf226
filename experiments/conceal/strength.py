"""How much an effect changes half a second of motion, in units of the sensor's noise."""

from __future__ import annotations

import numpy as np

from experiments.conceal.equations import Array, Equations, Parameters
from experiments.conceal.laws import Laws
from experiments.conceal.march import Drive, Motion, march

WINDOW = 0.5


def strength(
    equations: Equations,
    parameters: Parameters,
    plain: Laws,
    drive: Drive,
    truth: Motion,
    offset: Array,
    noise: Array,
    *,
    step: float,
) -> Array:
    """Return each row's mean square change over the noise's, shape (rows,).

    The mechanism without the effect is restarted from the true state every
    0.5 s; the change is the true reading less its reading, over all joints.

    Args:
        equations: The mechanism.
        parameters: Its true parameters.
        plain: The laws without the effect.
        drive: The commands.
        truth: The motion with the effect.
        offset: Bias of each position's sensor, shape (joints, rows).
        noise: RMS noise of each position's sensor, shape (joints, rows).
        step: Step of the rollouts, s.
    """
    joints, rows = noise.shape
    length = round(WINDOW / truth.every)
    count = (len(truth.q) - 1) // length

    def starts(state: Array) -> Array:
        picked = state[: count * length : length]
        return picked.transpose(1, 2, 0).reshape(joints, rows * count)

    moments = np.tile(np.arange(count) * WINDOW, rows)
    laws = plain.repeated(count)
    torque = drive.repeated(count).produced(laws, moments, round(WINDOW / step), step)
    several = {name: np.repeat(value, count) for name, value in parameters.items()}
    without = march(
        equations, several, laws, torque, starts(truth.q), starts(truth.v),
        step=step, keep=truth.every,
    )  # fmt: skip
    tail = without.q[1:].reshape(length, joints, rows, count)
    true = truth.q[1 : count * length + 1].reshape(count, length, joints, rows)
    change = true.transpose(1, 2, 3, 0) - tail + offset[None, :, :, None]
    square: Array = (change / noise[None, :, :, None]) ** 2
    return np.asarray(square.mean(axis=(0, 1, 3)))
