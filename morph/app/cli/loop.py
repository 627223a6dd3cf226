"""`morph loop`: a policy carried to a target, what the model lacked, and how good it is there."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from morph.app.cli.arguments import Loop
from morph.errors import MorphError, TransferError, TrialStopped

if TYPE_CHECKING:
    from morph.app.cli.stages import Stages
    from morph.app.cli.target_options import TargetOptions
    from morph.app.report.loop.outcome import LoopOutcome
    from morph.policy.policy import Policy
    from morph.policy_transfer.loop import LoopRound, Transferred
    from morph.policy_transfer.loop_checkpoint import Keep
    from morph.task.task import Task

DONE, STOPPED_SHORT, INTERRUPTED = 0, 3, 130


def run_loop(options: Loop) -> int:
    """Carry a policy as asked and return the exit status.

    Raises:
        MorphError: An input cannot be used, the target cannot be tried, or a result cannot be
            written.
    """
    from morph.app.cli.loop_key import check_fresh
    from morph.app.cli.outputs import LOOP, RECORDED, check_out
    from morph.app.cli.target_options import check_choice, live_aim, told_aim
    from morph.run_folder import lock_run_folder

    # Whatever the command line got wrong is told before any work is done.
    _check_numbers(options)
    kind = check_choice(options)
    out = check_out(options.out, LOOP)
    check_fresh(options, out)
    task = _task(options)
    if kind == "recorded":
        from morph.app.cli.loop_recorded import run_recorded

        return run_recorded(options, task, out)
    _check_body(task)
    given = _given(options, task)
    aim: TargetOptions | None = None
    if kind == "told":
        aim = told_aim(options, task)
    elif kind == "live":
        aim = live_aim(options, task, out / RECORDED)
    with lock_run_folder(out):
        return _run(options, task, given, aim, out)


def _run(
    options: Loop, task: Task, given: Policy | None, aim: TargetOptions | None, out: Path
) -> int:
    """Carry a policy in a folder that nobody else works in, and return the exit status."""
    from morph.app.cli.heartbeat import beating
    from morph.app.cli.loop_key import keep_of, key_of
    from morph.app.cli.loop_text import already
    from morph.app.cli.outputs import LOOP, claim, clear

    if options.fresh:
        clear(out, LOOP, progress=True)
    claim(out, LOOP, results=False)
    keep = keep_of(out, task, key_of(options, task, given, aim))
    status = already(options, out, task)
    if status is not None:
        return status
    try:
        with beating(options.quiet) as progress:
            outcome = _carried(options, task, given, aim, keep, progress)
    except BaseException as error:
        return _ended(error, out)
    return _said(options, outcome)


def _check_numbers(options: Loop) -> None:
    if options.trials < 1:
        raise TransferError(
            f"a loop of {options.trials} trials shows nothing",
            where="--trials",
            fix="give 1 or more",
        )
    if options.seed < 0:
        raise TransferError(f"{options.seed} is no seed", where="--seed", fix="give 0 or more")


def _task(options: Loop) -> Task:
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


def _check_body(task: Task) -> None:
    """Refuse a body whose simulation cannot be repaired, before anything is tried."""
    others = [each.name for each in task.robot.joints if each.kind not in {"hinge", "slide"}]
    if others:
        raise TransferError(
            f"its joint {others[0]} is neither a hinge nor a slide, and what differs in such a "
            "body is not found by its runs yet",
            where=f"robot {task.robot.name}",
            fix="take a body that stands fixed; `morph diagnose` compares recordings of others",
        )


def _given(options: Loop, task: Task) -> Policy | None:
    """Return the policy that is named, once it fits the body and the task."""
    if options.policy is None:
        return None
    from morph.policy.store import load_policy
    from morph.search.evaluate import check_period

    policy = load_policy(options.policy, task.robot)
    check_period(policy, task)
    return policy


def _carried(
    options: Loop,
    task: Task,
    given: Policy | None,
    aim: TargetOptions | None,
    keep: Keep,
    progress: Stages,
) -> LoopOutcome:
    """Return what came of all trials, written."""
    from morph.app.cli.loop_source import source
    from morph.app.cli.outputs import LOOP, claim, clear
    from morph.app.cli.target_options import conduct_notes, live_of, sealed_aim
    from morph.app.report.loop.files import write_loop
    from morph.app.report.loop.words import round_said
    from morph.policy_transfer.loop import TransferLoop as Trials
    from morph.policy_transfer.loop import concluded

    policy, notes = source(options, task, given, progress)
    aim = sealed_aim(options, task, policy) if aim is None else aim
    live = live_of(aim)
    rounds: list[LoopRound] = []
    noticed: list[str] = []

    def ended(done: LoopRound) -> None:
        rounds.append(done)
        for line in round_said(len(rounds), done, task.robot):
            progress.line(line)
        for note in conduct_notes(live, len(rounds)):
            progress.line(f"  {note}")
            noticed.append(note)

    stopped = ""
    try:
        done: Transferred = Trials(trials=options.trials, seed=options.seed).run(
            task, policy, aim.target, keep=keep, progress=ended, say=progress.now
        )
    except MorphError as error:
        if not rounds or (isinstance(error, TrialStopped) and error.pressed):
            raise
        done, stopped = concluded(rounds), error.what
        notes = (*notes, f"{error.where}: {error.what}; {error.fix}")
    finally:
        if live is not None:
            live.close()
    progress.now("judging")
    outcome = _judged(options, task, policy, aim, done, stopped, (*notes, *noticed))
    progress.now("writing the report")
    # Results of fewer trials would be taken for these.
    clear(keep.out, LOOP, progress=False)
    claim(keep.out, LOOP, results=True)
    return write_loop(outcome, keep.out)


def _judged(
    options: Loop,
    task: Task,
    policy: Policy,
    aim: TargetOptions,
    done: Transferred,
    stopped: str,
    notes: tuple[str, ...],
) -> LoopOutcome:
    import numpy as np

    from morph.app.cli.loop_text import command
    from morph.app.report.loop.outcome import LoopOutcome
    from morph.policy_transfer.score import JUDGING, judged
    from morph.search.evaluate import evaluate

    advice = done.rounds[-1].advice
    there, concealed = aim.simulated, aim.concealed
    home = evaluate(
        task, policy, task.simulator(), rng=np.random.default_rng([options.seed, JUDGING])
    )
    return LoopOutcome(
        task=task,
        target=aim.name,
        runs=tuple(each.tried.experience for each in done.rounds),
        transferred=done,
        repair=None if advice is None else advice.repair,
        judged=None if there is None else judged(there, policy, done.policy, seed=options.seed),
        own=home.mean,
        concealed=None if concealed is None else concealed.values,
        sealed=options.sealed,
        searched=options.trials > 1,
        stopped=stopped,
        seed=options.seed,
        command=command(options),
        notes=notes,
    )


def _ended(error: BaseException, out: Path) -> int:
    """Return the status of a loop that was interrupted; leave nothing of one without a trial.

    Raises:
        MorphError: It was not interrupted, but cannot go on.
    """
    from morph.app.cli.console import harmless
    from morph.app.cli.loop_text import finished
    from morph.app.cli.outputs import LOOP, SOURCE, clear

    tried, learned = finished(out), (out / SOURCE[0]).is_file()
    if not tried and not (learned and isinstance(error, KeyboardInterrupt)):
        clear(out, LOOP, progress=True)
    pressed = isinstance(error, TrialStopped) and error.pressed
    if not (pressed or isinstance(error, KeyboardInterrupt)):
        raise error
    if isinstance(error, TrialStopped):
        sys.stderr.write(f"{harmless(f'{error.where}: {error.what}')}\n")
    trials = f"{tried} trial{'' if tried == 1 else 's'}"
    sys.stderr.write(
        f"interrupted after {trials}; the same command goes on from there, by what is in "
        f"{harmless(str(out))}\n"
        if tried or learned
        else "interrupted; nothing was written\n"
    )
    return INTERRUPTED


def _said(options: Loop, outcome: LoopOutcome) -> int:
    from morph.app.cli.loop_text import say_outcome

    say_outcome(options, outcome)
    return DONE if outcome.succeeded else STOPPED_SHORT
