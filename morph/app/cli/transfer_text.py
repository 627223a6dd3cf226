"""What `morph transfer` says at the end, and the command that leads to it again."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Iterator

from morph.app.cli.align_arguments import Transfer
from morph.app.cli.align_text import arrows
from morph.app.cli.console import harmless, paragraph, say, table, width
from morph.app.report.transfer.page import chain_rows
from morph.app.report.transfer.words import done, headline, saved, summary
from morph.policy_transfer.relay_record import RelayRecord

HEAD = ("hop", "transitions", "through map", "made anew", "no source", "guard")
"""Of the table of hops."""


def say_outcome(options: Transfer, record: RelayRecord) -> None:
    """Say what was found at the terminal, in words or as JSON."""
    if options.json:
        sys.stdout.write(record.text())
        return
    say(_lines(options, record, width()))


def _lines(
    options: Transfer, record: RelayRecord, columns: int | None
) -> Iterator[tuple[str, str]]:
    yield harmless(headline(record)), "bold"
    for sentence in summary(record):
        for line in paragraph(f"  {harmless(sentence)}", 4, columns):
            yield line, "" if done(record) else "yellow"
    names = ("name", "samples", "zero_shot", "final", "no_source", "guard")
    rows = [[harmless(row[name]) for name in names] for row in chain_rows(record)]
    for line in table(HEAD, rows, columns=columns, right=HEAD[1:-1]):
        yield line, ""
    for hop in record.hops:
        yield from arrows(hop.parts, hop.source, hop.target, columns)
        if given := saved(hop):
            for line in paragraph(f"  {harmless(given)}", 4, columns):
                yield line, ""
    for note in record.notes:
        for line in paragraph(f"  {harmless(note)}", 4, columns):
            yield line, "yellow"
    wrote = f"wrote policy, maps, report.html and transfer.json into {options.out}"
    for line in paragraph(harmless(wrote), 4, columns):
        yield line, ""


def command(options: Transfer) -> str:
    """Return the command that gives this result again, wherever it is to be written."""
    parts = ["morph", "transfer", "--from", options.policy, "--chain", *options.chain]
    known: dict[str, object] = {
        "--task": options.task,
        "--noise": f"{options.noise:g}",
        "--samples": " ".join(map(str, options.samples)),
        "--trials": options.trials,
        "--repeats": options.repeats,
        "--scratch": options.scratch,
        "--seed": options.seed,
    }
    for option, value in known.items():
        parts += [option, *str(value).split()]
    return shlex.join([*parts, "--out", "DIR"])
