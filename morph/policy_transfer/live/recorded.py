"""Recordings of a target: for the gate and a diagnosis, but nothing is tried on them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from morph.arrays import Array
from morph.errors import TransferError
from morph.nearest import nearest
from morph.policy.observing import addresses, units
from morph.policy.policy import Policy
from morph.policy_transfer.live.watch import Watch
from morph.record.clock import period as period_of
from morph.record.recording import Channel, Recording
from morph.record.slopes import slopes
from morph.search.target import Experience, Target
from morph.sim.drive import held
from morph.task.moved import Moved
from morph.task.task import Task

CUTOFF = 0.2
"""Cutoff of the filter by which velocities are taken of positions, in shares of their rate."""


@dataclass(frozen=True, kw_only=True)
class Recorded(Target):
    """What a robot was recorded doing, as runs of a task."""

    task: Task
    """Gives the body and the control period."""
    recordings: tuple[Recording, ...]
    """What was recorded."""

    def trial(self, policy: Policy | Array, rng: np.random.Generator) -> Experience:
        """Refuse: a recording cannot be told anything.

        Raises:
            TransferError: Always.
        """
        raise TransferError(
            "nothing can be tried on recordings; they serve the gate and the diagnosis",
            where=f"{len(self.recordings)} recordings of {self.task.robot.name}",
            fix="give a live target, or take the policy to the robot and record it",
        )

    def runs(self) -> tuple[Experience, ...]:
        """Return each recording at the task's control times.

        A state between two samples is interpolated, and its noise with it; a command that
        changes within a control period counts by its mean. A velocity that was not recorded is
        the slope of its smoothed position. Loss and success are the task's, judged on what was
        recorded; a recording shorter than the task has a loss of nan, and no success.

        Raises:
            TransferError: A recording lacks a position or a command, or is too short.
        """
        model = self.task.simulator().model
        return tuple(self._run(each, model) for each in self.recordings)

    def repeated(self) -> tuple[str, ...]:
        """Return, in words, which measured channels of which recordings repeat themselves.

        A live target whose sensor does so is stopped; what is recorded may be an encoder at rest.
        Readings are looked at as a trial would see them, at the control times.
        """
        model = self.task.simulator().model
        places = addresses(self.task.robot, model)
        results = []
        for recording, run in zip(self.recordings, self.runs(), strict=True):
            state = np.concatenate([run.position, run.velocity], axis=1)
            for name, at in places.items():
                count, first = _longest(state[:, at])
                if name in recording.channels and count >= Watch().repeats:
                    results.append(
                        f"recording {recording.name}: {name} is the same number {count} times, to "
                        f"the last digit, from {run.period * first:.3g} s on: a dead sensor, or at "
                        "rest"
                    )
        return tuple(results)

    def _run(self, recording: Recording, model: Any) -> Experience:
        task, period = self.task, self.task.period
        channels = self._complete(recording)
        first = max(float(channel.time[0]) for channel in channels.values())
        last = min(float(channel.time[-1]) for channel in channels.values())
        periods = math.floor((last - first) / period + 1e-6)
        if periods < 1:
            raise TransferError(
                f"its channels last {last - first:.3g} s together, less than a control period of "
                f"{period:g} s",
                where=f"recording {recording.name}",
                fix="give a longer recording, or a task of a shorter period",
            )
        times: Array = np.asarray(first + period * np.arange(periods + 1), dtype=float)
        nq = int(model.nq)
        state = np.empty((len(times), nq + int(model.nv)))
        for name, at in addresses(task.robot, model).items():
            state[:, at] = channels[name].at(times)
        command = np.stack(
            [
                held(recording.channel(f"{each.name}.command"), first, period, periods)
                for each in task.robot.actuators
            ],
            axis=1,
        )
        position, velocity = state[:, :nq], state[:, nq:]
        loss, success = math.nan, False
        if len(position) >= task.samples:
            upto = task.samples
            moved = Moved(
                robot=task.robot,
                model=model,
                time=np.asarray(period * np.arange(upto), dtype=float),
                position=position[None, :upto],
                velocity=velocity[None, :upto],
                command=np.concatenate([command, command[-1:]])[None, :upto],
            )
            loss, success = float(task.loss(moved)[0]), bool(task.succeeded(moved)[0])
        return Experience(
            position=position,
            velocity=velocity,
            command=command,
            period=period,
            loss=loss,
            success=success,
        )

    def _complete(self, recording: Recording) -> dict[str, Channel]:
        """Return every channel of the body's state in MuJoCo's order, slopes where need be."""
        robot = self.task.robot
        commands = [f"{each.name}.command" for each in robot.actuators]
        results: dict[str, Channel] = {}
        for name in (*units(robot), *commands):
            position = recording.channels.get(name.replace(".velocity", ".position"))
            if name in recording.channels:
                results[name] = recording.channels[name]
            elif name.endswith(".velocity") and position is not None:
                results[name] = _slope(position)
            else:
                near = nearest(name, recording.channels)
                raise TransferError(
                    f"it lacks {name}; its nearest channels are {near}",
                    where=f"recording {recording.name}",
                    fix="record it, or bind it in recording.toml",
                )
        return {name: channel for name, channel in results.items() if name not in commands}


def _longest(value: Array) -> tuple[int, int]:
    """Return how many equal numbers follow one another at most, and where they begin."""
    starts = np.flatnonzero(np.concatenate([[True], np.diff(value) != 0.0]))
    counts = np.diff(np.append(starts, len(value)))
    at = int(counts.argmax())
    return int(counts[at]), int(starts[at])


def _slope(position: Channel) -> Channel:
    rate = 1.0 / period_of(position.time)
    return Channel(
        time=position.time, value=slopes(position.time, position.value, CUTOFF * rate)[1]
    )
