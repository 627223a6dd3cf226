"""Whether a live target still answers, keeps time and has live sensors."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.errors import TransferError
from morph.policy.observing import addresses


@dataclass(frozen=True, kw_only=True)
class Watch:
    """What is taken for wrong in what a live target says."""

    open_within: float = 10.0
    """Longest time that a target may take to say who it is, s."""
    begin_within: float = 60.0
    """Longest time to its first state, s: it may have to be put back by hand."""
    answer_within: float = 0.5
    """Longest time from a command to the next state, s; then it has stopped answering."""
    stop_within: float = 1.0
    """Longest time to say that it stopped, s."""
    start_within: float | None = 0.2
    """How far a joint may be from where the task begins, rad or m, and per s; None for anywhere."""
    repeats: int = 10
    """Readings of a channel that are alike to the last digit and mean that it is dead; 0 if such
    readings mean nothing, as those of an encoder at rest."""
    irregular: float = 0.1
    """Share of the period by which a state may be early or late before it counts as irregular."""
    lost: float = 0.5
    """Share of the period by which a state may be late; beyond it one is lost: that is the end."""
    unreadable: int = 20
    """Lines in a trial that may be no messages."""
    delay: float | None = None
    """Longest delay of commands, s, that is not refused; None to say it and refuse none."""

    def __post_init__(self) -> None:
        """Check the numbers."""
        times = (self.open_within, self.begin_within, self.answer_within, self.stop_within)
        if not all(0.0 < each < math.inf for each in times):
            raise TransferError(
                f"of its times, {min(times):g} to {max(times):g} s, one is none",
                where="watch of a live target",
                fix="give times above 0",
            )
        if not (0 <= self.irregular <= self.lost < 1 and self.repeats != 1 and self.repeats >= 0):
            raise TransferError(
                f"irregular is {self.irregular:g}, lost is {self.lost:g}, repeats is "
                f"{self.repeats}",
                where="watch of a live target",
                fix="give shares of a period below 1, lost the greater, and repeats 0 or 2 or more",
            )


class Watcher:
    """Watches the states of one trial as they come.

    Args:
        watch: What is taken for wrong.
        robot: The body.
        model: Its compiled `mujoco.MjModel`.
        period: Time from one state to the next, s.
        timed: Whether states that say no time are timed by when they come.
    """

    def __init__(
        self, watch: Watch, robot: Robot, model: Any, period: float, *, timed: bool
    ) -> None:
        self._watch, self._period, self._timed = watch, period, timed
        self._names = list(addresses(robot, model))
        self._order = np.array(list(addresses(robot, model).values()), dtype=np.int64)
        self._last: Array | None = None
        self._alike = np.zeros(len(self._names), dtype=int)
        self._first = self._time = 0.0
        self._count = 0
        self.irregular = 0
        """How many states came early or late."""
        self.latest = 0.0
        """How late the latest state was, s, counted from the first."""

    def saw(self, state: Array, stamp: float | None, came: float) -> str | None:
        """Return what is wrong with the next state, in words; None if nothing is.

        Args:
            state: `qpos` and `qvel`, shape (nq + nv,), finite.
            stamp: The time that the target says, s; None if it says none.
            came: When the state came, s.
        """
        timed = stamp if stamp is not None else (came if self._timed else None)
        wrong = None if timed is None else self._late(timed)
        self._count += 1
        return wrong or self._dead(state[self._order])

    def _late(self, now: float) -> str | None:
        if not math.isfinite(now):
            return "its state says no time: t is no finite number"
        if self._count == 0:
            self._first = self._time = now
            return None
        gap, self._time = now - self._time, now
        self.latest = max(self.latest, now - self._first - self._count * self._period)
        off = abs(gap / self._period - 1.0)
        self.irregular += off > self._watch.irregular
        if gap <= 0.0:
            return f"its time went from {now - gap:g} to {now:g} s: states are repeated or swapped"
        if off > self._watch.lost:
            return (
                f"{gap:.4g} s lie between two states that should be {self._period:g} s apart: "
                + ("a state is lost" if gap > self._period else "its rate is another")
            )
        return None

    def _dead(self, state: Array) -> str | None:
        if self._last is not None and self._watch.repeats:
            self._alike = np.where(state == self._last, self._alike + 1, 0)
            # n readings alike are n - 1 repetitions.
            dead = np.flatnonzero(self._alike >= self._watch.repeats - 1)
            if len(dead):
                named = ", ".join(self._names[at] for at in dead)
                return (
                    f"{named} gave the same number {self._watch.repeats} times, to the last "
                    "digit: a dead sensor"
                )
        self._last = state.copy()
        return None
