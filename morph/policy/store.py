"""A policy as a folder of `policy.json` and `weights.safetensors`, checked when it is read."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from morph.arrays import JSON, Array
from morph.body.robot import Robot
from morph.errors import OutputError, PolicyError
from morph.files import write_whole
from morph.policy.fields import number_of
from morph.policy.files import EXPORTED, FILES, read_json, read_tensors
from morph.policy.policy import Policy
from morph.policy.policy_json import (
    actions_said,
    check_body,
    check_robot,
    kind_of,
    observations_said,
    said_of,
)
from morph.policy.replay import check_replay, to_replay


def write_policy(
    policy: Policy,
    folder: Path,
    robot: Robot,
    *,
    task: str = "",
    task_sha256: str = "",
    learned: JSON | None = None,
    seconds: float = 10.0,
    observed: Array | None = None,
    times: Array | None = None,
) -> Path:
    """Return the folder that a policy was written to, with actions to check it by.

    Args:
        policy: What to write.
        folder: A new folder, an empty one, or one that holds an earlier policy.
        robot: The body that it commands.
        task: What it is for, in a word.
        task_sha256: The hash of that task.
        learned: How it was found; None for one written by hand.
        seconds: How much of it is stored to be replayed.
        observed: What it saw in a run, shape (samples, observations): some of it is stored to
            be replayed. Without it observations are drawn.
        times: When it saw that, s, shape (samples,).

    Raises:
        PolicyError: It does not command this robot, or what was observed does not fit it.
        OutputError: The folder cannot be written to.
    """
    check_body(policy, robot, where=str(folder))
    if folder.is_dir() and any(folder.iterdir()) and not (folder / FILES[-1]).is_file():
        raise PolicyError(
            "the folder is not empty and holds no earlier policy",
            where=str(folder),
            fix="name a new or an empty folder",
        )
    statement = said_of(policy, robot, task=task, task_sha256=task_sha256, learned=learned)
    text = _text(statement, folder)
    replay = to_replay(policy, seconds=seconds, observed=observed, times=times)
    _forget_export(folder)
    # `policy.json` comes last: it makes the folder a policy.
    write_whole(folder / FILES[0], _bytes({**policy.weights(), **replay}))
    write_whole(folder / FILES[1], text)
    return folder


def _text(document: JSON, folder: Path) -> str:
    try:
        return json.dumps(document, indent=1, allow_nan=False) + "\n"
    except (TypeError, ValueError) as error:
        raise PolicyError(
            f"how it was learned cannot be written as JSON: {error}",
            where=str(folder),
            fix="give texts, finite numbers, lists and objects of them",
        ) from error


def _forget_export(folder: Path) -> None:
    """Remove what an earlier policy was exported to: it would be taken for this one."""
    try:
        (folder / EXPORTED).unlink(missing_ok=True)
    except OSError as error:
        raise OutputError(
            f"cannot be replaced: {error.strerror or error}",
            where=str(folder / EXPORTED),
            fix="name another folder",
        ) from error


def load_policy(path: str | Path, robot: Robot) -> Policy:
    """Return the policy of a folder, once it has proved to be this robot's and unspoilt.

    Raises:
        PolicyError: A file is missing, too large or not what it should be; the policy
            belongs to another body; or its numbers do not give the actions stored with them.
    """
    folder = Path(path)
    document = read_json(folder / "policy.json")
    where = str(folder / "policy.json")
    kind = kind_of(document, where)
    check_robot(document, robot, where)
    tensors = read_tensors(folder / "weights.safetensors")
    weights = {name: value for name, value in tensors.items() if not name.startswith("replay.")}
    policy = kind.of(
        weights,
        action=actions_said(document, where),
        observation=observations_said(document, where),
        period=number_of(document, "control_period_s", where),
    )
    check_body(policy, robot, where=where)
    check_replay(policy, tensors, where=str(folder / "weights.safetensors"))
    return policy


def _bytes(tensors: Mapping[str, Array]) -> bytes:
    from safetensors.numpy import save

    # A number of no axis must stay one; `ascontiguousarray` would give it one.
    return bytes(save({name: np.array(value, order="C") for name, value in tensors.items()}))
