"""Whose loop a folder holds: what must be the same for one to go on, and one at a time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from morph.app.cli.arguments import Loop
from morph.app.cli.outputs import LOOP
from morph.errors import OutputError

if TYPE_CHECKING:
    from morph.app.cli.target_options import TargetOptions
    from morph.policy.policy import Policy
    from morph.policy_transfer.loop_checkpoint import Keep
    from morph.record.recording import Recording
    from morph.task.task import Task


def key_of(
    options: Loop, task: Task, given: Policy | None, aim: TargetOptions | None
) -> dict[str, str]:
    """Return what must be the same for a loop to go on."""
    from morph.files import sha256
    from morph.search.searches import default

    if given is None:
        policy = f"learned by {default(task.name, task.robot)}"
    else:
        policy = sha256(*(value.tobytes() for _, value in sorted(given.weights().items())))
    # What a seal conceals is drawn later; its seed says as much.
    target, limit = (f"sealed {options.sealed}", "") if aim is None else (aim.key, aim.limit)
    return {"target": target, "limit": limit, "policy": policy, "seed": str(options.seed)}


def key_of_recordings(options: Loop, recordings: Sequence[Recording]) -> dict[str, str]:
    """Return what must be the same for recordings to be diagnosed again in a folder."""
    from morph.files import sha256

    shown = sha256(*(each.sha256.encode() for each in recordings))
    return {"target": f"recorded {shown}", "limit": "", "policy": "", "seed": str(options.seed)}


def keep_of(out: Path, task: Task, key: Mapping[str, str]) -> Keep:
    """Return where the trials of a loop are kept.

    Raises:
        OutputError: The folder holds another loop.
    """
    from morph.policy_transfer.loop_checkpoint import Keep

    try:
        return Keep(out, task, key)
    except OutputError as error:
        raise OutputError(
            error.what, where=error.where, fix=f"{error.fix}, or begin anew in this one by --fresh"
        ) from error


def check_fresh(options: Loop, out: Path) -> None:
    """Refuse to begin anew where that would remove what the loop is given.

    Raises:
        OutputError: The policy lies in the folder, or a description or effects of an earlier loop.
    """
    if not options.fresh:
        return
    here = out.resolve()
    results = {here / name for name in LOOP.results}
    lost = [("--robot", options.robot), ("--effects", options.effects)]
    given = [name for name, path in lost if path is not None and Path(path).resolve() in results]
    if options.policy is not None and Path(options.policy).resolve().is_relative_to(here):
        given.append("--policy")
    if given:
        raise OutputError(
            f"--fresh would remove what {given[0]} names, as it lies in this folder",
            where=str(out),
            fix="name another folder by --out, or copy it elsewhere first",
        )
