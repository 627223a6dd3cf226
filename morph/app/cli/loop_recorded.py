"""`morph loop --recorded`: what differs in a target of which there are recordings alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from morph.app.cli.arguments import Loop
from morph.app.cli.heartbeat import beating
from morph.app.cli.loop_key import keep_of, key_of_recordings
from morph.app.cli.loop_text import command, say_outcome
from morph.app.cli.outputs import LOOP, claim, clear
from morph.app.cli.stages import Stages
from morph.app.report.loop.files import write_loop
from morph.app.report.loop.outcome import LoopOutcome
from morph.model.hypothesis import Hypothesis
from morph.model.kwik.certify import ModelVerdict, judge
from morph.model.latent.run import Run
from morph.model.latent.unknowns import unknowns
from morph.policy_transfer.live.recorded import Recorded
from morph.policy_transfer.repair import MOST_RUNS, noise_of, repaired
from morph.record.load import load_recordings
from morph.run_folder import lock_run_folder
from morph.search.target import Experience
from morph.sim.threads import one_thread
from morph.task.task import Task


def run_recorded(options: Loop, task: Task, out: Path) -> int:
    """Diagnose recordings of a target and return the exit status, 0.

    Raises:
        MorphError: A recording cannot be used or the result cannot be written.
    """
    recordings = [
        each for path in options.recorded for each in load_recordings(path, robot=task.robot)
    ]
    recorded = Recorded(task=task, recordings=tuple(recordings))
    runs = recorded.runs()
    with lock_run_folder(out):
        if options.fresh:
            clear(out, LOOP, progress=True)
        claim(out, LOOP, results=False)
        # A loop's trials, its policy and its record are not to be overwritten by recordings.
        keep_of(out, task, key_of_recordings(options, recordings))
        try:
            with beating(options.quiet) as progress:
                outcome = _diagnosed(options, task, runs, recorded.repeated(), progress)
                progress.now("writing the report")
                clear(out, LOOP, progress=False)
                claim(out, LOOP, results=True)
                outcome = write_loop(outcome, out)
        except BaseException:
            if not (out / LOOP.results[0]).is_file():
                clear(out, LOOP, progress=True)
            raise
    say_outcome(options, outcome)
    return 0


def _diagnosed(
    options: Loop,
    task: Task,
    runs: tuple[Experience, ...],
    noticed: tuple[str, ...],
    progress: Stages,
) -> LoopOutcome:
    notes = list(noticed)
    if len(runs) > MOST_RUNS:
        notes.append(f"the model is repaired by the last {MOST_RUNS} of {len(runs)} recordings")
    seen = [run.run for run in runs]
    progress.now("is the model good enough")
    verdict = gate(task, seen[-MOST_RUNS:], options.seed)
    progress.line(verdict.text)
    return LoopOutcome(
        task=task,
        target=f"{task.robot.name}, recorded",
        runs=runs,
        transferred=None,
        repair=repaired(task, seen, progress=progress.now),
        asked=verdict,
        seed=options.seed,
        command=command(options),
        notes=tuple(notes),
    )


def gate(task: Task, runs: list[Run], seed: int) -> ModelVerdict:
    """Return whether the model as described is good enough for what was recorded."""
    simulator = task.simulator()
    hypothesis = Hypothesis(
        robot=task.robot, step=task.step, knobs=unknowns(task.robot), effects=task.effects
    )
    with one_thread():
        return judge(
            hypothesis,
            runs,
            noise_of(task, simulator),
            integrator=simulator.integrator,
            rng=np.random.default_rng([seed, 2]),
        )
