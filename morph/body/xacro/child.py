"""The process that expands one xacro file: xacro itself, with all doors to the outside shut."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import Any

MEMORY_BYTES = 200 * 2**20
"""Address space of the process."""

CPU_SECONDS = 5
"""Time of computing after which the system ends the process."""

HARMLESS = ("compile", "sys._getframe", "builtins.id")
"""Python's audit events that touch nothing: reading an expression as a tree, and the like."""

LISTING = ("os.listdir", "os.scandir", "os.walk")
"""Those that look into a folder."""

WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC
"""Ways to open a file that might change it."""


def main() -> None:
    """Expand what standard input asks for, and write the result to standard output."""
    request = json.loads(sys.stdin.buffer.read())
    answer, body = _answer(request)
    sys.stdout.buffer.write(json.dumps(answer).encode() + b"\n" + body)
    sys.stdout.buffer.flush()


def _answer(request: dict[str, Any]) -> tuple[dict[str, Any], bytes]:
    _limit()
    from morph.body.xacro import macros
    from morph.errors import RobotError

    _shut(Path(request["folder"]))
    path = Path(request["path"])
    try:
        done = macros.expand(
            path, Path(request["folder"]), request["arguments"], request["elements"]
        )
        return {"places": done.places, "files": done.files}, done.text
    except RobotError as error:
        return {"what": error.what, "where": error.where, "fix": error.fix}, b""
    except MemoryError:
        return {"what": "expands to more than 200 MB of memory hold"}, b""


def _limit() -> None:
    import resource

    for what, most in (
        (resource.RLIMIT_AS, MEMORY_BYTES),
        (resource.RLIMIT_CPU, CPU_SECONDS),
        (resource.RLIMIT_FSIZE, 0),
        (resource.RLIMIT_CORE, 0),
        (resource.RLIMIT_NOFILE, 32),
    ):
        hard = resource.getrlimit(what)[1]
        least = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(what, (least, least))


def _shut(folder: Path) -> None:
    """Let nothing be opened any more but files of the folder, for reading."""
    inside = (str(folder), str(folder).rstrip("/") + "/")

    def guard(event: str, arguments: tuple[Any, ...]) -> None:
        if event in LISTING:
            allowed = _within(arguments[0], inside)
        elif event == "open":
            # A number is a file that is open already.
            allowed = isinstance(arguments[0], int) or (
                _within(arguments[0], inside) and not arguments[2] & WRITING
            )
        else:
            allowed = event in HARMLESS or event.startswith("cpython.")
        if not allowed:
            raise PermissionError(f"a description may not {event} {arguments[:1]!r:.200}")

    sys.addaudithook(guard)


def _within(path: Any, inside: tuple[str, str]) -> bool:
    text = path if isinstance(path, str) else str(path)
    return text == inside[0] or text.startswith(inside[1])


if __name__ == "__main__":
    main()
