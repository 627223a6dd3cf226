"""A process that speaks JSON lines, as a live target."""

from __future__ import annotations

import contextlib
import os
import subprocess
import time
from collections.abc import Mapping, Sequence
from typing import Any

from morph.errors import TransferError
from morph.policy_transfer.live.connection import Connection, Heard
from morph.policy_transfer.live.pipe_lines import Reader, Tail, write
from morph.policy_transfer.live.protocol import SCHEMA, Hello, hello_of, line_of

WRITE = 0.5
"""Longest that a target may leave what it is told unread, s."""

LEAVE = 2.0
"""How long a process has to end once nobody speaks with it, s; then as long after SIGTERM."""

LAST = 0.1
"""How long what a process said before it ended may take to be heard, s."""

MOST_UNREADABLE = 100
"""Lines before its first message that may be something else, such as a greeting."""


class Process(Connection):
    """A process that says states on its output and reads commands from its input.

    It is started when it is first needed, in a session of its own: Ctrl-C reaches morph alone,
    which tells the target to stop. It must hold itself safe when its input ends.

    Args:
        argv: The program and its arguments.
        name: How messages call it; its program if left out.
    """

    def __init__(self, argv: Sequence[str], *, name: str = "") -> None:
        self._argv = list(argv)
        self.name = name or f"target {os.path.basename(self._argv[0])}"
        self._process: subprocess.Popen[bytes] | None = None
        self._hello: Hello | None = None

    def open(self, seconds: float) -> Hello:
        """Return what the process says of itself; it is started if it does not run."""
        if self._process is not None and self._hello is not None:
            return self._hello
        self._start()
        try:
            self._hello = self._first(seconds)
        except TransferError:
            self.close()
            raise
        return self._hello

    def _start(self) -> None:
        # Pipes of our own: each end has one owner, which closes it.
        theirs_in, self._input = os.pipe()
        out, theirs_out = os.pipe()
        errors, theirs_errors = os.pipe()
        try:
            self._process = subprocess.Popen(
                self._argv,
                stdin=theirs_in,
                stdout=theirs_out,
                stderr=theirs_errors,
                start_new_session=True,
            )
        except OSError as error:
            for end in (self._input, out, errors):
                os.close(end)
            raise TransferError(
                f"it cannot be started: {error.strerror or error}",
                where=self.name,
                fix="give a program that exists and may be run, and its arguments apart from it",
            ) from error
        finally:
            for end in (theirs_in, theirs_out, theirs_errors):
                os.close(end)
        os.set_blocking(self._input, False)
        self._reader, self._errors = Reader(out), Tail(errors)

    def _first(self, seconds: float) -> Hello:
        until, unreadable = time.monotonic() + seconds, 0
        while (left := until - time.monotonic()) > 0.0 and unreadable <= MOST_UNREADABLE:
            heard = self.hear(left)
            if heard is None:
                break
            if heard.ended:
                raise TransferError(
                    f"{heard.ended} before it said who it is",
                    where=self.name,
                    fix="run it by hand, and see what it says",
                )
            if not heard.unreadable:
                return hello_of(heard.said, where=self.name)
            unreadable += 1
        raise TransferError(
            f"in {seconds:g} s it did not say who it is"
            + (f"; {unreadable} lines are no JSON objects" if unreadable else ""),
            where=self.name,
            fix=f'let its first line be {{"schema": "{SCHEMA}", ...}}, and flush its output',
        )

    def begin(self, message: Mapping[str, Any]) -> None:
        """Tell it to begin; what it said before is forgotten."""
        self._reader.forget()
        self._write({"begin": dict(message)})

    def tell(self, command: Mapping[str, float]) -> None:
        """Tell it commands; if it does not read them it will not answer either."""
        self._write({"command": dict(command)})

    def hear(self, seconds: float) -> Heard | None:
        """Return its next message; once it has ended, why."""
        until = time.monotonic() + seconds
        while True:
            left = until - time.monotonic()
            # Looked at first: whatever it said is then on its way.
            gone = self._process is not None and self._process.poll() is not None
            heard = self._reader.hear(LAST if gone else min(max(left, 0.0), LAST))
            if heard is not None and heard.ended:
                return Heard(at=heard.at, ended=f"{heard.ended}{self._why()}")
            if heard is not None:
                return heard
            if gone:
                # What it started holds its output open, and nobody speaks for it any more.
                ended = f"its output was left open by a process that is gone{self._why()}"
                return Heard(at=time.monotonic(), ended=ended)
            if left <= LAST:
                return None

    def stop(self, seconds: float) -> bool:
        """Tell it to stop, and wait until it says that it did."""
        if self._process is None or not self._write({"stop": True}):
            return False
        until = time.monotonic() + seconds
        while (left := until - time.monotonic()) > 0.0:
            heard = self._reader.hear(left)
            if heard is None or heard.ended:
                return False
            if heard.said.get("stopped") is True:
                return True
        return False

    def close(self) -> None:
        """End its input, and end it if it does not end by itself."""
        process, self._process, self._hello = self._process, None, None
        if process is None:
            return
        self._reader.close()
        os.close(self._input)
        for end in (process.terminate, process.kill):
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(LEAVE)
                return
            end()
        process.wait()

    def _why(self) -> str:
        if self._process is None:
            return ""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(0.2)
        code, last = self._process.returncode, self._errors.text()
        ended = "" if code is None else f" and ended with status {code}"
        return ended + (f", saying {last[:200]!r}" if last else "")

    def _write(self, message: Mapping[str, Any]) -> bool:
        return self._process is not None and write(self._input, line_of(message), WRITE)
