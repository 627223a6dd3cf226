"""`morph view` as a command, and what it needs of time and memory."""

from __future__ import annotations

import re
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from experiments.viewed.browser import free_port
from morph.errors import OutputError

COMMAND = (sys.executable, "-c", "from morph.app.cli.main import entry; entry()", "view")

LONG = 120.0
"""s after which a command that serves nothing is given up."""


@dataclass(frozen=True, kw_only=True)
class Served:
    """A viewer that runs as a command."""

    process: subprocess.Popen[str]
    """The command."""
    began: float
    """When it was given, s of the epoch."""
    told: float
    """When it told its address."""
    address: str
    """Where to look."""

    def memory(self) -> tuple[float, float]:
        """Return its memory now and at its most, MB (1e6 bytes)."""
        return memory(self.process.pid)


def memory(process: int) -> tuple[float, float]:
    """Return a process's memory now and at its most, MB (1e6 bytes)."""
    text = Path(f"/proc/{process}/status").read_text(encoding="ascii")
    now, most = (
        1.024e-3 * int(re.findall(rf"^{key}:\s+(\d+) kB", text, re.MULTILINE)[0])
        for key in ("VmRSS", "VmHWM")
    )
    return now, most


@contextmanager
def serving(*words: str) -> Iterator[Served]:
    """Serve by `morph view` with some words, until the block ends.

    Raises:
        OutputError: The command serves nothing.
    """
    began = time.time()
    process = subprocess.Popen(
        [*COMMAND, *words, "--port", str(free_port())],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        address, said = "", ""
        while not address:
            line = process.stderr.readline() if process.stderr else ""
            said += line
            if not line or time.time() - began > LONG:
                raise OutputError(
                    f"nothing is served: {said.strip() or 'the command is silent'}",
                    where=f"morph view {' '.join(words)}",
                    fix="give the command by hand",
                )
            found = re.search(r"http://\S+", line)
            address = found[0] if found else ""
        yield Served(process=process, began=began, told=time.time(), address=address)
    finally:
        process.kill()
        process.communicate()
