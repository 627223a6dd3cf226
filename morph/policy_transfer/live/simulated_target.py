"""Simulated target of `morph.policy_transfer.live.serve`, with its faults."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from morph.arrays import Array
from morph.policy.observing import addresses
from morph.policy_transfer.live.pipe_lines import Reader
from morph.policy_transfer.live.protocol import (
    LONGEST_LINE,
    Clock,
    Hello,
    Signal,
    hello_said,
    line_of,
    number,
)
from morph.policy_transfer.live.wiring import hello_for
from morph.record.units import UNITS
from morph.sim.closed_loop import closed_loop
from morph.sim.drive import sensed
from morph.sim.simulator import Simulator
from morph.task.task import Task

PATIENCE = 0.5
"""Longest time without a command after which it holds itself safe, s, if it keeps time."""

RUBBISH = (
    b"[driver] temperature 31.2\n",
    b'{"state": [1, 2\n',
    b"x" * (2 * LONGEST_LINE) + b"\n",
    b"[" * 5000 + b"\n",
    b'{"battery": 11.9}\n',
    b"\xff\xfe\x00\n",
)
"""Lines that are no messages."""


@dataclass(frozen=True, kw_only=True)
class Faults:
    """What is wrong with a target; nothing if left out."""

    unit: Mapping[str, str] = field(default_factory=dict)
    """The unit that a channel is said to be in."""
    rename: Mapping[str, str] = field(default_factory=dict)
    """What a channel or an actuator is called."""
    frozen: Mapping[str, float] = field(default_factory=dict)
    """When a channel stays as it is, s into a trial."""
    lost: Mapping[str, float] = field(default_factory=dict)
    """When a channel is no number any more, s into a trial."""
    dies: float | None = None
    """When the process ends, s into a trial."""
    hangs: float | None = None
    """When it stops answering, s into a trial."""
    skips: float | None = None
    """When one state is not sent, s into a trial."""
    rubbish: bool = False
    """Whether lines that are no messages stand between the states."""
    deaf: bool = False
    """Whether it does not say that it stopped."""


class Gone(Exception):
    """Nobody speaks with the target any more."""


class Stopped(Exception):
    """The target was told to stop."""


class Served:
    """A simulated body that speaks over file descriptors.

    Args:
        task: Gives the start, the length, the control period and the noise.
        simulator: The body.
        clock: Who keeps time.
        seed: Seed of starts and of the noise.
        faults: What is wrong with it.
    """

    def __init__(
        self, *, task: Task, simulator: Simulator, clock: Clock, seed: int, faults: Faults
    ) -> None:
        self._task, self._simulator, self._clock, self._faults = task, simulator, clock, faults
        self._seed, self._model = seed, simulator.model
        self._at = addresses(task.robot, self._model)
        self._actuators = [each.name for each in task.robot.actuators]

    def serve(self, source: int, sink: int) -> None:
        """Speak until the input ends."""
        self._reader, self._sink = Reader(source), sink
        try:
            self._send(hello_said(self._hello()))
            while True:
                statement = self._hear()
                if "begin" in statement:
                    requested = statement["begin"]
                    trial = number(requested.get("trial")) if isinstance(requested, dict) else 0.0
                    self._trial(max(round(trial), 0) if math.isfinite(trial) else 0)
                elif "stop" in statement:
                    self._confess()
        except Gone:
            return

    def _hello(self) -> Hello:
        hello = hello_for(self._task.robot, self._task.period)
        unit, rename = self._faults.unit, self._faults.rename

        def named(each: Signal) -> Signal:
            name = rename.get(each.name, each.name)
            return Signal(name=name, unit=unit.get(each.name, each.unit))

        return replace(
            hello,
            channels=tuple(named(each) for each in hello.channels),
            actuators=tuple(named(each) for each in hello.actuators),
            clock=self._clock,
        )

    def _trial(self, trial: int) -> None:
        task = self._task
        rng = np.random.default_rng([self._seed, trial])
        position, velocity = task.start.sample(task.robot, self._model, 1, rng)
        noise = rng.normal(scale=task.noise, size=(task.samples, len(self._at)))
        each = round(task.period / self._simulator.step)
        self._command = np.zeros((1, self._model.nu))
        self._held: dict[str, float] = {}
        self._start = self._heard = time.monotonic()

        def act(q: Array, v: Array, now: float) -> Array:
            step = round(now / self._simulator.step)
            self._wait(now)
            if step % each == 0:
                self._state(q[0], v[0], noise[step // each], now)
                if self._clock == "none":
                    self._obey(self._hear())
            return self._command

        try:
            loop = closed_loop(
                self._simulator,
                act,
                position,
                velocity,
                period=self._simulator.step,
                seconds=task.horizon,
            )
            self._wait(task.horizon)
            self._state(loop.position[0, -1], loop.velocity[0, -1], noise[-1], task.horizon)
        except Stopped:
            self._confess()

    def _wait(self, now: float) -> None:
        """Wait until a time of the trial, s, and obey what was said until then."""
        if self._clock == "none":
            return
        left = self._start + now - time.monotonic()
        if left > 0.0:
            time.sleep(left)
        while (heard := self._reader.hear(0.0)) is not None:
            if heard.ended:
                raise Gone
            self._obey(heard.said)
        if time.monotonic() - self._heard > PATIENCE:
            # Whoever commanded is gone or stuck: nothing is safer than no command.
            self._command = np.zeros_like(self._command)

    def _obey(self, message: Mapping[str, Any]) -> None:
        if message.get("stop") is True:
            raise Stopped
        command = message.get("command")
        if isinstance(command, dict):
            self._heard = time.monotonic()
            names = [self._faults.rename.get(name, name) for name in self._actuators]
            values = np.array([number(command.get(name)) for name in names])
            self._command = np.nan_to_num(values)[None]

    def _state(self, q: Array, v: Array, noise: Array, now: float) -> None:
        """Say a state, as its sensors and its faults have it."""
        faults = self._faults
        if faults.dies is not None and now >= faults.dies:
            os._exit(7)
        while faults.hangs is not None and now >= faults.hangs:
            self._obey(self._hear())
        if faults.skips is not None and abs(now - faults.skips) < 0.5 * self._task.period:
            return
        state = np.concatenate([q, v])
        message: dict[str, float | None] = {}
        for name, at in self._at.items():
            reading = float(sensed(self._simulator.effects, name, state[at : at + 1])[0])
            message[faults.rename.get(name, name)] = self._faulty(name, reading + noise[at], now)
        if faults.rubbish:
            os.write(self._sink, RUBBISH[round(now / self._task.period) % len(RUBBISH)])
        self._send({"t": now, "state": message})

    def _faulty(self, name: str, reading: float, now: float) -> float | None:
        if name in self._faults.unit:
            reading /= UNITS[self._faults.unit[name]].factor
        if now >= self._faults.lost.get(name, math.inf):
            return None
        if now < self._faults.frozen.get(name, math.inf):
            self._held[name] = reading
        return self._held.get(name, reading)

    def _confess(self) -> None:
        if not self._faults.deaf:
            self._send({"stopped": True})

    def _hear(self) -> Mapping[str, Any]:
        """Return the next message, waiting as long as it takes."""
        while (heard := self._reader.hear(1.0)) is None or heard.unreadable:
            pass
        if heard.ended:
            raise Gone
        return heard.said

    def _send(self, message: Mapping[str, Any]) -> None:
        line = line_of(message)
        try:
            while line:
                line = line[os.write(self._sink, line) :]
        except BrokenPipeError:
            raise Gone from None
