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


def already(asked: Loop, out: Path, task: Task) -> int | None:
    """Return the status of a finished loop, told once more; None if there is more to do.

    A record that is spoilt, or whose policy is gone, is none: the trials are there, and all else
    is computed again.
    """
    from morph.app.cli.console import harmless

    found = _finished(out, task)
    if found is None:
        return None
    text, succeeded, tried = found
    if not succeeded and tried < asked.trials:
        return None
    if asked.json:
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
    from morph.transfer.record import SCHEMA

    try:
        text = read_regular(out / "transfer.json", MOST_BYTES).decode()
        said = json.loads(text)
        (hop,) = said["hops"]
        succeeded, trials = hop["succeeded"], hop["trials"]
        whole = said["schema"] == SCHEMA and said["task"]["sha256"] == task.sha256
        fits = isinstance(succeeded, bool) and len(trials) == finished(out) > 0
        if not (whole and fits and (out / "report.html").is_file()):
            return None
        load_policy(out / "policy", task.robot)
    except (OSError, ValueError, KeyError, TypeError, MorphError):
        return None
    return text, succeeded, len(trials)


def say_outcome(asked: Loop, outcome: LoopOutcome) -> None:
    """Say what was found at the terminal, in words or as JSON."""
    from morph.app.cli.console import harmless, paragraph, say, width

    if asked.json:
        sys.stdout.write(outcome.record().text())
        return
    columns = width()
    say(
        (piece, style)
        for text, style, as_is in _lines(asked, outcome, columns)
        for piece in (
            [harmless(text)]
            if as_is
            else paragraph(harmless(text.replace("\N{NO-BREAK SPACE}", " ")), 4, columns)
        )
    )


def _lines(
    asked: Loop, outcome: LoopOutcome, columns: int | None
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
            found = f", found as {row['found']}{between}" if row["found"] else ""
            yield f"  {row['truth']}{found}: {row['verdict']}", "", False
    for note in outcome.notes:
        yield f"  {note}", "yellow", False
    made = "policy, " if outcome.policy is not None else ""
    model = ", corrected.xml with corrected.toml" if outcome.repair is not None else ""
    yield f"wrote {made}report.html{model} and transfer.json into {asked.out}", "", False


def _rows(outcome: LoopOutcome) -> Iterator[tuple[str, ...]]:
    from morph.app.report.loop.page import trial_rows

    for row in trial_rows(outcome):
        cells = (row[name] for name in ("origin", "loss", "outcome", "gate", "lacked", "next"))
        yield (str(row["number"]), *(str(cell) for cell in cells))


def command(asked: Loop) -> str:
    """Return the command that gives this result again, wherever it is to be written."""
    told: dict[str, object] = {
        "--robot": asked.robot,
        "--policy": asked.policy,
        "--change": asked.change,
        "--effect": asked.effect,
        "--effects": asked.effects,
        "--sealed": asked.sealed,
        "--live": asked.live,
        "--limit": asked.limit,
        "--stop-file": asked.stop_file,
        "--trials": None if asked.recorded else asked.trials,
        "--seed": asked.seed,
        "--world": asked.world,
        "--base": asked.base,
        "--folder": asked.folder,
    }
    parts: list[str] = []
    for option, value in told.items():
        for each in value if isinstance(value, tuple) else (value,):
            parts += [] if each is None else [option, str(each)]
    if asked.recorded:
        parts += ["--recorded", *map(str, asked.recorded)]
    return shlex.join(["morph", "loop", asked.task, *parts, "--out", "DIR"])
