"""The bodies that commands between two bodies work on, and the policy they begin with."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.errors import SearchError, TaskError, TransferError
from morph.files import sha256
from morph.policy.policy import Policy
from morph.policy.store import load_policy
from morph.policy_transfer.balancers import PUSHED, balancer
from morph.policy_transfer.body import Body, body
from morph.policy_transfer.mapped.feedback import holding
from morph.policy_transfer.policy_conversion import gain_of
from morph.policy_transfer.riders import PUSHES, RIDERS, rider, riding
from morph.task.tasks import check_name

TASKS = ("balance",)
"""Tasks about a state of rest that bodies share: what a relay carries so far."""

BOARDS = tuple(PUSHES)
"""How a skateboard under a humanoid may roll."""

LEARNED = "learned"
"""Instead of a folder: the first body's policy is learned first."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SourcePolicy:
    """The first body's policy."""

    gain: Array
    """Of its law about rest, shape (nu, n)."""
    shift: Array
    """Shape (nu,)."""
    sha256: str
    """Hash of its numbers, or what learned it."""


def check_task(name: str) -> None:
    """Refuse a task that no relay carries, before a body is read for it.

    Raises:
        TaskError: There is no such task.
        TransferError: It is not about a state of rest.
    """
    check_name(name)
    if name not in TASKS:
        raise TransferError(
            f"{name} is not about a state of rest, and bodies share no quantity of it that a map "
            "could be held to",
            where="--task",
            fix=f"give {' or '.join(TASKS)}; `morph loop` carries {name} to a body that differs "
            "by its figures",
        )


def body_of(name: str, task: str) -> Body:
    """Return a body with its task, pushed as was fixed beforehand if it is one of the shelf's.

    Raises:
        RobotError: There is no such body.
        TransferError: It cannot be asked to do the task, or it can rest nowhere.
    """
    try:
        if name in PUSHED:
            return balancer(name)
        if name in RIDERS:
            return rider(name)
        if "@" in name and not Path(name).exists():
            return _boarded(name)
        from morph.task.tasks import task as task_of

        return body(task_of(task, load(name)))
    except (TaskError, SearchError) as error:
        raise TransferError(
            f"it shares no quantity of {task}: {error.what}",
            where=f"body {name}",
            fix=f"give a body that can {task}: one that stands upright, with hinges that swing "
            "in gravity, and can be held so",
        ) from error


def _boarded(name: str) -> Body:
    """Return a humanoid on a skateboard, from ROBOT@BOARD:LEFT,RIGHT.

    Raises:
        TransferError: It is not written so.
    """
    robot, _, how = name.rpartition("@")
    kind, _, feet = how.partition(":")
    board = next((each for each in BOARDS if each == kind), None)
    left, comma, right = feet.partition(",")
    if board is None or not (robot and comma and left and right):
        raise TransferError(
            f"{how!r} is no skateboard with two feet on it",
            where=f"body {name}",
            fix=f"write ROBOT@BOARD:LEFT,RIGHT, where BOARD is {', '.join(BOARDS)} and the rest "
            "names its two feet",
        )
    return riding(load(robot, base="floating"), (left, right), board)


def notes_of(names: Sequence[str]) -> tuple[str, ...]:
    """Return what is to be known of these bodies before any figure of theirs is believed."""
    notes = []
    for name in names:
        if name not in PUSHED and name not in RIDERS and "@" not in name:
            notes.append(
                f"no push was fixed for {name}: its runs begin near rest, and holding still may "
                "do as well as any policy"
            )
        for gone in PUSHED[name].without if name in PUSHED else ():
            notes.append(f"{name} is taken without the servo {gone}, by which it would just stand")
    return tuple(dict.fromkeys(notes))


def hash_of(robot: Robot) -> str:
    """Return the hash of a body."""
    return robot.sha256 or sha256(robot.mjcf)


def given(policy: str, first: Body) -> SourcePolicy:
    """Return the law of the first body, read or learned.

    Raises:
        PolicyError: The policy is another body's, or spoilt.
        TransferError: It looks back in time, or its control period is not the task's, or it
            cannot be learned.
    """
    if policy != LEARNED:
        result = load_policy(policy, first.task.robot)
        check_period(result, first, policy)
        gain, shift = gain_of(first, result)
        numbers = (np.asarray(value).tobytes() for _, value in sorted(result.weights().items()))
        return SourcePolicy(gain=gain, shift=shift, sha256=sha256(*numbers))
    gain = holding(first)
    return SourcePolicy(
        gain=gain, shift=np.zeros(len(gain)), sha256="the regulator of its own description"
    )


def check_period(policy: Policy, first: Body, where: str) -> None:
    """Refuse a policy of another control period.

    Raises:
        TransferError: It is another.
    """
    if abs(policy.period - first.task.period) > 1e-9:
        raise TransferError(
            f"it commands every {policy.period:g} s, and {first.task.name} counts every "
            f"{first.task.period:g} s",
            where=f"--from {Path(where)}",
            fix="give a policy of the task's control period",
        )
