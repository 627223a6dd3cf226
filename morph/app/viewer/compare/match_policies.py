"""Match stored policies to bodies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from morph.body.robot import Robot
from morph.errors import PolicyError, ViewError
from morph.policy.files import read_json
from morph.policy.policy import Policy
from morph.policy.store import load_policy
from morph.task.tasks import TASKS

LEARNED = "learned"
"""What asks for a search instead of naming a folder."""


@dataclass(frozen=True, kw_only=True)
class StoredPolicy:
    """A policy from a folder."""

    folder: str
    """Its folder, as it was named."""
    policy: Policy
    """What it is."""
    task: str
    """What its file says that it is for; empty if it does not say."""


def matched(robots: Sequence[Robot], policies: Sequence[str]) -> tuple[StoredPolicy | None, ...]:
    """Return each body's policy; of a body that stands there twice, the first has the first.

    Args:
        robots: The bodies.
        policies: Folders of policies; `LEARNED` is passed over.

    Raises:
        PolicyError: A folder holds no policy that can be used.
        ViewError: One is of none of these bodies, or its body has one already.
    """
    results: list[StoredPolicy | None] = [None] * len(robots)
    for folder in policies:
        if folder == LEARNED:
            continue
        document = read_json(Path(folder) / "policy.json")
        fits, why = [], []
        for at, robot in enumerate(robots):
            try:
                policy = load_policy(folder, robot)
            except PolicyError as error:
                why.append(error)
                continue
            fits.append((at, policy))
        if not fits:
            raise _of_none(folder, robots, why)
        free = [(at, policy) for at, policy in fits if results[at] is None]
        if not free:
            name = robots[fits[0][0]].name
            raise ViewError(
                f"{name} has a policy already: {_folder(results[fits[0][0]])}",
                where=f"--policy {folder}",
                fix=f"name {name} once more to see both, or leave one policy out",
            )
        at, policy = free[0]
        results[at] = StoredPolicy(folder=folder, policy=policy, task=_task(document))
    return tuple(results)


def task_of(policies: Sequence[StoredPolicy | None]) -> str | None:
    """Return the task that policies are for, if there are any.

    Raises:
        ViewError: They are for several tasks, or for none that there is.
    """
    given = [each for each in policies if each is not None]
    names = sorted({each.task for each in given})
    if not given:
        return None
    if len(names) > 1 or names[0] not in TASKS:
        text = ", ".join(f"{each.folder}: {each.task or 'none'}" for each in given)
        raise ViewError(
            f"the policies do not tell one task ({text})",
            where="--policy",
            fix=f"say by --task what the bodies are to do: {', '.join(TASKS)}",
        )
    return names[0]


def _of_none(folder: str, robots: Sequence[Robot], why: Sequence[PolicyError]) -> ViewError:
    names = ", ".join(dict.fromkeys(robot.name for robot in robots))
    # With one body there is one reason, and it says more than that it does not fit.
    reason = f": {why[0].what}" if len({error.what for error in why}) == 1 else ""
    return ViewError(
        f"the policy is of none of the bodies shown, which are {names}{reason}",
        where=f"--policy {folder}",
        fix="name the body that it was made for, or leave the policy out",
    )


def _folder(given: StoredPolicy | None) -> str:
    return "" if given is None else given.folder


def _task(document: object) -> str:
    task = document.get("task") if isinstance(document, dict) else None
    name = task.get("name") if isinstance(task, dict) else None
    return name if isinstance(name, str) else ""
