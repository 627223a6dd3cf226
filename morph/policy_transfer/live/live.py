"""A target that really moves, tried through a connection, watched and held safe."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import Any

import numpy as np

from morph.arrays import Array
from morph.errors import SimulationFailed, TransferError, TrialStopped
from morph.policy.observing import Observer
from morph.policy.policy import Policy
from morph.policy_transfer.live.actuator_gain_check import heed_of
from morph.policy_transfer.live.conduct import Conduct, odd_velocities
from morph.policy_transfer.live.connection import Connection
from morph.policy_transfer.live.delay import Delay, delay_of
from morph.policy_transfer.live.limits import LimitGuard, Limits
from morph.policy_transfer.live.session import Asked, Ended, TrialSession
from morph.policy_transfer.live.stop import Stop
from morph.policy_transfer.live.trial_recordings import last_kept, write_trial
from morph.policy_transfer.live.watch import Watch
from morph.policy_transfer.live.wiring import Wiring
from morph.search.evaluate import check_period
from morph.search.target import Experience, Target
from morph.task.moved import Moved
from morph.task.task import UNSTABLE, Task

CLIPPED = 0.1
"""Share of a trial's commands beyond which it is said that they were clipped."""


class Live(Target):
    """A robot, or whatever else answers through a connection.

    What a trial cost, and whether it succeeded, is judged by the task on the states as they are
    reported, noise included: there is no referee who knows better.

    Args:
        task: What is tried; it gives the body, the start, the control period and the length.
        connection: How the target is spoken with.
        limits: How far it may be driven.
        watch: What is taken for wrong.
        stop: The stop button; signals alone if left out.
        keep: A folder in which every trial is kept as a recording, however it ends.
    """

    def __init__(
        self,
        task: Task,
        connection: Connection,
        *,
        limits: Limits | None = None,
        watch: Watch | None = None,
        stop: Stop | None = None,
        keep: Path | None = None,
    ) -> None:
        self.task, self.connection, self.keep = task, connection, keep
        self._watch, self._stop = watch or Watch(), stop or Stop()
        self._simulator = task.simulator()
        model = self._simulator.model
        self._guard = LimitGuard(limits or Limits(), task.robot, model, task.period)
        self._trials = last_kept(keep)
        self.conduct: Conduct | None = None
        """How the target behaved in the last trial; None before the first."""

    def trial(self, policy: Policy | Array, rng: np.random.Generator) -> Experience:
        """Return one run; the target is told to stop at its end, whatever the end is.

        Args:
            policy: A policy, or a command for each control period, shape (periods, nu).
            rng: Not drawn from: the world's chance is its own.

        Raises:
            TransferError: The target cannot be spoken with, or is not of this body.
            TrialStopped: The trial ended early; the error holds what it showed.
            SearchError: The policy's control period is not the task's.
        """
        act = self._asked(policy)
        connection, model = self.connection, self._simulator.model
        with self._stop.armed():
            hello = connection.open(self._watch.open_within)
            try:
                session = TrialSession(
                    self.task,
                    model,
                    connection=connection,
                    hello=hello,
                    wiring=self._wiring(hello),
                    guard=self._guard,
                    watch=self._watch,
                    stop=self._stop,
                    act=act,
                )
            except TransferError:
                connection.close()
                raise
            ended: Ended | None = None
            self._trials += 1
            safe = False
            try:
                session.run(self._trials)
            except Ended as why:
                ended = why
            finally:
                # An error of ours must not leave the target moving either.
                safe = connection.stop(self._watch.stop_within)
                if not safe:
                    connection.close()
        return self._concluded(session, ended, safe=safe)

    def close(self) -> None:
        """Let the target go."""
        self.connection.close()

    def _wiring(self, hello: Any) -> Wiring:
        task, model = self.task, self._simulator.model
        wiring = Wiring(task.robot, model, hello, period=task.period, where=self.connection.name)
        self._unused = wiring.unused
        return wiring

    def _asked(self, policy: Policy | Array) -> Asked:
        if not isinstance(policy, Policy):
            command = np.asarray(policy, dtype=float)
            return lambda q, v, at: command[min(at, len(command) - 1)]
        check_period(policy, self.task)
        observer = Observer(policy, self.task.robot, self._simulator.model, 1)
        period = self.task.period
        return lambda q, v, at: policy.act(observer.see(q[None], v[None]), np.full(1, at * period))[
            0
        ]

    def _concluded(self, session: TrialSession, ended: Ended | None, *, safe: bool) -> Experience:
        """Return what a trial showed, or raise why it ended early, once all is kept."""
        whole = ended is None
        shown = self._shown(session, whole=whole) if len(session.position) > 1 else None
        delay = None if shown is None else self._delay(shown)
        self.conduct = self._conduct(session, ended, shown, delay, safe=safe)
        if shown is not None and self.keep is not None:
            clock = np.array(session.time) - session.time[0]
            write_trial(
                shown, clock, self.task.robot, self._simulator.model, self.keep, self._trials
            )
        if ended is not None:
            raise self._stopped(ended, shown, safe=safe)
        most = self._watch.delay
        if delay is not None and most is not None and delay.seconds - 3.0 * delay.error > most:
            why = f"commands are obeyed {delay.seconds:.3g} s late (+- {delay.error:.2g})"
            raise self._stopped(Ended(f"{why}, more than {most:g} s"), shown, safe=safe)
        if shown is None:
            raise TransferError(
                "a trial of one state shows nothing",
                where=f"task {self.task.name}",
                fix="give the task a horizon of two control periods or more",
            )
        return shown

    def _shown(self, session: TrialSession, *, whole: bool) -> Experience:
        task = self.task
        position, velocity = np.array(session.position), np.array(session.velocity)
        # The last state of a trial that ended early may or may not have been answered.
        command = np.array(session.command[: len(position) - 1])
        loss, success = UNSTABLE, False
        if whole:
            moved = Moved(
                robot=task.robot,
                model=self._simulator.model,
                time=np.asarray(task.period * np.arange(task.samples), dtype=float),
                position=position[None],
                velocity=velocity[None],
                command=np.concatenate([command, command[-1:]])[None],
            )
            loss, success = float(task.loss(moved)[0]), bool(task.succeeded(moved)[0])
        return Experience(
            position=position,
            velocity=velocity,
            command=command,
            period=task.period,
            loss=loss,
            success=success,
        )

    def _delay(self, shown: Experience) -> Delay | None:
        try:
            return delay_of(
                self._simulator, shown.position, shown.velocity, shown.command, shown.period
            )
        except SimulationFailed:
            # States that nothing can be simulated from tell no delay, and have to be reported.
            return None

    def _conduct(
        self,
        session: TrialSession,
        ended: Ended | None,
        shown: Experience | None,
        delay: Delay | None,
        *,
        safe: bool,
    ) -> Conduct:
        notes = [f"{name} is not a channel of the body and is not used" for name in self._unused]
        if shown is not None:
            model, robot = self._simulator.model, self.task.robot
            notes += odd_velocities(robot, model, shown.position, shown.velocity, shown.period)
        if delay is not None and delay.certain:
            notes.append(
                f"commands are obeyed {delay.seconds:.3g} s late (+- {delay.error:.2g} s), by the "
                "body as it is described"
            )
        notes += self._obeyed(session, shown)
        if not safe:
            notes.append("it did not say that it stopped, and was let go")
        return Conduct(
            samples=len(session.position),
            wanted=self.task.samples,
            stopped="" if ended is None else ended.why,
            safe=safe,
            overruns=session.overruns,
            slowest=session.slowest,
            irregular=session.watcher.irregular,
            latest=session.watcher.latest,
            clipped=session.clipped,
            unreadable=session.unreadable,
            delay=None if delay is None else delay.seconds,
            delay_error=None if delay is None else delay.error,
            notes=tuple(notes),
        )

    def _obeyed(self, session: TrialSession, shown: Experience | None) -> list[str]:
        """Return, in words, what was held back of the policy, and whether the rest was heeded."""
        notes = []
        count = session.commanded * len(self.task.robot.actuators)
        if session.clipped > CLIPPED * count:
            notes.append(
                f"{session.clipped} of {count} commands were clipped: the policy was made for "
                "wider bounds"
            )
        heed = None
        if shown is not None:
            with contextlib.suppress(SimulationFailed):
                heed = heed_of(
                    self._simulator, shown.position, shown.velocity, shown.command, shown.period
                )
        if heed is not None and heed.ignored:
            notes.append(
                f"the target seems not to follow its commands: {heed.share:.2g} (+- "
                f"{heed.error:.2g}) of what they should do by the body as it is described is seen"
            )
        elif heed is not None and heed.opposite:
            notes.append(
                f"the target moves against its commands: {heed.share:.2g} (+- {heed.error:.2g}) "
                "of what they should do is seen; a sign is swapped"
            )
        return notes

    def _stopped(self, ended: Ended, shown: Experience | None, *, safe: bool) -> TrialStopped:
        samples = 0 if shown is None else len(shown.position)
        kept = f"{samples} of {self.task.samples} states are kept"
        how = "said that it stopped" if safe else "did not say that it stopped, and was let go"
        return TrialStopped(
            f"{ended.why}; {kept}, and the target {how}",
            where=f"{self.connection.name}, trial {self._trials}",
            fix="go on when it is safe to"
            if ended.pressed
            else "put the target right, and try again",
            shown=shown,
            pressed=ended.pressed,
            beyond=ended.beyond,
        )
