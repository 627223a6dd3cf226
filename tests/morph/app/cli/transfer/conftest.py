"""Transfers whose hops are cheap: the map is that of the task, and little is run."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from jsonschema import Draft202012Validator

import morph.policy_transfer
from morph.alignment.maps.affine_map import AffineMap
from morph.app.cli.main import main
from morph.app.cli.transfer_bodies import body_of
from morph.policy_transfer.body import Body
from morph.policy_transfer.hop import Hopped
from morph.policy_transfer.mapped.belief import LinearPosterior, read
from morph.policy_transfer.mapped.feedback import holding

SCHEMA = json.loads(
    (Path(morph.policy_transfer.__file__).parent / "transfer.schema.json").read_text()
)
VALIDATOR = Draft202012Validator(SCHEMA)
"""Made once: the schema itself is checked elsewhere, and that takes 0.1 s each time."""
MESSAGE = re.compile(r"error: (?P<where>.+?): (?P<what>.+)\n  fix: (?P<fix>.+)\n")


def mapped(source: Body, target: Body) -> AffineMap:
    """Return the map by which both bodies look the same to their task, by their true models."""
    (_, B_s), (A_t, B_t) = source.linear, target.linear
    A_s = source.linear[0]
    S = np.linalg.pinv(source.outcome) @ target.outcome
    reach = np.linalg.pinv(target.outcome @ B_t)
    action = reach @ source.outcome @ B_s
    state = reach @ (source.outcome @ A_s @ S - target.outcome @ A_t)
    (n_s, n_t), (k_t, k_s) = S.shape, action.shape
    return AffineMap(
        state_law=S,
        state_shift=np.zeros(n_s),
        lift_law=np.asarray(np.linalg.pinv(S), dtype=float),
        lift_shift=np.zeros(n_t),
        action_law=action,
        action_state=state,
        action_shift=np.zeros(k_t),
        read_law=np.asarray(np.linalg.pinv(action), dtype=float),
        read_state=np.zeros((k_s, n_t)),
        read_shift=np.zeros(k_s),
    )


class Knowing:
    """Makes a hop from the true models; may be told to fail or to be interrupted at one."""

    def __init__(self) -> None:
        self.calls = 0
        self.failing: dict[int, BaseException] = {}
        self.sign = 1.0

    def __call__(
        self, source: Body, target: Body, count: int, *, seed: int, spoil: Any = None
    ) -> tuple[Hopped, LinearPosterior]:
        self.calls += spoil is None
        if spoil is None and self.calls in self.failing:
            raise self.failing[self.calls]
        # By a map that is spoilt it makes the wrong law.
        gain = self.sign * holding(target) * (1.0 if spoil is None else -1.0)
        hopped = Hopped(
            source=source.task.robot.name,
            target=target.task.robot.name,
            map=mapped(source, target),
            quality={},
            guard=None,
            samples=count,
            gain=gain,
            shift=np.zeros(len(gain)),
        )
        return hopped, self.sure(target)

    def sure(self, body: Body) -> LinearPosterior:
        """Return a belief that is the truth, or its mirror image in the commands."""
        half, rise = body.size // 2, read(body)[body.size // 2 :].copy()
        rise[:, half : 2 * half] -= np.eye(half)
        rise[:, 2 * half :] *= self.sign
        cover = 1e-12 * np.eye(rise.size)
        return LinearPosterior(law=rise / body.task.period, cover=cover, period=body.task.period)


class Bench:
    """What the tests of `morph transfer` do."""

    def __init__(self, capsys: pytest.CaptureFixture[str], knowing: Knowing) -> None:
        self._capsys, self.knowing = capsys, knowing

    def words(self, *more: str, out: str = "out") -> list[str]:
        chain = [] if "--chain" in more else ["--chain", "cartpole", "rider_rigid_driven"]
        quick = ["--trials", "2", "--repeats", "0", "--scratch", "0", "--samples", "20"]
        return ["transfer", "--from", "learned", *chain, *quick, *more, "--out", out]

    def transfer(self, *more: str, out: str = "out", status: int = 0) -> None:
        """Run the command, which is to end so."""
        assert main(self.words(*more, out=out)) == status

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
        found = MESSAGE.fullmatch(told.err)
        assert found, told.err
        assert self.content(".") == before
        return found


def shorter(name: str, task: str) -> Body:
    """Return a body whose runs last 2 s: the report of a run of 5 s says nothing more here."""
    whole = body_of(name, task)
    goals = tuple(replace(goal, last=1.0) for goal in whole.task.goals)
    return replace(whole, task=replace(whole.task, horizon=2.0, goals=goals))


@pytest.fixture
def bench(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Bench:
    knowing = Knowing()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")
    monkeypatch.setattr("morph.policy_transfer.evaluate_hop.carry", knowing)
    monkeypatch.setattr("morph.app.cli.transfer_bodies.body_of", shorter)
    return Bench(capsys, knowing)
