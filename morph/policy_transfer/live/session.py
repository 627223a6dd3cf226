"""One trial on a live target, from its first state to its last or to the stop."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

import numpy as np

from morph.arrays import Array
from morph.policy_transfer.live.connection import Connection, Heard
from morph.policy_transfer.live.limits import LimitGuard
from morph.policy_transfer.live.protocol import Hello, number
from morph.policy_transfer.live.stop import Stop
from morph.policy_transfer.live.watch import Watch, Watcher
from morph.policy_transfer.live.wiring import Wiring
from morph.task.task import Task

SLICE = 0.01
"""Longest time for which the stop button is not looked at, s."""

Asked = Callable[[Array, Array, int], Array]
"""From `qpos` (nq,), `qvel` (nv,) and the number of the sample to commands (nu,)."""


class Ended(Exception):
    """A trial ends before its time.

    Args:
        why: In words.
        pressed: Whether somebody asked for it.
        beyond: Whether the body is beyond a limit.
    """

    def __init__(self, why: str, *, pressed: bool = False, beyond: bool = False) -> None:
        super().__init__(why)
        self.why, self.pressed, self.beyond = why, pressed, beyond


class TrialSession:
    """One trial: what came, and what was told.

    Args:
        task: What is tried.
        model: The compiled `mujoco.MjModel` of its body.
        connection: The target, open.
        hello: What it said of itself.
        wiring: Its channels as the body's.
        guard: The limits.
        watch: What is taken for wrong.
        stop: The button.
        act: What is commanded at each sample.
    """

    def __init__(
        self,
        task: Task,
        model: object,
        *,
        connection: Connection,
        hello: Hello,
        wiring: Wiring,
        guard: LimitGuard,
        watch: Watch,
        stop: Stop,
        act: Asked,
    ) -> None:
        self._task, self._connection, self._clock = task, connection, hello.clock
        self._wiring, self._guard, self._watch, self._stop = wiring, guard, watch, stop
        self._act = act
        self.watcher = Watcher(watch, task.robot, model, task.period, timed=hello.clock == "target")
        self._begin = task.start.sample(task.robot, model, 1, None)
        self._model = model
        self.position: list[Array] = []
        self.velocity: list[Array] = []
        self.command: list[Array] = []
        self.time: list[float] = []
        self.overruns = self.clipped = self.commanded = self.unreadable = 0
        self.slowest = 0.0
        self._spare: Heard | None = None

    def run(self, number_of_trial: int) -> None:
        """Run it to its end.

        Raises:
            Ended: Something is wrong, or the button was pressed.
        """
        task = self._task
        self._connection.begin(
            {"trial": number_of_trial, "samples": task.samples, "period_s": task.period}
        )
        while len(self.position) < task.samples:
            self._take(self._next())
            if len(self.position) == task.samples:
                return
            self._answer()

    def _next(self) -> Heard:
        """Return the next state, or end."""
        patience = self._watch.answer_within if self.position else self._watch.begin_within
        until = time.monotonic() + patience
        while True:
            pressed = self._stop.pressed()
            if pressed:
                raise Ended(f"the stop button was pressed {pressed}", pressed=True)
            left = until - time.monotonic()
            heard, self._spare = self._spare, None
            heard = heard or self._connection.hear(min(SLICE, max(left, 0.0)))
            if heard is None:
                if left <= 0.0:
                    raise Ended(f"it stopped answering: no state came within {patience:g} s")
                continue
            if self._is_state(heard):
                return heard

    def _is_state(self, heard: Heard) -> bool:
        if heard.ended:
            raise Ended(heard.ended)
        if "error" in heard.said:
            raise Ended(f"it says: {str(heard.said['error'])[:200]!r}")
        if isinstance(heard.said.get("state"), dict):
            return True
        self.unreadable += 1
        if self.unreadable > self._watch.unreadable:
            why = heard.unreadable or "a message without a state"
            raise Ended(f"{self.unreadable} lines are no states, the last: {why}")
        return False

    def _take(self, heard: Heard) -> None:
        """Look at a state, and keep it if it is one."""
        q, v = self._wiring.state(heard.said["state"])
        missing = self._wiring.missing(q, v)
        if missing:
            raise Ended(f"{', '.join(missing)} is no finite number: a dead sensor")
        stamp = number(heard.said["t"]) if "t" in heard.said else None
        wrong = self.watcher.saw(np.concatenate([q, v]), stamp, heard.at)
        first = not self.position
        self.position.append(q)
        self.velocity.append(v)
        self.time.append(heard.at if stamp is None or math.isnan(stamp) else stamp)
        self._came = heard.at
        wrong = wrong or (self._astray(q, v) if first else None)
        if wrong:
            raise Ended(wrong)
        breach = self._guard.breach(q, v)
        if breach:
            raise Ended(breach, beyond=True)

    def _answer(self) -> None:
        """Tell what the policy commands at the newest state, within the limits."""
        at = len(self.position) - 1
        q, v = self.position[-1], self.velocity[-1]
        before = self.command[-1] if self.command else self._guard.rest(q)
        requested = np.asarray(self._act(q, v, at), dtype=float)
        if requested.shape != before.shape or not np.isfinite(requested).all():
            raise Ended(f"the policy commands {requested.tolist()}, not a number for each actuator")
        if self._behind() and self.command:
            self.overruns += 1
            self.command.append(before)
            return
        command, held = self._guard.allowed(requested, before)
        self.clipped += int(held.sum())
        self.commanded += 1
        self._connection.tell(self._wiring.told(command))
        self.command.append(command)
        self.slowest = max(self.slowest, time.monotonic() - self._came)

    def _behind(self) -> bool:
        """Return whether the next state is there before this one is answered."""
        if self._clock != "target":
            return False
        heard = self._connection.hear(0.0)
        if heard is None:
            return False
        # An end, or a line that is none, is met in its turn.
        self._spare = heard
        return isinstance(heard.said.get("state"), dict)

    def _astray(self, q: Array, v: Array) -> str | None:
        """Return how far a first state is from where the task begins, if it is too far."""
        most = self._watch.start_within
        if most is None:
            return None
        for joint in self._task.robot.joints:
            if joint.kind not in {"hinge", "slide"}:
                continue
            here = self._model.joint(joint.name)  # type: ignore[attr-defined]
            at, rate = int(here.qposadr[0]), int(here.dofadr[0])
            off = float(q[at] - self._begin[0][0, at])
            if joint.kind == "hinge" and joint.limits is None:
                off = math.remainder(off, 2.0 * math.pi)
            speed = float(v[rate] - self._begin[1][0, rate])
            if abs(off) > most or abs(speed) > most:
                return (
                    f"{joint.name} begins {off:.3g} {joint.unit} and {speed:.3g} {joint.unit}/s "
                    f"from where the task begins, more than {most:g}"
                )
        return None
