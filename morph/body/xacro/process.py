"""Expanding xacro, the macros of URDF, from strangers: in a process of its own, within bounds."""

from __future__ import annotations

import contextlib
import json
import os
import selectors
import signal
import subprocess
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from morph.body.xacro.bound import MOST_EXPANDED
from morph.body.xacro.check import check
from morph.body.xacro.folder import Folder
from morph.body.xml import MOST_BYTES, Element, parse
from morph.errors import RobotError

SECONDS = 10.0
"""Longest wait for the process on the clock; it computes for less, but may not get a core."""

MOST_OPEN = 20_000
"""Steps for a description whose macros call themselves: nobody can say beforehand where it ends.

A robot of 2500 elements takes some 12 000.
"""

# Neither the user's settings nor the folder that they stand in have a say in what is imported.
COMMAND = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from morph.body.xacro.child import main; main()"
)


def expand(path: Path, folder: Path, arguments: Mapping[str, str] | None = None) -> bytes:
    """Return the plain URDF that a `.xacro` file expands to.

    Files are read in `folder` only, and nothing is written. `$(find package)` is
    the folder inside it whose package.xml bears that name, or that is called so.
    The environment is not read: `$(optenv name default)` is its default.

    Args:
        path: The file.
        folder: The description's own folder: the outermost that the user named.
        arguments: Values of `$(arg name)`; where one is missing, its default.

    Raises:
        RobotError: It cannot be expanded, reaches outside the folder, has an
            expression that could do more than reckon, or would grow beyond
            bounds; the file and line are named.
    """
    text = _expanded(path, folder, arguments or {})[1]
    parse(text, str(path))
    return text


def read(path: Path, folder: Path, arguments: Mapping[str, str] | None = None) -> Element:
    """Return the same as a tree, each element with the file and line of the xacro it came from.

    Raises:
        RobotError: As for `expand`.
    """
    answer, text = _expanded(path, folder, arguments or {})
    root = parse(text, str(path))
    files = answer["files"]
    for element, (file, line) in zip(root.everything(), answer["places"], strict=True):
        element.file, element.line = files[file], line
    return root


def _expanded(
    path: Path, folder: Path, arguments: Mapping[str, str]
) -> tuple[dict[str, Any], bytes]:
    own = Folder(folder)
    try:
        # The way to its folder is the user's; links from there on are the description's.
        beside = Path(os.path.realpath(path.parent))
        real = own.inside(beside / path.name, str(path))
        closed = check(real, own, arguments)
    except FileNotFoundError as error:
        raise RobotError("is not there", where=str(path), fix="give a file that exists") from error
    request = {
        "path": str(real),
        "folder": str(own.root),
        "arguments": dict(arguments),
        # An element is copied and visited several times on its way.
        "elements": 5 * MOST_EXPANDED if closed else MOST_OPEN,
    }
    answer, text = _ask(json.dumps(request).encode(), path)
    if "what" in answer:
        raise RobotError(
            answer["what"],
            where=answer.get("where") or str(path),
            fix=answer.get("fix") or "describe one robot, with fewer macros",
        )
    return answer, text


def _ask(request: bytes, path: Path) -> tuple[dict[str, Any], bytes]:
    """Return what the process answers: what it has to say, and the text."""
    try:
        process = subprocess.Popen(
            [sys.executable, "-I", "-S", "-B", "-X", "utf8", "-c", COMMAND, json.dumps(_paths())],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            cwd="/",
            env={key: os.environ[key] for key in ("LD_LIBRARY_PATH",) if key in os.environ},
            start_new_session=True,
        )
    except OSError as error:
        raise RobotError(
            f"needs a process to expand it, and there is none: {error.strerror or error}",
            where=str(path),
            fix="close other programs, or expand it with xacro and give the URDF",
        ) from error
    try:
        statement, whole = _spoken(process, request)
    finally:
        # The whole group, so that nothing that it may have started is left.
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        for pipe in (process.stdin, process.stdout):
            if pipe is not None:
                with contextlib.suppress(OSError):
                    pipe.close()
    line, mark, text = statement.partition(b"\n")
    if whole and mark:
        answer: dict[str, Any] = json.loads(line)
        return answer, text
    return {"what": f"expands to more than {MOST_BYTES} bytes, or for too long"}, b""


def _spoken(process: subprocess.Popen[bytes], request: bytes) -> tuple[bytes, bool]:
    """Return what a process says, and whether it came to an end in time and within bounds."""
    stdin, stdout = process.stdin, process.stdout
    if stdin is None or stdout is None:
        return b"", False
    end, output = time.monotonic() + SECONDS, bytearray()
    with contextlib.suppress(BrokenPipeError), selectors.DefaultSelector() as selector:
        stdin.write(request)
        stdin.close()
        selector.register(stdout, selectors.EVENT_READ)
        while len(output) <= 2 * MOST_BYTES and selector.select(max(end - time.monotonic(), 0.0)):
            piece = os.read(stdout.fileno(), 2**16)
            if not piece:
                return bytes(output), True
            output += piece
    return b"", False


def _paths() -> list[str]:
    """Return where modules are found; never the folder that the user happens to stand in."""
    home = str(Path(__file__).resolve().parents[2])
    return [*(path for path in sys.path if path), home]
