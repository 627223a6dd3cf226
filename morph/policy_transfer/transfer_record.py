"""Write and read transfer.json (schema morph.transfer/1)."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib.metadata import version
from typing import Literal

import morph
from morph.arrays import JSON
from morph.errors import OutputError
from morph.files import sha256
from morph.model.kwik.certify import ModelVerdict as Gate
from morph.model.latent.parameter_attribution import Difference, Explained
from morph.policy_transfer.loop import LoopRound
from morph.policy_transfer.predicted_return import PredictedReturn
from morph.policy_transfer.score import UNMEASURED
from morph.search.target import Experience
from morph.task.task import Task

SCHEMA = "morph.transfer/1"
"""Name and version of `transfer.json` and of what `--json` prints."""

SAFE, UNSAFE = 0.9, 0.5
"""Shares of success that the repaired model must promise for a policy to be called safe, and below
which it is called unsafe."""

Verdict = Literal["safe", "unsafe", "unsure"]


@dataclass(frozen=True, kw_only=True)
class GuardRecord:
    """What is thought of a policy before anybody relies on it."""

    verdict: Verdict
    """Whether it will do its task on the target."""
    probability: float | None
    """How probably it reaches every goal there; None if no model is believed."""


def guard(foreseen: PredictedReturn | None) -> GuardRecord:
    """Return the verdict on a policy by what the repaired model promises of it, if it is believed.

    It is `unsure` where no model is good enough to promise anything, and between the two shares.
    """
    if foreseen is None or not math.isfinite(foreseen.success):
        return GuardRecord(verdict="unsure", probability=None)
    share = foreseen.success
    verdict: Verdict = "safe" if share >= SAFE else "unsafe" if share < UNSAFE else "unsure"
    return GuardRecord(verdict=verdict, probability=share)


@dataclass(frozen=True, kw_only=True, eq=False)
class Hop:
    """One policy carried from one body to another."""

    task: Task
    """The source's task; its body is the source."""
    target: str
    """What the target is called."""
    runs: tuple[Experience, ...]
    """What the target showed, in order."""
    rounds: tuple[LoopRound, ...]
    """The trials among it; none if it was recorded."""
    explained: Explained | None
    """What the last model says that differs; None if nothing could be said."""
    guard: GuardRecord
    """What is thought of the policy to keep."""
    gate: Gate | None = None
    """Whether the source's model is good enough for what the target showed; None: not asked."""
    scores: Mapping[str, float | None] = field(default_factory=lambda: UNMEASURED)
    """Its scores; None for what was not measured."""
    shares: Mapping[str, float] = field(default_factory=dict)
    """Shares of runs in which each policy reached every goal, by the names of its score."""
    succeeded: bool
    """Whether the policy to keep reached every goal in its own trial."""
    why: str
    """Why not; empty if it did, or if nothing was to be tried."""

    @property
    def samples(self) -> int:
        """Control periods on the target."""
        return sum(len(run.command) for run in self.runs)

    def said(self) -> JSON:
        """Return it as plain data."""
        return {
            "source": self.task.robot.name,
            "target": self.target,
            "map": "identity",
            "quality": None,
            "guard": vars(self.guard),
            "gate": gate_said(self.gate),
            "samples": self.samples,
            "score": {name: self.scores.get(name) for name in UNMEASURED},
            "success": {name: self.shares.get(name) for name in UNMEASURED},
            "succeeded": self.succeeded,
            "why": self.why,
            "trials": [_trial(run, round) for run, round in self._pairs()],
            "differences": differences_said(
                () if self.explained is None else self.explained.differences
            ),
            "rivals": [] if self.explained is None else [
                {"what": what, "probability": share} for what, share in self.explained.rivals
            ],
            "unsaid": None if self.explained is None else self.explained.unsaid,
        }  # fmt: skip

    def _pairs(self) -> list[tuple[Experience, LoopRound | None]]:
        rounds: Sequence[LoopRound | None] = self.rounds or [None] * len(self.runs)
        return list(zip(self.runs, rounds, strict=True))


def gate_said(gate: Gate | None) -> JSON | None:
    """Return the gate's answer as plain data; None if it was not asked."""
    return None if gate is None else {"verdict": gate.verdict, "probability": gate.probability}


def differences_said(differences: Sequence[Difference]) -> list[JSON]:
    """Return what differs as plain data."""
    return [dict(vars(each)) for each in differences]


def _trial(run: Experience, done: LoopRound | None) -> JSON:
    document: JSON = {
        "origin": "recorded" if done is None else done.tried.origin,
        "loss": run.loss,
        "success": run.success,
        "experience_s": run.seconds,
    }
    if done is not None:
        advice = done.advice
        document["compute_s"] = done.seconds
        document["gate"] = None if advice is None else gate_said(advice.verdict)
        document["next"] = None if advice is None else {
            "origin": advice.origin,
            "loss": advice.foreseen.loss,
            "success": advice.foreseen.success,
        }  # fmt: skip
        document["differences"] = (
            [] if advice is None else differences_said(advice.repair.explained.differences)
        )
    return document


@dataclass(frozen=True, kw_only=True, eq=False)
class Record:
    """A transfer over one hop or several."""

    hops: tuple[Hop, ...]
    """In order; the target of one is the source of the next."""
    policy: bool
    """Whether a policy is kept beside it."""
    seed: int
    """Chance began from it."""
    seconds: float
    """Time that was spent computing, s."""
    command: str
    """The command that led to it."""
    sealed: JSON | None = None
    """What was concealed in the target, opened at the end, with what was found of it."""
    notes: tuple[str, ...] = ()
    """What else is to be known."""

    def said(self) -> JSON:
        """Return all of it by the schema morph.transfer/1."""
        task = self.hops[0].task
        return {
            "schema": SCHEMA,
            "chain": [task.robot.name, *(hop.target for hop in self.hops)],
            "hops": [hop.said() for hop in self.hops],
            "samples_total": sum(hop.samples for hop in self.hops),
            "policy": "policy/" if self.policy else None,
            "task": {"name": task.name, "sha256": task.sha256},
            "robot": {
                "name": task.robot.name,
                "sha256": task.robot.sha256 or sha256(task.robot.mjcf),
            },
            "sealed": self.sealed,
            "seed": self.seed,
            "seconds": self.seconds,
            "notes": list(self.notes),
            "provenance": {
                "morph": morph.__version__,
                "mujoco": version("mujoco"),
                "command": self.command,
            },
        }

    def text(self) -> str:
        """Return the text of `transfer.json`; a number that is not finite is null.

        Raises:
            OutputError: It holds what JSON cannot.
        """
        return text_of(self.said())


def text_of(document: JSON) -> str:
    """Return a record as text; a number that is not finite is null.

    Raises:
        OutputError: It holds what JSON cannot.
    """
    try:
        return json.dumps(_finite(document), allow_nan=False, indent=1) + "\n"
    except (TypeError, ValueError) as error:
        raise OutputError(
            f"the record holds what JSON cannot: {error}",
            where="transfer.json",
            fix="report this with the command that led to it",
        ) from error


def _finite(value: object) -> object:
    if isinstance(value, Mapping):
        return {name: _finite(each) for name, each in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
