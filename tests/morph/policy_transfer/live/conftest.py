"""What tests of live targets share: a task, a target of a few lines, and a cart in closed form."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.policy_transfer.live.process import Process
from morph.policy_transfer.live.protocol import hello_said
from morph.policy_transfer.live.wiring import hello_for
from morph.task.task import Task
from morph.task.tasks import task

SPEAKING = """
import json, os, random, sys, time
def say(said):
    line = said if isinstance(said, bytes) else json.dumps(said).encode() + b"\\n"
    sys.stdout.buffer.write(line)
    sys.stdout.buffer.flush()
def state(k):
    # Noise of the sensors at rest; a channel that repeats would be dead.
    return {name: random.gauss(0.0, 0.01) for name in
            ("slide.position", "hinge.position", "slide.velocity", "hinge.velocity")}
def stopped():
    log("stop")
    say({"stopped": True})
def log(text):
    with open(LOG, "a") as file:
        file.write(text + "\\n")
def on_state(k, said):
    say(said)
LOG, HELLO = %r, %s
%s
say(HELLO)
k = 0
for line in sys.stdin:
    told = json.loads(line)
    if "stop" in told:
        stopped()
        continue
    if "begin" in told:
        k = 0
    else:
        log(line.strip())
        k += 1
    on_state(k, {"t": 0.05 * k, "state": state(k)})
log("end of input")
"""
"""A target in plain Python, which starts at once; what is changed is put in before it speaks."""

Making = Callable[..., Process]


@pytest.fixture(scope="session")
def swing() -> Task:
    # Half a second: 11 states, 10 commands.
    return replace(task("swing-up", load("cartpole")), horizon=0.5)


@pytest.fixture
def log(tmp_path: Path) -> Path:
    return tmp_path / "told"


@pytest.fixture
def speaking(swing: Task, log: Path) -> Making:
    """Make a target of a few lines, with some of them changed."""

    def made(change: str = "", hello: dict[str, object] | None = None) -> Process:
        said = {**hello_said(hello_for(swing.robot, swing.period)), **(hello or {})}
        program = SPEAKING % (str(log), json.dumps(said), change)
        return Process([sys.executable, "-S", "-c", program], name="target")

    return made


class Cart:
    """A cart of 1 kg with a pole that does nothing, in closed form, as a `Step`."""

    def __init__(self, period: float = 0.05) -> None:
        self.period, self.stops = period, 0
        self.rng = np.random.default_rng(100)
        self.told: list[float] = []

    def __call__(self, command: Array | None) -> dict[str, float]:
        if command is None:
            self.x = self.v = 0.0
            self.told = []
        else:
            u = float(command[0])
            self.told.append(u)
            # Constant force over the period: x + v h + u h^2 / 2.
            self.x += self.v * self.period + 0.5 * u * self.period**2
            self.v += u * self.period
        noise = self.rng.normal(scale=1e-6, size=4)
        return {
            "slide.position": self.x + noise[0],
            "slide.velocity": self.v + noise[1],
            "hinge.position": noise[2],
            "hinge.velocity": noise[3],
        }

    def stop(self) -> None:
        self.stops += 1


@pytest.fixture
def cart() -> Cart:
    return Cart()
