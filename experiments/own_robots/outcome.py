"""One command in a process of its own, and what became of it."""

from __future__ import annotations

import json
import os
import re
import resource
import shlex
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from experiments.shelf import COMMAND

MEMORY = 12 << 30
"""Bytes of address space that a command may take."""
REFUSAL = re.compile(r"error: (?P<where>.+?): (?P<what>.+)\n {2}fix: (?P<fix>.+)\n?\Z", re.DOTALL)
"""How a message reads: where, what and the fix."""
OPTION = re.compile(r"(?P<name>--[a-z][a-z-]+)(?:[ =](?P<value>[^\s,;)`']+))?")
"""An option in the words of a fix, with its value."""
LONGEST = 1000
"""Characters of a message above which nobody reads it."""
FINAL = {0: "works", 2: "refused", 3: "short"}
"""By exit status; what is refused without a proper message is a bad message."""


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What became of a command."""

    command: str
    """As typed."""
    kind: str
    """`works`, `refused`, `short` (it stopped short and says so), `bad message`, `crash` or
    `too long`."""
    seconds: float
    """CPU seconds."""
    memory: float
    """Greatest resident memory, bytes."""
    message: str
    """What it wrote to standard error last."""
    record: Any = None
    """What it printed as JSON."""

    @property
    def fix(self) -> tuple[str, ...]:
        """The options that its message proposes, as typed; empty if it proposes none."""
        refusal = REFUSAL.search(self.message)
        proposed = OPTION.findall(refusal["fix"]) if refusal else []
        # A value in capitals stands for another that only the reader knows.
        known = [(name, value) for name, value in proposed if not value.isupper()]
        return tuple(part for pair in known for part in pair if part)


def outcome(words: Sequence[str], *, folder: Path, seconds: float) -> Outcome:
    """Return what becomes of `morph` with some words.

    Args:
        words: Its arguments.
        folder: Where it runs.
        seconds: CPU seconds that it may take, twice as much on the clock.
    """
    folder.mkdir(parents=True, exist_ok=True)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    out, err = folder / "stdout", folder / "stderr"

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        whole = int(seconds) + 1
        resource.setrlimit(resource.RLIMIT_CPU, (whole, whole))

    with out.open("wb") as to, err.open("wb") as errors:
        try:
            status = subprocess.run(
                [sys.executable, "-c", COMMAND, *words],
                stdout=to,
                stderr=errors,
                stdin=subprocess.DEVNULL,
                cwd=folder,
                env={**os.environ, "OMP_NUM_THREADS": "1"},
                preexec_fn=limit,
                timeout=4.0 * seconds,
                check=False,
            ).returncode
        except subprocess.TimeoutExpired:
            status = None
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    message = err.read_text(errors="replace")
    took = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    try:
        record = json.loads(out.read_text())
    except ValueError:
        record = None
    return Outcome(
        command=shlex.join(["morph", *words]),
        kind=_kind(status, message, record, took, seconds),
        seconds=took,
        memory=1024.0 * after.ru_maxrss,
        message=message[-2 * LONGEST :],
        record=record,
    )


def _kind(status: int | None, message: str, record: Any, took: float, seconds: float) -> str:
    if status is None or (status < 0 and took >= seconds):
        return "too long"
    if "Traceback (most recent call last)" in message or status not in FINAL:
        return "crash"
    refusal = REFUSAL.search(message)
    findings = isinstance(record, dict) and record.get("verdict") == "refused"
    if status == 2 and not findings and (refusal is None or len(refusal[0]) > LONGEST):
        return "bad message"
    return FINAL[status]
