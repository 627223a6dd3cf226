"""Checkpoint of a loop after each trial, for resuming."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from morph.arrays import Array
from morph.errors import OutputError, PolicyError
from morph.files import write_whole
from morph.npz import load_npz
from morph.policy.policy import Policy
from morph.policy.store import load_policy, write_policy
from morph.policy_transfer.trial_record import TrialRecord
from morph.regular_file import read_regular
from morph.search.target import Experience
from morph.task.task import Task

STATE, TRIALS, SHOWN, ORIGIN = "loop.json", "trials", "experience.npz", "origin.json"
"""Whose trials a folder holds; and of each trial what it showed, and where its policy came from."""

MOST_BYTES = 50_000_000
"""Most bytes of a file of a trial, and of the numbers in it."""

SPOILT = (PolicyError, KeyError, TypeError, ValueError, OSError, RecursionError)
"""What reading a spoilt file may raise."""


class Keep:
    """The trials of one loop in one folder.

    Args:
        out: The folder.
        task: The source's task.
        key: What must be the same for a loop to go on: the target's name, the seed.

    Raises:
        OutputError: The folder holds another loop's trials, or cannot be written to.
    """

    def __init__(self, out: Path, task: Task, key: Mapping[str, str]) -> None:
        self.out, self.task = out, task
        message = {"robot": task.robot.sha256 or task.robot.name, "task": task.sha256, **key}
        state = out / STATE
        if state.is_file():
            _check(state, message)
        else:
            write_whole(state, json.dumps({"schema": "morph.loop/1", **message}, indent=1) + "\n")

    def _folder(self, number: int) -> Path:
        return self.out / TRIALS / f"{number:02d}"

    def begin(self, number: int, policy: Policy, origin: str) -> None:
        """Keep the policy that is about to be tried."""
        folder = self._folder(number)
        write_policy(
            policy,
            folder / "policy",
            self.task.robot,
            task=self.task.name,
            task_sha256=self.task.sha256,
        )
        write_whole(folder / ORIGIN, json.dumps({"origin": origin}) + "\n")

    def end(self, number: int, experience: Experience) -> None:
        """Keep what a trial showed; it makes the trial a finished one."""
        arrays: dict[str, Array] = {
            name: np.asarray(value, dtype=float) for name, value in vars(experience).items()
        }
        held = io.BytesIO()
        np.savez_compressed(held, allow_pickle=False, **arrays)
        write_whole(self._folder(number) / SHOWN, held.getvalue())

    def trial(self, number: int) -> TrialRecord | None:
        """Return a finished trial, or None if it is yet to be made.

        Raises:
            OutputError: What was kept of it is spoilt.
        """
        folder = self._folder(number)
        if not (folder / SHOWN).is_file():
            return None
        try:
            policy = load_policy(folder / "policy", self.task.robot)
            origin = str(json.loads(read_regular(folder / ORIGIN, MOST_BYTES))["origin"])
            return TrialRecord(policy=policy, experience=_read(folder / SHOWN), origin=origin)
        except SPOILT as error:
            raise OutputError(
                f"trial {number + 1} cannot be read: {error}",
                where=str(folder),
                fix="remove the folder of this trial and those after it, or begin anew elsewhere",
            ) from error


def _check(state: Path, message: Mapping[str, str]) -> None:
    try:
        before = json.loads(read_regular(state, MOST_BYTES))
        other = [name for name, value in message.items() if before[name] != value]
    except (ValueError, KeyError, TypeError, OSError, RecursionError) as error:
        raise OutputError(
            f"it is no state of a loop: {error}",
            where=str(state),
            fix="name a new folder",
        ) from error
    if other:
        raise OutputError(
            f"the folder holds a loop with another {' and another '.join(other)}",
            where=str(state.parent),
            fix="name a new folder",
        )


def _read(path: Path) -> Experience:
    held = load_npz(path, MOST_BYTES)
    arrays = {name: np.asarray(value, dtype=float) for name, value in held.items()}
    return Experience(
        position=arrays["position"],
        velocity=arrays["velocity"],
        command=arrays["command"],
        period=float(arrays["period"]),
        loss=float(arrays["loss"]),
        success=bool(arrays["success"]),
    )
