"""From commands to motion: one march over time for all rows together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from experiments.conceal.equations import Array, Equations, Parameters, inverse, times
from experiments.conceal.friction import after_friction
from experiments.conceal.laws import Laws

STEP = 1e-4
KEEP = 1e-3


@dataclass(frozen=True, kw_only=True)
class Motion:
    """States on a regular grid, with which any instant can be found."""

    q: Array
    """Positions, shape (instants, joints, rows)."""
    v: Array
    """Velocities, shape (instants, joints, rows)."""
    every: float = KEEP
    """Time between instants, s."""

    def position(self, row: int, joint: int, when: Array) -> Array:
        """Return a joint's position at any times, s, by cubic Hermite interpolation.

        Over 1 ms the error is below (1 ms)^2 / 8 times a jump in acceleration:
        1e-5 rad at 100 rad/s2, far below an encoder's step.
        """
        place = np.clip(when / self.every, 0, len(self.q) - 1 - 1e-9)
        i = place.astype(int)
        s = place - i
        q, v = self.q[:, joint, row], self.v[:, joint, row] * self.every
        rise = q[i + 1] - q[i]
        return np.asarray(
            q[i]
            + s * v[i]
            + s**2 * (3 * rise - 2 * v[i] - v[i + 1])
            + s**3 * (v[i] + v[i + 1] - 2 * rise)
        )


@dataclass(frozen=True, kw_only=True)
class Drive:
    """Commands held from tick to tick, one clock per row."""

    ticks: tuple[Array, ...]
    """When each row's logger writes and sends, s."""
    commands: tuple[Array, ...]
    """What it sends, shape (joints, ticks) for each row; 0 where nothing drives."""

    def produced(self, laws: Laws, start: Array, steps: int, step: float) -> Array:
        """Return the mean torque over each step, shape (steps, joints, rows).

        The command's integral is piecewise linear in time, so its mean over a
        step is exact, delay included; the lag is an exact first-order filter.
        """
        joints, rows = laws.gain.shape
        out = np.zeros((steps, joints, rows))
        edges = np.arange(steps + 1) * step
        for row, (ticks, commands) in enumerate(zip(self.ticks, self.commands, strict=True)):
            far = np.append(ticks, ticks[-1] + 100.0)
            for joint in np.flatnonzero(np.abs(commands).any(axis=1)):
                area = np.append(0.0, np.cumsum(commands[joint] * np.diff(far)))
                moment = start[row] + edges - laws.delay[joint, row]
                mean = np.diff(np.interp(moment, far, area)) / step
                lag = laws.lag[joint, row]
                if lag > 0:
                    blend = -np.expm1(-step / lag)
                    mean = lfilter([blend], [1.0, blend - 1.0], mean)
                out[:, joint, row] = laws.gain[joint, row] * mean
        return out

    def repeated(self, count: int) -> Drive:
        """Return each row `count` times in succession."""
        return Drive(
            ticks=tuple(t for t in self.ticks for _ in range(count)),
            commands=tuple(c for c in self.commands for _ in range(count)),
        )


def march(
    equations: Equations,
    parameters: Parameters,
    laws: Laws,
    torque: Array,
    q: Array,
    v: Array,
    *,
    step: float = STEP,
    keep: float = KEEP,
) -> Motion:
    """Return the motion under torques that are constant over each step.

    Position Verlet, second order in the step: half a drift, one evaluation of the
    accelerations with the velocity extrapolated to the middle, dry friction as
    an impulse, half a drift. A joint that sticks does not drift at all.

    Args:
        equations: The mechanism.
        parameters: Its true parameters, each of shape (rows,).
        laws: What is left out of its description.
        torque: Produced torques, shape (steps, joints, rows).
        q: Positions at the start, shape (joints, rows).
        v: Velocities at the start, shape (joints, rows).
        step: Length of a step, s.
        keep: How often the state is kept, s; a multiple of the step.
    """
    p = with_armature(equations, parameters, laws)
    dry, every = laws.dry, round(keep / step)
    q, v, before = q.copy(), v.copy(), v.copy()
    kept_q, kept_v = [q.copy()], [v.copy()]
    for number, tau in enumerate(torque, start=1):
        middle = q + 0.5 * step * v
        speed = 1.5 * v - 0.5 * before
        inv = inverse(equations.mass(middle, p))
        force = tau + laws.smooth(middle, speed) - equations.bias(middle, speed, p)
        before = v
        v = v + step * times(inv, force)
        if dry:
            v = after_friction(v, inv, step * laws.level(before))
        q = middle + 0.5 * step * v
        if number % every == 0:
            kept_q.append(q)
            kept_v.append(v)
    return Motion(q=np.array(kept_q), v=np.array(kept_v), every=keep)


def with_armature(equations: Equations, parameters: Parameters, laws: Laws) -> Parameters:
    """Return the parameters with the left-out rotor inertias added."""
    extra = {
        f"J_{joint}": parameters[f"J_{joint}"] + laws.armature[i]
        for i, joint in enumerate(equations.joints)
    }
    return {**parameters, **extra}
