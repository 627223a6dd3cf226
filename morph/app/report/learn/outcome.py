"""All that `morph learn` found out, and how `record.json` tells it."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path
from typing import ClassVar

import numpy as np

import morph
from morph.app.report.learn.judge import JudgedPolicy, judge
from morph.arrays import JSON, Array
from morph.errors import OutputError
from morph.files import sha256
from morph.policy.policy import Policy
from morph.search.search import Learned, Search, Trial
from morph.tabular import Tabular
from morph.task.task import Task

SCHEMA = "morph.learned/1"
"""Name and version of `record.json` and of what `--json` prints."""

MOST_OFTEN = 0.5
"""Share of the runs that a policy must bring to every goal to count as one that does its task."""


@dataclass(frozen=True, kw_only=True)
class LearnOutcome(Tabular):
    """What a search found, and how it was judged."""

    task: Task
    """What was to be done, the world and the effects that were asked for among it."""
    search: Search
    """The search, with its settings."""
    policy: Policy
    """The best policy."""
    judged: JudgedPolicy
    """What it did over runs that the search never saw."""
    trials: tuple[Trial, ...]
    """The learning record, what an interrupted search did before among it."""
    claimed: bool
    """Whether the search itself holds that it succeeded."""
    why_not: str
    """What the search says if it does not."""
    seed: int
    """Random seed."""
    asked: int | None
    """Most trials that were asked for; None for the search's own number."""
    experience: float
    """Time on the target, s."""
    seconds: float
    """How long the search took, s."""
    command: str
    """The command that led to it."""
    notes: tuple[str, ...] = ()
    """What else is to be known."""

    @classmethod
    def of(
        cls,
        task: Task,
        search: Search,
        learned: Learned,
        *,
        seed: int,
        asked: int | None,
        seconds: float,
        command: str,
    ) -> LearnOutcome:
        """Return what a search found, its policy judged over runs that it never saw.

        Args:
            task: What was to be done.
            search: The search.
            learned: What it gave back, with its whole learning record.
            seed: Random seed.
            asked: Most trials that were asked for.
            seconds: How long it took.
            command: The command that leads to it.
        """
        return cls(
            task=task,
            search=search,
            policy=learned.policy,
            judged=judge(task, learned.policy, task.simulator(), seed),
            trials=learned.trials,
            claimed=learned.succeeded,
            why_not=learned.why,
            seed=seed,
            asked=asked,
            experience=max((trial.experience for trial in learned.trials), default=0.0),
            seconds=seconds,
            command=command,
        )

    axes: ClassVar[tuple[str, ...]] = ("number", "loss")

    def __repr__(self) -> str:
        did = "succeeded" if self.succeeded else "did not succeed"
        share = f"{self.judged.share:.0%} of held-out runs"
        return f"LearnOutcome({self.task.name} of {self.task.robot.name}: {did}, {share})"

    def rows(self) -> list[JSON]:
        """Return the learning record, a row a trial, generation or round."""
        return [asdict(trial) for trial in self.trials]

    def save(self, folder: str | Path) -> None:
        """Write the policy, report.html and record.json, as `morph learn` does.

        Raises:
            OutputError: The folder cannot be written.
            PolicyError: The policy does not command this body.
        """
        from morph.app.report.learn.files import write_learned

        write_learned(self, Path(folder), see=f"morph simulate ROBOT --policy {folder}/policy")

    @property
    def succeeded(self) -> bool:
        """Whether the search succeeded and its policy does the task more often than not."""
        return self.claimed and self.judged.share >= MOST_OFTEN

    @property
    def count(self) -> int:
        """How many trials, generations or rounds there were; number 0, by chance, is none."""
        return sum(trial.number > 0 for trial in self.trials)

    @property
    def why(self) -> str:
        """Why it did not succeed; empty if it did."""
        if self.succeeded:
            return ""
        if self.claimed or not self.why_not:
            reached = int(self.judged.success.sum())
            return f"{reached} of {self.judged.rows} runs reach every goal"
        return self.why_not


def robot_hash(task: Task) -> str:
    """Return the hash of a task's body, also of one that came from no file."""
    return task.robot.sha256 or sha256(task.robot.mjcf)


def learned(outcome: LearnOutcome) -> JSON:
    """Return what `policy.json` tells of how the policy was found."""
    return {
        "search": outcome.search.name,
        "trials": outcome.count,
        "experience_s": outcome.experience,
        "seconds": outcome.seconds,
        "seed": outcome.seed,
        "cost": float(outcome.judged.loss.mean()),
        "success": outcome.judged.share,
    }


def as_json(outcome: LearnOutcome) -> JSON:
    """Return all of it by the schema morph.learned/1."""
    judged, task = outcome.judged, outcome.task
    return {
        "schema": SCHEMA,
        "succeeded": outcome.succeeded,
        "why": outcome.why,
        "task": task.said(),
        "robot": {"name": task.robot.name, "sha256": robot_hash(task)},
        "effects": [effect.label for effect in task.effects],
        "search": {"name": outcome.search.name, "settings": settings(outcome.search)},
        "seed": outcome.seed,
        "asked_trials": outcome.asked,
        "trials": [
            {
                "number": trial.number,
                "loss": trial.loss,
                "success": trial.success,
                "seconds": trial.seconds,
                "experience_s": trial.experience,
                "note": trial.note,
            }
            for trial in outcome.trials
        ],
        "spent": {
            "trials": outcome.count,
            "experience_s": outcome.experience,
            "seconds": outcome.seconds,
        },
        "judged": {
            "runs": judged.rows,
            **_score(judged.loss, judged.share),
            "terms": dict(judged.terms),
            "goals": dict(judged.goals),
        },
        "controls": {
            name: _score(score.loss, score.share) for name, score in judged.controls.items()
        },
        "notes": list(outcome.notes),
        "provenance": {
            "morph": morph.__version__,
            "mujoco": version("mujoco"),
            "command": outcome.command,
        },
    }


def settings(search: Search) -> JSON:
    """Return a search's settings as plain data; what is no number or text as Python has it."""
    plain = (bool, int, float, str, type(None))
    return {
        name: value if isinstance(value, plain) else repr(value)
        for name, value in vars(search).items()
    }


def record_text(outcome: LearnOutcome) -> str:
    """Return the text of `record.json`; a loss that is no number is null.

    Raises:
        OutputError: It holds what JSON cannot.
    """
    try:
        return json.dumps(_finite(as_json(outcome)), allow_nan=False, indent=1) + "\n"
    except (TypeError, ValueError) as error:
        raise OutputError(
            f"the record holds what JSON cannot: {error}",
            where="record.json",
            fix="report this with the command that led to it",
        ) from error


def _score(loss: Array, share: float) -> JSON:
    return {
        "loss": {
            "mean": float(np.mean(loss)),
            "median": float(np.median(loss)),
            "least": float(np.min(loss)),
            "greatest": float(np.max(loss)),
        },
        "success": share,
    }


def _finite(value: object) -> object:
    if isinstance(value, Mapping):
        return {name: _finite(each) for name, each in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
