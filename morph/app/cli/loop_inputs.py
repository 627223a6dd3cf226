"""What `morph loop` begins with: the task, and the source's policy, given or learned."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from morph.app.cli.arguments import Loop
from morph.app.cli.outputs import SOURCE
from morph.app.cli.stages import Stages
from morph.errors import TransferError
from morph.policy.policy import Policy
from morph.policy.store import load_policy, write_policy
from morph.search.search import Problem
from morph.search.searches import default, search
from morph.task.task import Task


def check_numbers(options: Loop) -> None:
    """Refuse counts that no loop can have."""
    if options.trials < 1:
        raise TransferError(
            f"a loop of {options.trials} trials shows nothing",
            where="--trials",
            fix="give 1 or more",
        )
    if options.seed < 0:
        raise TransferError(f"{options.seed} is no seed", where="--seed", fix="give 0 or more")


def task_of(options: Loop) -> Task:
    """Return the source's task in the world that is asked for."""
    from morph.body.load import load
    from morph.task.tasks import check_name, task

    check_name(options.task)
    robot = load(options.robot, base=options.base, folder=options.folder)
    result = task(options.task, robot)
    if options.world is not None:
        from morph.physics.worlds import world

        result = replace(result, world=options.world, effects=world(options.world, robot).effects)
    if not options.limit:
        return result
    from morph.app.cli.target_options import limits
    from morph.policy_transfer.live.limited_task import within

    # What is searched and foreseen knows the limits of what will be tried.
    return within(result, limits(options.limit))


def check_body(task: Task) -> None:
    """Refuse a body whose simulation cannot be repaired, before anything is tried."""
    others = [each.name for each in task.robot.joints if each.kind not in {"hinge", "slide"}]
    if others:
        raise TransferError(
            f"its joint {others[0]} is neither a hinge nor a slide, and what differs in such a "
            "body is not found by its runs yet",
            where=f"robot {task.robot.name}",
            fix="take a body that stands fixed; `morph diagnose` compares recordings of others",
        )


def policy_of(options: Loop, task: Task) -> Policy | None:
    """Return the policy that is named, once it fits the body and the task."""
    if options.policy is None:
        return None
    from morph.search.evaluate import check_period

    policy = load_policy(options.policy, task.robot)
    check_period(policy, task)
    return policy


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
