"""The error for a description without a robot, with everything found in it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from morph.body.finding import DescriptionFinding, Where
from morph.errors import DescriptionRefused, RobotError


def refusal(findings: Sequence[DescriptionFinding]) -> DescriptionRefused:
    """Return the error for findings of which some are `refused`."""
    refused = [finding for finding in findings if finding.severity == "refused"]
    first, more = refused[0], len(refused) - 1
    where = f"{first.where.file}:{first.where.line}" if first.where.line else first.where.file
    named = "" if first.where.kind == "file" else f"{first.where.kind} {first.where.name!r}: "
    return DescriptionRefused(
        named + first.what + (f" (and {more} more of these)" if more else ""),
        where=where,
        fix=first.fix,
        findings=tuple(findings),
    )


def about_file(error: RobotError, path: Path, *, code: str = "file-refused") -> DescriptionFinding:
    """Return an error as a finding about a file, at the line that it names."""
    file, _, line = error.where.rpartition(":")
    known = bool(file) and line.isdigit()
    return DescriptionFinding(
        code=getattr(error, "code", code),
        severity="refused",
        where=Where(
            kind="file",
            name=path.name,
            file=file if known else error.where,
            line=int(line) if known else 0,
        ),
        what=error.what,
        fix=error.fix,
    )
