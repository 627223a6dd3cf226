"""Policies that are searched for when they are first needed, and kept."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import morph
from morph.arrays import JSON
from morph.body.pieces import cache_folder
from morph.errors import MorphError, PolicyError
from morph.files import sha256
from morph.policy.files import read_json
from morph.policy.policy import Policy
from morph.policy.policy_json import hash_of
from morph.policy.store import load_policy, write_policy
from morph.search.searches import default, search
from morph.task.task import Task


@dataclass(frozen=True, kw_only=True)
class LearnedPolicy:
    """A policy that a search found."""

    policy: Policy
    """The best that it found."""
    search: str
    """The name of the search."""
    succeeded: bool
    """Whether the search says that it does the task."""


def kept_in(task: Task, seed: int) -> Path:
    """Return where the policy of a body's task is kept: by all that it depends on."""
    name = default(task.name, task.robot)
    settings = repr(search(name)())
    key = sha256(hash_of(task.robot), task.sha256, settings, str(seed), morph.__version__)
    return cache_folder() / "policies" / key


def kept(task: Task, seed: int) -> LearnedPolicy | None:
    """Return the policy that was found before; None if there is none, or it is spoilt."""
    folder = kept_in(task, seed)
    try:
        document = read_json(folder / "policy.json")
        policy = load_policy(folder, task.robot)
    except PolicyError:
        return None
    how = document.get("learned")
    if not isinstance(how, dict):
        return None
    return LearnedPolicy(
        policy=policy, search=str(how.get("search")), succeeded=how.get("succeeded") is True
    )


def learned(task: Task, seed: int, progress: Callable[[str], None]) -> LearnedPolicy:
    """Return what the task's own search finds, as `morph learn` would, and keep it.

    Args:
        task: The task, in its world.
        seed: Chance begins from it.
        progress: Is told how far the search is, in words; what it raises ends the search.

    Raises:
        SearchError: The search cannot be made on this task.
    """
    from morph.search.search import State, Trial

    name = default(task.name, task.robot)
    kind = search(name)()

    def on(trial: Trial, state: State) -> None:
        progress(f"{name}, round {trial.number}: cost {trial.loss:.4g}")

    result = kind.run(kind.problem(task), seed=seed, progress=on)
    how: JSON = {"search": name, "seed": seed, "succeeded": result.succeeded, "why": result.why}
    # A cache that cannot be written to costs time, not the result.
    with suppress(MorphError):
        write_policy(
            result.policy,
            kept_in(task, seed),
            task.robot,
            task=task.name,
            task_sha256=task.sha256,
            learned=how,
        )
    return LearnedPolicy(policy=result.policy, search=name, succeeded=result.succeeded)
