"""Writing what a search found; `record.json` comes last, and makes it whole."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from morph.app.report.learn.outcome import LearnOutcome, learned, record_text
from morph.app.report.learn.page import learned_page
from morph.app.report.learn.strip import Still, strip
from morph.errors import MorphError
from morph.files import write_whole
from morph.policy.export import export_policy
from morph.policy.store import write_policy

RECORD, REPORT, STRIP, POLICY = "record.json", "report.html", "strip.jpg", "policy"
"""What a search writes; the first makes it a finished one."""


def write_learned(outcome: LearnOutcome, out: Path, *, see: str) -> LearnOutcome:
    """Write a policy, its export, pictures, the report and the record.

    Returns:
        The outcome, with notes on what could not be made: pictures where nothing draws, an
        export of a policy that no graph holds.

    Raises:
        OutputError: The folder cannot be written to.
        PolicyError: The policy does not command this body.
    """
    task, judged = outcome.task, outcome.judged
    write_policy(
        outcome.policy,
        out / POLICY,
        task.robot,
        task=task.name,
        task_sha256=task.sha256,
        learned={**learned(outcome), "succeeded": outcome.succeeded},
        seconds=task.horizon,
    )
    notes = list(outcome.notes)
    try:
        export_policy(out / POLICY, task.robot)
    except MorphError as error:
        notes.append(f"there is no policy.onnx: {error.what}")
    stills: tuple[Still, ...] = ()
    try:
        position = judged.moved.position[judged.typical]
        stills, whole = strip(task.robot, task.effects, judged.moved.time, position)
        write_whole(out / STRIP, whole)
    except MorphError as error:
        notes.append(f"there are no pictures: {error.what}")
    outcome = replace(outcome, notes=tuple(notes))
    write_whole(out / REPORT, learned_page(outcome, stills, see))
    write_whole(out / RECORD, record_text(outcome))
    return outcome
