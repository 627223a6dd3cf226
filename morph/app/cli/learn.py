"""`morph learn`: a policy for a task, how it was found, and how good it is."""

from __future__ import annotations

import shlex
import sys
import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from morph.app.cli.arguments import Learn

if TYPE_CHECKING:
    from morph.app.cli.search_checkpoint import Before, Checkpoint
    from morph.app.report.learn.outcome import LearnOutcome
    from morph.search.search import Learned, Search, State, Trial
    from morph.task.task import Task

DONE, STOPPED_SHORT, INTERRUPTED = 0, 3, 130


def run_learn(options: Learn) -> int:
    """Search as asked and return the exit status.

    Raises:
        MorphError: An input cannot be used, the search cannot be made, or a result cannot be
            written.
    """
    from morph.app.cli.outputs import LEARN, check_out
    from morph.run_folder import lock_run_folder
    from morph.search.search import check_numbers

    # Whatever the command line got wrong is told before any work is done.
    check_numbers(options.trials, options.seed)
    out = check_out(options.out, LEARN)
    # Both names are checked before a robot is read, which takes longer.
    _check_names(options)
    task = _task(options)
    search = _search(options, task)
    with lock_run_folder(out):
        # What held it before may have left something else there.
        check_out(options.out, LEARN)
        return _run(options, task, search, out)


def _run(options: Learn, task: Task, search: Search, out: Path) -> int:
    """Search in a folder that nobody else works in, and return the exit status."""
    from morph.app.cli.outputs import LEARN, claim, clear
    from morph.app.cli.search_checkpoint import Before, Checkpoint

    checkpoint = Checkpoint(out, _key(options, task, search))
    before = Before() if options.fresh else checkpoint.before()
    status = None if options.fresh else _already(options, out)
    if status is not None:
        return status
    try:
        learned, took = _searched(options, task, search, checkpoint, before)
        if options.fresh:
            # Had the search told nothing, what is there would still be the earlier one's.
            clear(out, LEARN, progress=True)
        claim(out, LEARN, results=True)
        checkpoint.write()
        outcome = _written(options, task, search, learned, took)
    except KeyboardInterrupt:
        return _interrupted(out, checkpoint)
    _say(options, outcome)
    return DONE if outcome.succeeded else STOPPED_SHORT


def _task(options: Learn) -> Task:
    """Return the task in the world and under the effects that are asked for."""
    from morph.app.cli.effects import asked_effects
    from morph.body.load import load
    from morph.body.postures import postured
    from morph.physics.worlds import world
    from morph.task.tasks import task

    robot = load(options.robot, base=options.base, folder=options.folder)
    robot = postured(robot, options.posture)
    result = task(options.task, robot)
    around = result.effects if options.world is None else world(options.world, robot).effects
    file = None if options.effects is None else Path(options.effects)
    effects = asked_effects(robot, options.effect, file=file, world=around)
    return replace(result, world=options.world or result.world, effects=effects)


def _check_names(options: Learn) -> None:
    """Refuse a task or a search that there is not."""
    from morph.search.searches import search
    from morph.task.tasks import check_name

    check_name(options.task)
    if options.search is not None:
        search(options.search)


def _search(options: Learn, task: Task) -> Search:
    """Return the search that is asked for, or the one that suits the task of this body."""
    from morph.search.searches import default, search

    return search(options.search or default(options.task, task.robot))()


def _key(options: Learn, task: Task, search: Search) -> dict[str, str]:
    from morph.app.report.learn.outcome import robot_hash

    return {
        "task": task.sha256,
        "body": robot_hash(task),
        "search": repr(search),
        "seed": str(options.seed),
    }


def _already(options: Learn, out: Path) -> int | None:
    """Return the status of a finished search, told once more; None if there is more to do."""
    from morph.app.cli.console import harmless
    from morph.app.cli.search_checkpoint import record_of

    before = record_of(out)
    if before is None:
        return None
    text, statement = before
    same, succeeded = (
        statement.get("asked_trials") == options.trials,
        bool(statement.get("succeeded")),
    )
    if not same:
        return None
    if options.json:
        sys.stdout.write(text)
    else:
        did = "succeeded" if succeeded else "did not succeed"
        sys.stdout.write(
            f"{harmless(str(out))} holds this search already, and it {did}: see report.html "
            "in it; --trials goes on with more, --fresh begins anew\n"
        )
    return DONE if succeeded else STOPPED_SHORT


def _searched(
    options: Learn, task: Task, search: Search, checkpoint: Checkpoint, before: Before
) -> tuple[Learned, float]:
    """Return what the search found, and how long it took, also before an interrupt."""
    from morph.app.cli.progress import progress
    from morph.app.cli.resume_search import going_on

    problem = search.problem(task)
    spent = before.trials[-1].seconds if before.trials else 0.0
    began = time.perf_counter() - spent
    with progress(options.quiet, f"{task.name} of {task.robot.name} by {search.name}") as show:

        def told(trial: Trial, state: State) -> None:
            # By this clock, which has run on since before the interrupt.
            trial = replace(trial, seconds=time.perf_counter() - began)
            checkpoint.add(trial, state)
            show(trial)

        with going_on(checkpoint.out, before):
            learned = search.run(
                problem, seed=options.seed, trials=options.trials, progress=told, state=before.state
            )
    known = {trial.number for trial in checkpoint.trials}
    checkpoint.trials += [trial for trial in learned.trials if trial.number not in known]
    ordered = tuple(sorted(checkpoint.trials, key=lambda trial: trial.number))
    return replace(learned, trials=ordered), time.perf_counter() - began


def _written(
    options: Learn, task: Task, search: Search, learned: Learned, took: float
) -> LearnOutcome:
    from morph.app.report.learn.files import write_learned
    from morph.app.report.learn.outcome import LearnOutcome

    outcome = LearnOutcome.of(
        task,
        search,
        learned,
        seed=options.seed,
        asked=options.trials,
        seconds=took,
        command=_command(options, search),
    )
    return write_learned(outcome, Path(options.out), see=_see(options, task))


def _interrupted(out: Path, checkpoint: Checkpoint) -> int:
    from morph.app.cli.console import harmless

    checkpoint.write()
    sys.stderr.write(
        f"interrupted after {len(checkpoint.trials)} trials; the same command goes on from there, "
        f"by {harmless(str(out))}/state.npz\n"
        if checkpoint.trials
        else "interrupted; nothing was written\n"
    )
    return INTERRUPTED


def _say(options: Learn, outcome: LearnOutcome) -> None:
    from morph.app.cli.console import harmless, paragraph, say, width
    from morph.app.report.learn.outcome import record_text
    from morph.app.report.learn.words import headline, summary

    if options.json:
        sys.stdout.write(record_text(outcome))
        return
    columns = width()
    lines = [(harmless(headline(outcome)), "bold")]
    if not outcome.succeeded:
        lines.append((f"  it did not succeed: {outcome.why}", "yellow"))
    lines += [(f"  {sentence}", "") for sentence in summary(outcome)]
    lines += [(f"  {note}", "yellow") for note in outcome.notes]
    lines.append((f"wrote {options.out}/policy, and {options.out}/report.html on it", ""))
    lines.append((f"see it by: {_see(options, outcome.task)}", ""))
    say(
        (piece, style)
        for text, style in lines
        for piece in paragraph(harmless(text.replace("\N{NO-BREAK SPACE}", " ")), 4, columns)
    )


def _options(pairs: Mapping[str, object]) -> list[str]:
    """Return options and their values; one that was left out has none."""
    parts: list[str] = []
    for option, value in pairs.items():
        for each in value if isinstance(value, tuple) else (value,):
            parts += [option, str(each)] if each is not None else []
    return parts


def _shared(options: Learn) -> dict[str, object]:
    return {
        "--effects": options.effects,
        "--effect": options.effect,
        "--base": options.base,
        "--folder": options.folder,
        "--posture": options.posture,
    }


def _command(options: Learn, search: Search) -> str:
    """Return the command that gives this result again, wherever it is to be written."""
    known = {
        "--robot": options.robot,
        "--search": search.name,
        "--trials": options.trials,
        "--seed": options.seed,
        "--world": options.world,
        **_shared(options),
        "--out": "DIR",
    }
    return shlex.join(["morph", "learn", options.task, *_options(known)])


def _see(options: Learn, task: Task) -> str:
    """Return the command that shows the policy at work."""
    from morph.physics.worlds import start_in

    usual = start_in(task.robot, task.world)
    position = {k: v for k, v in task.start.position.items() if usual.get(k) != v}
    known = {
        "--policy": f"{options.out}/policy",
        "--world": task.world,
        **_shared(options),
        "--start": tuple(f"{name}={value:.6g}" for name, value in position.items()),
        "--speed": tuple(f"{name}={value:.6g}" for name, value in task.start.speed.items()),
        "--seconds": f"{task.horizon:g}",
        "--step": f"{task.step:g}",
        "--integrator": task.integrator,
    }
    return shlex.join(["morph", "simulate", options.robot, *_options(known), "--view"])
