"""A search that learns to balance in five trials, and what tests of `morph learn` do with it."""

from __future__ import annotations

import json
import re
import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType
from typing import Any, ClassVar

import numpy as np
import pytest
from jsonschema import Draft202012Validator

import morph.app.report.learn
from morph.app.cli.main import main
from morph.body.robot import Robot
from morph.errors import OutputError, SearchError
from morph.policy.linear import Linear
from morph.policy.observing import observations_of
from morph.policy.policy import actions_of
from morph.search import searches
from morph.search.evaluate import evaluate
from morph.search.search import Learned, Problem, Search, State, Told, Trial, ignore
from morph.task.balance import balance
from morph.task.task import Task
from morph.task.tasks import TASKS

SCHEMA = json.loads(
    (Path(morph.app.report.learn.__file__).parent / "learned.schema.json").read_text()
)
VALIDATOR = Draft202012Validator(SCHEMA)
"""Made once: the schema itself is checked elsewhere, and that takes 0.1 s each time."""
MESSAGE = re.compile(r"error: (?P<where>.+?): (?P<what>.+)\n  fix: (?P<fix>.+)\n")

GAIN = np.array([[-2.7, 27.2, -3.3, 4.3]])
"""Feedback that balances the cart-pole: scipy's Riccati equation on finite differences of
MuJoCo's step, rounded; six tenths of it hold the pole, two tenths do not."""
UPRIGHT = np.array([0.0, np.pi, 0.0, 0.0])


@dataclass(frozen=True, kw_only=True)
class Growing(Search):
    """Feedback that grows by a fifth each trial."""

    name: ClassVar[str] = "growing"
    interrupted: ClassVar[int] = 0
    seen: ClassVar[list[Problem]] = []
    slow: ClassVar[float] = 0.0

    def solve(
        self,
        problem: Problem,
        *,
        seed: int,
        trials: int | None = None,
        progress: Told = ignore,
        state: State | None = None,
    ) -> Learned:
        type(self).seen.append(problem)
        simulator = problem.simulator or problem.task.simulator()
        done = [] if state is None else list(state["losses"])
        policy, success = None, 0.0
        for number in range(len(done) + 1, (trials or 5) + 1):
            if number == self.interrupted:
                raise KeyboardInterrupt
            time.sleep(self.slow)
            policy = balancing(problem, number / 5)
            score = evaluate(
                problem.task, policy, simulator, rng=np.random.default_rng([seed, number]), rows=2
            )
            done.append(score.mean)
            success = score.share
            trial = Trial(
                number=number,
                loss=score.mean,
                success=success,
                seconds=0.0,
                experience=5.0 * number if self.from_trials else 0.0,
            )
            progress(trial, {"losses": np.array(done)})
        policy = policy or balancing(problem, len(done) / 5)
        return Learned(
            policy=policy,
            trials=(),
            succeeded=success > 0.5,
            why="" if success > 0.5 else "its feedback is too weak",
        )


@dataclass(frozen=True, kw_only=True)
class FromTrials(Growing):
    """The same, as a search from trials."""

    name: ClassVar[str] = "from-trials"
    from_trials: ClassVar[bool] = True


@dataclass(frozen=True, kw_only=True)
class Refusing(Search):
    """Makes nothing of any task."""

    name: ClassVar[str] = "refusing"

    def solve(self, problem: Problem, **_: Any) -> Learned:
        raise SearchError("it needs gradients", where="task balance", fix="take cmaes")


def balancing(problem: Problem, share: float) -> Linear:
    robot = problem.task.robot
    gain = share * GAIN
    return Linear(
        weight=-gain,
        bias=gain @ UPRIGHT,
        action=actions_of(robot),
        observation=observations_of(robot),
        period=problem.task.period,
    )


def shorter(robot: Robot) -> Task:
    """Return the task with runs of 3 s, in which a pole that is not held falls as well."""
    whole = balance(robot)
    goals = tuple(replace(goal, last=2.0) for goal in whole.goals)
    return replace(whole, horizon=3.0, goals=goals)


@pytest.fixture
def shorter_balance(monkeypatch: pytest.MonkeyPatch) -> None:
    """Makes the runs of the task balance short."""
    monkeypatch.setitem(TASKS, "balance", shorter)


def undrawn(*_: object) -> None:
    raise OutputError("there is no OpenGL", where="--video", fix="install one")


@pytest.fixture
def growing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, shorter_balance: None
) -> type[Growing]:
    """The search, known to the command by its name, and two others; no pictures, few runs."""
    module = ModuleType("tried_searches")
    for kind in (Growing, FromTrials, Refusing):
        setattr(module, kind.__name__, kind)
    monkeypatch.setitem(sys.modules, module.__name__, module)
    known = {
        "growing": "tried_searches:Growing",
        "from-trials": "tried_searches:FromTrials",
        "refusing": "tried_searches:Refusing",
    }
    monkeypatch.setattr(searches, "SEARCHES", known)
    monkeypatch.setattr(Growing, "interrupted", 0)
    monkeypatch.setattr(Growing, "seen", [])
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    # A hundred runs take seconds, and pictures another; the tests of the report have both.
    for name in ("FEWEST", "ROWS"):
        monkeypatch.setattr(f"morph.app.report.learn.judge.{name}", 2)
    monkeypatch.setattr("morph.app.report.learn.files.strip", undrawn)
    return Growing


class Bench:
    """What the tests of `morph learn` do."""

    gain, upright = GAIN, UPRIGHT

    def __init__(self, capsys: pytest.CaptureFixture[str]) -> None:
        self._capsys = capsys

    def learn(self, *arguments: str, status: int = 0) -> None:
        """Run the command, which is to end so."""
        assert main(["learn", *arguments]) == status

    def record(self, out: str = "out") -> dict[str, Any]:
        """Return the record that it wrote, held against its schema."""
        said: dict[str, Any] = json.loads((Path(out) / "record.json").read_text())
        VALIDATOR.validate(said)
        return said

    def content(self, out: str = "out") -> dict[str, bytes]:
        """Return every file of a folder."""
        return {str(path): path.read_bytes() for path in Path(out).rglob("*") if path.is_file()}

    def refused(self, *arguments: str) -> re.Match[str]:
        """Return the one message of a command that must be refused and write nothing."""
        before = self.content(".")
        assert main(["learn", *arguments]) == 2
        told = self._capsys.readouterr()
        assert told.out == ""
        found = MESSAGE.fullmatch(told.err)
        assert found, told.err
        assert self.content(".") == before
        return found


@pytest.fixture
def bench(growing: type[Growing], capsys: pytest.CaptureFixture[str]) -> Bench:
    """The search is known as long as the bench stands."""
    return Bench(capsys)
