"""What `morph loop` says at the end, and the command that leads to it again."""

from __future__ import annotations

import json
import shlex
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from morph.app.cli.arguments import Loop
from morph.errors import MorphError
from morph.regular_file import read_regular

if TYPE_CHECKING:
    from morph.app.report.loop.outcome import LoopOutcome
    from morph.task.task import Task

HEAD = ("trial", "policy", "loss", "came of it", "the model was", "what differs", "next")
"""Of the table of trials."""

MOST_BYTES = 2**24
"""Longest record of a loop, bytes; one of a hundred trials has 0.2 MB."""


def finished(out: Path) -> int:
    """Return how many trials a folder keeps."""
    return len(list(out.glob("trials/*/experience.npz")))


def already(options: Loop, out: Path, task: Task) -> int | None:
    """Return the status of a finished loop, told once more; None if there is more to do.

    A record that is spoilt, or whose policy is gone, is none: the trials are there, and all else
    is computed again.
    """
    from morph.app.cli.console import harmless

    result = _finished(out, task)
    if result is None:
        return None
    text, succeeded, tried = result
    if not succeeded and tried < options.trials:
        return None
    if options.json:
        sys.stdout.write(text)
    else:
        did = "succeeded" if succeeded else "did not succeed"
        sys.stdout.write(
            f"{harmless(str(out))} holds this loop already, and it {did}: see report.html in it; "
            "--fresh begins anew, and more --trials go on where another policy is advised\n"
        )
    return 0 if succeeded else 3


def _finished(out: Path, task: Task) -> tuple[str, bool, int] | None:
    """Return a whole record's text, whether it succeeded, and how many trials it tells of."""
    from morph.policy.store import load_policy
    from morph.policy_transfer.transfer_record import SCHEMA

    try:
        text = read_regular(out / "transfer.json", MOST_BYTES).decode()
        document = json.loads(text)
        (hop,) = document["hops"]
        succeeded, trials = hop["succeeded"], hop["trials"]
        whole = document["schema"] == SCHEMA and document["task"]["sha256"] == task.sha256
        fits = isinstance(succeeded, bool) and len(trials) == finished(out) > 0
        if not (whole and fits and (out / "report.html").is_file()):
            return None
        load_policy(out / "policy", task.robot)
    except (OSError, ValueError, KeyError, TypeError, MorphError):
        return None
    return text, succeeded, len(trials)


def say_outcome(options: Loop, outcome: LoopOutcome) -> None:
    """Say what was found at the terminal, in words or as JSON."""
    from morph.app.cli.console import harmless, paragraph, say, width

    if options.json:
        sys.stdout.write(outcome.record().text())
        return
    columns = width()
    say(
        (piece, style)
        for text, style, as_is in _lines(options, outcome, columns)
        for piece in (
            [harmless(text)]
            if as_is
            else paragraph(harmless(text.replace("\N{NO-BREAK SPACE}", " ")), 4, columns)
        )
    )


def _lines(
    options: Loop, outcome: LoopOutcome, columns: int | None
) -> Iterator[tuple[str, str, bool]]:
    """Yield each text, its style, and whether it is laid out already."""
    from morph.app.cli.console import table
    from morph.app.report.loop.verdict import headline, rivals_said, sealed_rows, summary
    from morph.app.report.loop.words import differences

    yield headline(outcome), "bold", False
    if outcome.why:
        yield f"  it did not succeed: {outcome.why}", "yellow", False
    for sentence in summary(outcome):
        yield f"  {sentence}", "", False
    lacked = differences(outcome.differences, outcome.task.robot)
    if outcome.repair is not None:
        yield "what differs:", "bold", False
        for sentence in lacked or ("nothing that these runs can tell",):
            yield f"  {sentence}", "", False
        for sentence in rivals_said(outcome):
            yield f"  {sentence}", "", False
    if outcome.rounds:
        for line in table(HEAD, list(_rows(outcome)), columns=columns, right=("trial", "loss")):
            yield line, "", True
    sealed = sealed_rows(outcome)
    if sealed:
        opened = "the seal, opened:" if outcome.sealed is not None else "what was concealed:"
        yield opened, "bold", False
        for row in sealed:
            between = f" ({row['interval']})" if row["interval"] else ""
            result = f", found as {row['found']}{between}" if row["found"] else ""
            yield f"  {row['truth']}{result}: {row['verdict']}", "", False
    for note in outcome.notes:
        yield f"  {note}", "yellow", False
    made = "policy, " if outcome.policy is not None else ""
    model = ", corrected.xml with corrected.toml" if outcome.repair is not None else ""
    yield f"wrote {made}report.html{model} and transfer.json into {options.out}", "", False


def _rows(outcome: LoopOutcome) -> Iterator[tuple[str, ...]]:
    from morph.app.report.loop.page import trial_rows

    for row in trial_rows(outcome):
        cells = (row[name] for name in ("origin", "loss", "outcome", "gate", "lacked", "next"))
        yield (str(row["number"]), *(str(cell) for cell in cells))


def command(options: Loop) -> str:
    """Return the command that gives this result again, wherever it is to be written."""
    known: dict[str, object] = {
        "--robot": options.robot,
        "--policy": options.policy,
        "--change": options.change,
        "--effect": options.effect,
        "--effects": options.effects,
        "--sealed": options.sealed,
        "--live": options.live,
        "--limit": options.limit,
        "--stop-file": options.stop_file,
        "--trials": None if options.recorded else options.trials,
        "--seed": options.seed,
        "--world": options.world,
        "--base": options.base,
        "--folder": options.folder,
    }
    parts: list[str] = []
    for option, value in known.items():
        for each in value if isinstance(value, tuple) else (value,):
            parts += [] if each is None else [option, str(each)]
    if options.recorded:
        parts += ["--recorded", *map(str, options.recorded)]
    return shlex.join(["morph", "loop", options.task, *parts, "--out", "DIR"])
