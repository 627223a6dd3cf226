"""`morph loop`: a policy carried to a target, what the model lacked, and how good it is there."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from morph.app.cli.arguments import Loop
from morph.errors import MorphError, TrialStopped

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
    from morph.app.cli.loop_text import already
    from morph.run_folder import lock_run_folder

    task, out = _prepared(options)
    if options.recorded:
        from morph.app.cli.loop_recorded import run_recorded

        return run_recorded(options, task, out)
    given, aim = _target(options, task, out)
    with lock_run_folder(out):
        keep = _kept(options, task, given, aim, out)
        status = already(options, out, task)
        if status is not None:
            return status
        try:
            outcome = _carried(options, task, given, aim, keep)
        except BaseException as error:
            return _ended(error, out)
    return _said(options, outcome)


def looped(options: Loop) -> LoopOutcome:
    """Carry a policy to a target and return what came of it, which is written to `out` too.

    Raises:
        MorphError: An input cannot be used, the target cannot be tried, or a result cannot be
            written.
    """
    from morph.run_folder import lock_run_folder

    task, out = _prepared(options)
    given, aim = _target(options, task, out)
    with lock_run_folder(out):
        keep = _kept(options, task, given, aim, out)
        try:
            return _carried(options, task, given, aim, keep)
        except BaseException:
            _forget(out)
            raise


def _prepared(options: Loop) -> tuple[Task, Path]:
    """Return the source's task and the folder, once both can be used."""
    from morph.app.cli.loop_inputs import check_numbers, task_of
    from morph.app.cli.loop_key import check_fresh
    from morph.app.cli.outputs import LOOP, check_out
    from morph.app.cli.target_options import check_choice

    # Whatever the command line got wrong is told before any work is done.
    check_numbers(options)
    check_choice(options)
    out = check_out(options.out, LOOP)
    check_fresh(options, out)
    return task_of(options), out


def _target(options: Loop, task: Task, out: Path) -> tuple[Policy | None, TargetOptions | None]:
    """Return the policy that is given, and the target, which is None while it is sealed."""
    from morph.app.cli.loop_inputs import check_body, policy_of
    from morph.app.cli.outputs import RECORDED
    from morph.app.cli.target_options import check_choice, live_aim, told_aim

    check_body(task)
    given, kind = policy_of(options, task), check_choice(options)
    if kind == "told":
        return given, told_aim(options, task)
    return given, live_aim(options, task, out / RECORDED) if kind == "live" else None


def _kept(
    options: Loop, task: Task, given: Policy | None, aim: TargetOptions | None, out: Path
) -> Keep:
    """Return the checkpoint in a folder that nobody else works in."""
    from morph.app.cli.loop_key import keep_of, key_of
    from morph.app.cli.outputs import LOOP, claim, clear

    if options.fresh:
        clear(out, LOOP, progress=True)
    claim(out, LOOP, results=False)
    return keep_of(out, task, key_of(options, task, given, aim))


def _carried(
    options: Loop, task: Task, given: Policy | None, aim: TargetOptions | None, keep: Keep
) -> LoopOutcome:
    """Return what came of all trials, written."""
    from morph.app.cli.heartbeat import beating

    with beating(options.quiet) as progress:
        return _tried(options, task, given, aim, keep, progress)


def _tried(
    options: Loop,
    task: Task,
    given: Policy | None,
    aim: TargetOptions | None,
    keep: Keep,
    progress: Stages,
) -> LoopOutcome:
    from morph.app.cli.loop_inputs import source
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
    from morph.app.cli.outputs import SOURCE

    tried, learned = finished(out), (out / SOURCE[0]).is_file()
    if not (learned and isinstance(error, KeyboardInterrupt)):
        _forget(out)
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


def _forget(out: Path) -> None:
    """Leave nothing of a loop without a trial."""
    from morph.app.cli.loop_text import finished
    from morph.app.cli.outputs import LOOP, clear

    if not finished(out):
        clear(out, LOOP, progress=True)


def _said(options: Loop, outcome: LoopOutcome) -> int:
    from morph.app.cli.loop_text import say_outcome

    say_outcome(options, outcome)
    return DONE if outcome.succeeded else STOPPED_SHORT
