"""Writing what a loop found; `transfer.json` comes last, and makes it whole."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from morph.app.report.loop.outcome import LoopOutcome
from morph.app.report.loop.page import loop_page
from morph.body.spec import spec_of
from morph.errors import MorphError
from morph.files import write_whole
from morph.model.corrected import split
from morph.physics.store import effects_text
from morph.policy.export import export_policy
from morph.policy.store import write_policy
from morph.policy_transfer.repair import Repair, TaskModel
from morph.policy_transfer.retask import task_for

RECORD, REPORT, POLICY = "transfer.json", "report.html", "policy"
"""What a loop writes; the first makes it a finished one."""

CORRECTED, EFFECTS = "corrected.xml", "corrected.toml"
"""The repaired model, and the effects that its description cannot hold."""

UNNAMED = (
    "the names leave a part unexplained: in the repaired model a learned force stands for it, "
    "which is not in corrected.xml and corrected.toml"
)
"""What is to be known of corrected files where a force was learned."""


def write_loop(outcome: LoopOutcome, out: Path) -> LoopOutcome:
    """Write the policy, the corrected model, the report and the record.

    Returns:
        The outcome, with a note on what could not be made.

    Raises:
        OutputError: The folder cannot be written to.
    """
    notes = list(outcome.notes)
    if outcome.policy is not None:
        _write_policy(outcome, out, notes)
    if outcome.repair is not None:
        write_corrected(named(outcome.repair), out)
        if outcome.repair.learned is not None:
            notes.append(UNNAMED)
    outcome = replace(outcome, notes=tuple(notes))
    write_whole(out / REPORT, loop_page(outcome))
    write_whole(out / RECORD, outcome.record().text())
    return outcome


def named(repair: Repair) -> TaskModel:
    """Return a repaired model without what no name explains, with the figures found without it."""
    if repair.learned is None:
        return repair.model
    result, own = repair.explained, len(repair.task.effects)
    there = replace(task_for(repair.task, result.robot), effects=result.effects[:own])
    return TaskModel(task=there, effects=result.effects[own:])


def write_corrected(model: TaskModel, out: Path) -> None:
    """Write a repaired model as a description and the effects beside it."""
    spec = spec_of(model.task.robot, timestep=model.task.step)
    beside, text = split(spec, (*model.task.effects, *model.effects))
    write_whole(out / CORRECTED, text)
    write_whole(out / EFFECTS, effects_text(beside))


def _write_policy(outcome: LoopOutcome, out: Path, notes: list[str]) -> None:
    task, policy, done = outcome.task, outcome.policy, outcome.transferred
    if policy is None or done is None:
        return
    probability = outcome.guard.probability
    learned = {
        "search": f"loop, {done.origin}",
        "trials": len(outcome.runs),
        "experience_s": outcome.experience,
        "seconds": done.seconds,
        "seed": outcome.seed,
        "cost": outcome.runs[outcome.kept - 1].loss,
        "success": float(outcome.succeeded) if probability is None else probability,
        "succeeded": outcome.succeeded,
    }
    write_policy(
        policy,
        out / POLICY,
        task.robot,
        task=task.name,
        task_sha256=task.sha256,
        learned=learned,
        seconds=task.horizon,
    )
    try:
        export_policy(out / POLICY, task.robot)
    except MorphError as error:
        notes.append(f"there is no policy.onnx: {error.what}")
