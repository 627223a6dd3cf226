"""A loop whose advice is cheap: the truth is known at once, and stronger feedback is advised."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from jsonschema import Draft202012Validator

import morph.policy_transfer
from morph.app.cli.main import main
from morph.body.load import load
from morph.model.kwik.certify import ModelVerdict
from morph.model.latent.parameter_attribution import Difference, Explained
from morph.model.latent.unknowns import turned
from morph.policy.linear import Linear
from morph.policy.observing import observations_of
from morph.policy.policy import Policy, actions_of
from morph.policy.store import write_policy
from morph.policy_transfer.next_action import NextAction
from morph.policy_transfer.predicted_return import PredictedReturn
from morph.policy_transfer.repair import Repair, TaskModel
from morph.policy_transfer.retask import task_for
from morph.policy_transfer.score import judged
from morph.search.evaluate import evaluate
from morph.task.task import Task
from morph.task.tasks import task

SCHEMA = json.loads(
    (Path(morph.policy_transfer.__file__).parent / "transfer.schema.json").read_text()
)
VALIDATOR = Draft202012Validator(SCHEMA)
"""Made once: the schema itself is checked elsewhere, and that takes 0.1 s each time."""
MESSAGE = re.compile(r"error: (?P<where>.+?): (?P<what>.+)\n  fix: (?P<fix>.+)\n")

GAIN = np.array([[-2.7, 27.2, -3.3, 4.3]])
"""Feedback that balances the cart-pole; where it is from stands in `cli/conftest.py`."""


def balancing(share: float) -> Linear:
    robot = load("cartpole")
    gain = share * GAIN
    return Linear(
        weight=-gain,
        bias=gain @ np.array([0.0, np.pi, 0.0, 0.0]),
        action=actions_of(robot),
        observation=observations_of(robot),
        period=task("balance", robot).period,
    )


@dataclass
class Knowing:
    """Advises feedback that holds, once, and keeps what succeeded."""

    interrupted: int = 0
    failing: int = 0
    calls: int = 0
    promised: float = 1.0

    def __call__(self, what: Task, tried: Any, **_: Any) -> NextAction:
        self.calls += 1
        if self.calls == self.interrupted:
            raise KeyboardInterrupt
        if self.calls == self.failing:
            from morph.errors import SearchError

            raise SearchError("the search broke", where="task balance", fix="take another")
        last = tried[-1]
        keeps = last.experience.success
        policy: Policy = last.policy if keeps else balancing(1.0)
        return NextAction(
            verdict=verdict(),
            repair=known(what),
            policy=policy,
            origin=last.origin if keeps else "searched again",
            foreseen=PredictedReturn(loss=5.0, success=self.promised),
            known=PredictedReturn(
                loss=5.0 if keeps else 1e4, success=self.promised if keeps else 0.0
            ),
        )


def verdict() -> ModelVerdict:
    return ModelVerdict(
        verdict="not good",
        probability=0.01,
        transitions=np.zeros(3),
        error=np.ones((3, 4)),
        for_good=-9.0,
        for_bad=9.0,
        epsilon=np.full(4, 0.02),
        delta=0.05,
    )


def known(what: Task) -> Repair:
    robot = turned(what.robot, {"length:pole": 1.2})
    found = (Difference(name="length:pole", value=1.2, low90=1.19, high90=1.21),)
    explained = Explained(
        inferred=SimpleNamespace(robot=robot, effects=(), unsaid=0.001, states=()),  # type: ignore[arg-type]
        differences=found,
        rivals=(("length:pole", 0.9), ("weight:pole + length:pole", 0.1)),
        evidence=50.0,
    )
    model = TaskModel(task=replace(task_for(what, robot)), effects=())
    return Repair(model=model, explained=explained, task=what)


class Bench:
    """What the tests of `morph loop` do, from a policy too weak to balance."""

    def __init__(self, capsys: pytest.CaptureFixture[str], knowing: Knowing) -> None:
        self._capsys, self.knowing = capsys, knowing
        write_policy(balancing(0.2), Path("weak"), load("cartpole"))

    def words(self, *more: str, out: str = "out") -> list[str]:
        return [*("loop", "balance", "--robot", "cartpole"), *more, "--out", out]

    def loop(self, *more: str, out: str = "out", status: int = 0) -> None:
        """Run the command from the weak policy, which is to end so."""
        assert main(self.words("--policy", "weak", *more, out=out)) == status

    def record(self, out: str = "out") -> dict[str, Any]:
        """Return the record that it wrote, held against its schema."""
        said: dict[str, Any] = json.loads((Path(out) / "transfer.json").read_text())
        VALIDATOR.validate(said)
        return said

    def content(self, out: str = "out") -> dict[str, bytes]:
        """Return every file of a folder."""
        return {str(path): path.read_bytes() for path in Path(out).rglob("*") if path.is_file()}

    def refused(self, *words: str) -> re.Match[str]:
        """Return the one message of a command that must be refused and write nothing."""
        before = self.content(".")
        assert main(list(words)) == 2
        told = self._capsys.readouterr()
        assert told.out == ""
        # A busy machine is told what is being done before the message.
        found = MESSAGE.fullmatch(re.sub(r"^\[\d+ s\] .*\n", "", told.err, flags=re.MULTILINE))
        assert found, told.err
        assert self.content(".") == before
        return found


@pytest.fixture
def bench(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    shorter_balance: None,
) -> Bench:
    knowing = Knowing()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")
    monkeypatch.setattr("morph.policy_transfer.loop.advise", knowing)
    # Two runs are told apart from a hundred by nothing that is tested here.
    for judging in (evaluate, judged):
        monkeypatch.setattr(judging, "__kwdefaults__", {"rows": 2})
    return Bench(capsys, knowing)
