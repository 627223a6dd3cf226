"""The policies of a package: as it was learned, and as the printed body is to have it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.errors import MakeError, MorphError
from morph.fabrication.package import DESIGNED, POLICY, ROBOT
from morph.fabrication.packed import PackedPolicy
from morph.fabrication.rematch import SECONDS, Matched, rematch
from morph.files import sha256
from morph.physics.worlds import world, world_names
from morph.policy.export import export_policy
from morph.policy.files import EXPORTED, FILES, read_json
from morph.policy.observing import Observer
from morph.policy.policy import Policy
from morph.policy.replay import TOLERANCE, apart
from morph.policy.store import load_policy, write_policy
from morph.policy_transfer.retask import task_for
from morph.search.evaluate import attempt
from morph.task.task import Task
from morph.task.tasks import TASKS, task


def matched_in(
    folder: Path,
    source: Path,
    robot: Robot,
    *,
    seconds: float = SECONDS,
    seed: int = 0,
    progress: Callable[[str], None] = lambda _: None,
) -> tuple[Matched, PackedPolicy]:
    """Match a policy to the robot of a package, and write both into it.

    The policy as it was learned goes to `designed/policy`, that for the printed robot to `policy`.

    Args:
        folder: The package, its folders `robot` and `designed` written.
        source: Folder of the policy as it was learned.
        robot: The body that it was learned on.
        seconds: How long matching may take, s.
        seed: Chance begins from it.
        progress: Is told what is going on.

    Returns:
        What became of the policy, and what `package.json` says of it.

    Raises:
        MorphError: The policy is not this body's, or its task is not known; or a file cannot
            be written.
    """
    policy = load_policy(source, robot)
    designed, printed = load(folder / DESIGNED), load(folder / ROBOT)
    requested = task_for(task_of(source, robot), designed)
    result = rematch(policy, requested, printed, seconds=seconds, seed=seed, progress=progress)
    progress("writing the policy, and replaying it in the printed robot")
    learned = read_json(source / FILES[1]).get("learned")
    write_policy(
        policy,
        folder / DESIGNED / POLICY,
        designed,
        task=requested.name,
        task_sha256=requested.sha256,
        learned=learned if isinstance(learned, dict) else None,
        seconds=requested.horizon,
    )
    return result, write_matched(folder / POLICY, result, printed)


def matched_again(
    source: Path,
    folder: Path,
    *,
    seconds: float = SECONDS,
    seed: int = 0,
    progress: Callable[[str], None] = lambda _: None,
) -> tuple[Matched, PackedPolicy]:
    """Try a package's policy on a corrected robot, and match it again if it is lost there.

    Args:
        source: The package as it was, with the policy for its robot.
        folder: A copy of it whose robot was corrected; its policy is replaced.
        seconds: How long matching may take, s; 0 to say only whether the policy holds.
        seed: Chance begins from it.
        progress: Is told what is going on.

    Raises:
        MorphError: A policy cannot be used, or a file cannot be written.
    """
    now = load_policy(source / POLICY, load(source / ROBOT))
    designed, printed = load(folder / DESIGNED), load(folder / ROBOT)
    learned = load_policy(folder / DESIGNED / POLICY, designed)
    requested = task_of(folder / DESIGNED / POLICY, designed)
    result = rematch(
        now, requested, printed, learned=learned, seconds=seconds, seed=seed, progress=progress
    )
    progress("writing the policy, and replaying it in the corrected robot")
    return result, write_matched(folder / POLICY, result, printed)


def policies_in(
    folder: Path, designed: Robot, printed: Robot
) -> tuple[tuple[Policy, Task], tuple[Policy, Task]]:
    """Return a package's policy as it was learned and as it is now, each with its task.

    Args:
        folder: The package.
        designed: The robot as designed.
        printed: The robot as it is now.

    Raises:
        MorphError: A policy cannot be used.
    """
    learned = load_policy(folder / DESIGNED / POLICY, designed)
    requested = task_of(folder / DESIGNED / POLICY, designed)
    now = load_policy(folder / POLICY, printed)
    return (learned, requested), (now, task_for(requested, printed))


def write_matched(folder: Path, matched: Matched, robot: Robot) -> PackedPolicy:
    """Write a policy for a printed robot, export it, and replay both in that very robot.

    Args:
        folder: Where; an earlier policy in it is replaced.
        matched: What became of the policy.
        robot: The robot as it is read from its own files: the policy is made for its hash.

    Raises:
        PolicyError: Read back or exported, it commands otherwise than it did.
        OutputError: The folder cannot be written to.
    """
    requested = replace(matched.task, robot=robot)
    seen, times, given = _seen(requested, matched.policy)
    write_policy(
        matched.policy,
        folder,
        robot,
        task=requested.name,
        task_sha256=requested.sha256,
        learned=matched.said(),
        observed=seen,
        times=times,
    )
    export_policy(folder, robot)
    _check(folder, robot, requested, seen, times, given)
    return PackedPolicy(
        task=requested.name,
        verdict=matched.verdict,
        what=matched.what,
        sha256=sha256(folder / FILES[0]),
    )


def task_of(folder: Path, robot: Robot) -> Task:
    """Return the task that a policy was learned for, in the world in which it was learned.

    Raises:
        MakeError: There is no such task, or it was learned under effects that no world has.
        TaskError: The body cannot be asked to do it.
    """
    path = folder / FILES[1]
    document = read_json(path).get("task")
    name = document.get("name") if isinstance(document, dict) else None
    if not isinstance(document, dict) or name not in TASKS:
        raise MakeError(
            f"it does not say which task it is for: {str(name)[:60]!r}",
            where=str(path),
            fix=f"give a policy of `morph learn`, for one of {', '.join(TASKS)}",
        )
    usual = task(str(name), robot)
    if document.get("sha256") in ("", usual.sha256):
        return usual
    # Water last: what it does to a body's shapes is reckoned for seconds.
    for each in reversed(world_names()):
        try:
            there = replace(usual, world=each, effects=world(each, robot).effects)
        except MorphError:
            # A body without shapes floats in no water.
            continue
        if there.sha256 == document.get("sha256"):
            return there
    raise MakeError(
        f"it was learned for another {name} than this robot's: under effects of its own, with "
        "other settings, or by another version",
        where=str(path),
        fix=f"learn it anew: morph learn {name} --robot ROBOT --out DIR",
    )


def _seen(wanted: Task, policy: Policy) -> tuple[Array, Array, Array]:
    """Return what a policy sees in a run without noise, when, and what it tells."""
    simulator = wanted.simulator()
    moved = attempt(wanted, policy, simulator, rows=1, rng=None)
    observer = Observer(policy, wanted.robot, simulator.model, 1, effects=simulator.effects)
    # The last command is held on, and nothing is seen for it.
    steps = len(moved.time) - 1
    states = zip(moved.position[0, :steps], moved.velocity[0, :steps], strict=True)
    seen = np.array([observer.see(q[None], v[None])[0] for q, v in states])
    return seen.reshape(steps, policy.size), moved.time[:steps], moved.command[0, :steps]


def _check(
    folder: Path, robot: Robot, wanted: Task, seen: Array, times: Array, given: Array
) -> None:
    """Refuse a policy that, read back or exported, does otherwise in the robot than it did."""
    import onnx
    from onnx.reference import ReferenceEvaluator

    again = _seen(wanted, load_policy(folder, robot))[2]
    model = onnx.load(folder / EXPORTED)
    (exported,) = ReferenceEvaluator(model).run(None, {"observation": seen, "time": times})
    for what, commands in (("read back", again), ("exported", np.asarray(exported))):
        worst = apart(commands, given)
        if not worst <= TOLERANCE:
            raise MakeError(
                f"{what}, its commands in the printed robot differ by {worst:.2g}",
                where=str(folder),
                fix="tell morph's authors which policy it was",
            )
