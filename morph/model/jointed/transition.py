"""What trials showed, one control period each: from which state, under which command, to which."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from morph.arrays import Array, Integers
from morph.errors import SearchError

FEWEST = 8
"""Fewest periods from which anything is learned."""


@dataclass(frozen=True, kw_only=True, eq=False)
class JointTransitions:
    """Control periods of a body whose velocities are the rates of its positions."""

    position: Array
    """Where each began, shape (n, joints)."""
    velocity: Array
    """How fast, shape (n, joints)."""
    command: Array
    """What was held through it, shape (n, commands)."""
    next_position: Array
    """Where it ended, shape (n, joints)."""
    next_velocity: Array
    """How fast, shape (n, joints)."""
    period: float
    """How long it lasted, s."""

    def __post_init__(self) -> None:
        """Check shapes and numbers."""
        n = len(self.command)
        each = (self.position, self.velocity, self.next_position, self.next_velocity)
        joints = self.position.shape[-1]
        where = "the periods to learn from"
        if n < FEWEST:
            raise SearchError(
                f"there are {n} control periods, and {FEWEST} are the fewest",
                where=where,
                fix="give longer trials, or more of them",
            )
        if any(a.shape != (n, joints) for a in each) or self.command.ndim != 2:
            raise SearchError(
                f"positions and velocities have the shapes {[a.shape for a in each]}",
                where=where,
                fix="give one row a period, with as many velocities as positions",
            )
        if not all(np.isfinite(a).all() for a in (*each, self.command)):
            raise SearchError(
                "a state or a command is no finite number",
                where=where,
                fix="leave out the trial in which a sensor failed",
            )

    @property
    def acceleration(self) -> Array:
        """Mean acceleration through each period, shape (n, joints)."""
        return (self.next_velocity - self.velocity) / self.period

    @property
    def middle(self) -> tuple[Array, Array]:
        """Position and velocity in the middle of each period, shape (n, joints) each.

        The position is that of the cubic through both ends, which errs by h^4 / 384 times the
        fourth derivative; the mean velocity errs by h^2 / 8 times the second derivative of the
        velocity, which the fit corrects.
        """
        bend = (self.next_velocity - self.velocity) * self.period / 8.0
        position = 0.5 * (self.position + self.next_position) - bend
        return position, 0.5 * (self.velocity + self.next_velocity)

    def slower(
        self, turning: tuple[int, ...], farthest: float, names: tuple[str, ...] = ()
    ) -> JointTransitions:
        """Return the periods in which no joint turned farther than so many rad.

        Args:
            turning: The joints that turn.
            farthest: By how much they may, rad.
            names: What the joints are called, for the message.

        Raises:
            SearchError: Too few are left.
        """
        joints = list(turning)
        moved = np.abs(self.next_position - self.position)[:, joints]
        kept = moved.max(axis=1, initial=0.0) <= farthest
        if int(kept.sum()) < FEWEST:
            most = int((moved > farthest).sum(axis=0).argmax())
            which = f"joint {names[joints[most]]!r}" if names else "a joint"
            raise SearchError(
                f"in {int((~kept).sum())} of {len(kept)} control periods {which} turned by more "
                f"than {farthest:g} rad",
                where="the periods to learn from",
                fix="begin with weaker random commands, or take a shorter control period",
            )
        return self.rows(np.flatnonzero(kept))

    def thinned(self, most: int) -> JointTransitions:
        """Return at most so many of them, evenly spread."""
        if len(self.command) <= most:
            return self
        return self.rows(np.linspace(0.0, len(self.command) - 1.0, most).round().astype(np.int64))

    def rows(self, which: Integers) -> JointTransitions:
        """Return some of them."""
        parts = {name: value[which] for name, value in vars(self).items() if name != "period"}
        return JointTransitions(**parts, period=self.period)

    def position_noise(self, velocity_noise: Array) -> Array:
        """Return the standard deviation of the positions' noise, shape (joints,).

        q' - q - h (v + v') / 2 has the variance 2 s^2 + h^2 r^2 / 2, if s is the noise of
        positions and r that of velocities. The median of its size is taken, 0.6745 standard
        deviations of a Gaussian, as the trapezium errs where the body is jerked.
        """
        h = self.period
        mean = 0.5 * (self.velocity + self.next_velocity)
        off = np.abs(self.next_position - self.position - h * mean)
        variance = (np.median(off, axis=0) / 0.6745) ** 2
        return np.sqrt(np.maximum(variance - 0.5 * (h * velocity_noise) ** 2, 0.0) / 2.0)


def transitions(runs: Sequence[tuple[Array, Array, Array]], period: float) -> JointTransitions:
    """Return the control periods of several runs, one after another.

    Args:
        runs: Positions (samples, joints), velocities (samples, joints) and commands
            (samples - 1, commands) of each.
        period: Time from one sample to the next, s.

    Raises:
        SearchError: There are too few, or a number is not finite.
    """
    if not runs:
        raise SearchError(
            "there is no run", where="the periods to learn from", fix="give one trial or more"
        )
    return JointTransitions(
        position=np.concatenate([q[:-1] for q, _, _ in runs]),
        velocity=np.concatenate([v[:-1] for _, v, _ in runs]),
        command=np.concatenate([u for _, _, u in runs]),
        next_position=np.concatenate([q[1:] for q, _, _ in runs]),
        next_velocity=np.concatenate([v[1:] for _, v, _ in runs]),
        period=period,
    )
