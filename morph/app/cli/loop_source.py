"""The source's policy: as given, as it was learned before, or learned now."""

from __future__ import annotations

from pathlib import Path

from morph.app.cli.arguments import Loop
from morph.app.cli.outputs import SOURCE
from morph.app.cli.stages import Stages
from morph.policy.policy import Policy
from morph.policy.store import load_policy, write_policy
from morph.search.search import Problem
from morph.search.searches import default, search
from morph.task.task import Task


def source(
    options: Loop, task: Task, given: Policy | None, progress: Stages
) -> tuple[Policy, tuple[str, ...]]:
    """Return the source's policy, and what is to be known of it.

    One that is learned is kept in the folder, so that a loop that goes on need not learn it again.

    Raises:
        SearchError: It cannot be learned.
        PolicyError: What was kept is spoilt.
    """
    if given is not None:
        return given, ()
    folder = Path(options.out) / Path(SOURCE[0]).parent
    name = default(task.name, task.robot)
    learned = f"the source's policy was learned first, by {name}"
    if (folder / "policy.json").is_file():
        return load_policy(folder, task.robot), (learned,)
    progress.line(f"no policy was given: learning {task.name} of {task.robot.name} by {name}")
    simulator = task.simulator()
    result = search(name)().run(
        Problem(task=task, simulator=simulator),
        seed=options.seed,
        progress=lambda trial, state: progress.now(f"learning, round {trial.number}"),
    )
    write_policy(
        result.policy, folder, task.robot, task=task.name, task_sha256=task.sha256,
        seconds=task.horizon,
    )  # fmt: skip
    # Read back: going on must begin from the very same numbers.
    policy = load_policy(folder, task.robot)
    if result.succeeded:
        return policy, (learned,)
    return policy, (learned, f"it did not succeed on the source: {result.why}")
