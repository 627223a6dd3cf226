"""Writing a transfer along a chain; `transfer.json` comes last, and makes it whole."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from morph.app.report.transfer.page import transfer_page
from morph.errors import MorphError
from morph.files import write_whole
from morph.policy.export import export_policy
from morph.policy.store import write_policy
from morph.policy_transfer.body import Body
from morph.policy_transfer.hop_checkpoint import Kept
from morph.policy_transfer.policy_conversion import stored
from morph.policy_transfer.relay_record import RelayRecord

RECORD, REPORT, POLICY = "transfer.json", "report.html", "policy"
"""What a transfer writes beside its maps; the first makes it a finished one."""


def write_transfer(
    record: RelayRecord, last: Body, done: Kept, trials: int, out: Path
) -> RelayRecord:
    """Write the last body's policy, the report and the record.

    Args:
        record: What was found.
        last: The body that the last hop led to.
        done: That hop.
        trials: Runs over which policies were judged.
        out: The folder; the maps are in it already.

    Returns:
        The record, with a note on what could not be made.

    Raises:
        OutputError: The folder cannot be written to.
    """
    # A record of fewer hops, or of another report, would be taken for this one.
    (out / RECORD).unlink(missing_ok=True)
    task, final = last.task, done.crossing.scores["final"]
    learned = {
        "search": "relay",
        "trials": 0,
        "experience_s": record.samples * task.period,
        "seconds": record.seconds,
        "seed": record.seed,
        "score": final,
        "guard": done.crossing.guard.verdict,
        "succeeded": done.crossing.good,
    }
    write_policy(
        stored(last, done.gain, done.shift),
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
        record = replace(record, notes=(*record.notes, f"there is no policy.onnx: {error.what}"))
    write_whole(out / REPORT, transfer_page(record, trials))
    write_whole(out / RECORD, record.text())
    return record
