"""What a search has so far, on disk, so that a killed one goes on from there."""

from __future__ import annotations

import io
import json
import os
import shutil
import tempfile
import time
import zipfile
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from morph.errors import OutputError
from morph.files import write_whole
from morph.search.search import State, Trial

STATE, RECORD = "state.npz", "record.json"
"""The state of a search, and what makes it a finished one."""

OURS = (STATE, RECORD)
"""Files by one of which a folder is known as ours."""

RESULTS = (
    *(RECORD, "report.html", "strip.jpg"),
    *("policy/policy.json", "policy/weights.safetensors", "policy/policy.onnx"),
)
"""All that a finished search leaves beside its state; the first made it one."""

OFTEN = 1.0
"""Least seconds between two writings: a generation may take a millisecond, and a disk ten."""

STATES = "state."
"""How the arrays of the search itself begin in the file."""


@dataclass(frozen=True, kw_only=True)
class Before:
    """What an interrupted search left."""

    trials: tuple[Trial, ...] = ()
    """Its learning record."""
    state: State | None = None
    """What the search goes on from; None to begin anew."""


class Kept:
    """The state of one search in one folder.

    Args:
        out: The folder.
        key: What must be the same for a search to go on: the task, the body, the search, the seed.
    """

    def __init__(self, out: Path, key: Mapping[str, str]) -> None:
        self.out, self.key = out, dict(key)
        self.trials: list[Trial] = []
        self._state: dict[str, Any] = {}
        self._written, self._told, self._begun = -np.inf, 0, False

    def before(self) -> Before:
        """Return what an interrupted search of the same key left in the folder.

        Raises:
            OutputError: The folder holds another search, or a file that is spoilt.
        """
        path = self.out / STATE
        if not path.is_file():
            return Before()
        key, trials, state = _read(path)
        other = [name for name in self.key if key.get(name) != self.key[name]]
        if other:
            raise OutputError(
                f"the folder holds a search with another {' and another '.join(other)}",
                where=str(self.out),
                fix="name a new folder, or begin anew in this one by --fresh",
            )
        self.trials = list(trials)
        self._state = dict(state)
        return Before(trials=trials, state=state)

    def add(self, trial: Trial, state: State) -> None:
        """Keep a trial and what the search goes on from; the file is a second old at most."""
        self.trials = [each for each in self.trials if each.number < trial.number] + [trial]
        self._state = {name: np.array(value) for name, value in state.items()}
        self._told += 1
        if time.monotonic() - self._written >= OFTEN:
            self.write()

    def write(self) -> None:
        """Write what there is; a search that has told nothing leaves nothing.

        Raises:
            OutputError: The folder cannot be written to.
        """
        if not self._told:
            return
        if not self._begun:
            # Results that stand beside a newer state would be taken for its own.
            clear(self.out, RESULTS)
            self._begun = True
        write_whole(self.out / STATE, _bytes(self.key, self.trials, self._state))
        self._written = time.monotonic()


def clear(out: Path, names: tuple[str, ...]) -> None:
    """Remove what an earlier search left, and the folder of its policy if nothing else is in it.

    Raises:
        OutputError: It cannot be removed.
    """
    try:
        for name in names:
            (out / name).unlink(missing_ok=True)
        policy = out / "policy"
        if policy.is_dir() and not any(policy.iterdir()):
            policy.rmdir()
    except OSError as error:
        raise OutputError(
            f"what an earlier search left cannot be removed: {error.strerror or error}",
            where=str(out),
            fix="name a folder that you may write to",
        ) from error


def check_out(out: Path) -> None:
    """Refuse a place that a search must not be written to, before the work is done.

    Raises:
        OutputError: It is a file, a folder that holds something else, or a place where
            nothing can be written.
    """
    try:
        if not out.is_dir() and (out.exists() or out.is_symlink()):
            raise OutputError(
                "this is a file, and what is learned is a folder",
                where=str(out),
                fix="name a new or an empty folder",
            )
        foreign = out.is_dir() and any(out.iterdir())
        if foreign and not any((out / name).is_file() for name in OURS):
            raise OutputError(
                "the folder is not empty and holds no earlier search",
                where=str(out),
                fix="name a new or an empty folder, or one that `morph learn` wrote",
            )
        standing = next(parent for parent in (out, *out.absolute().parents) if parent.is_dir())
        os.rmdir(tempfile.mkdtemp(dir=standing, prefix=".morph-"))
        if shutil.disk_usage(standing).free == 0:
            raise OutputError("the disk is full", where=str(out), fix="make room")
    except OSError as error:
        raise OutputError(
            f"nothing can be written there: {error.strerror or error}",
            where=str(out),
            fix="name a folder that you may write to",
        ) from error


def _bytes(key: Mapping[str, str], trials: list[Trial], state: Mapping[str, Any]) -> bytes:
    held: dict[str, Any] = {STATES + name: value for name, value in state.items()}
    for name, array in held.items():
        if array.dtype.hasobject:
            raise OutputError(
                f"the search's {name.removeprefix(STATES)} is no array of numbers or texts",
                where=STATE,
                fix="keep the state of a search as plain arrays",
            )
    told = [asdict(trial) for trial in trials]
    buffer = io.BytesIO()
    np.savez(buffer, key=json.dumps(dict(key)), trials=json.dumps(told), **held)
    return buffer.getvalue()


def _read(path: Path) -> tuple[dict[str, str], tuple[Trial, ...], dict[str, Any]]:
    try:
        # Opened here: of a spoilt file the reader would leave it open.
        with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
            key = json.loads(str(file["key"]))
            trials = tuple(Trial(**said) for said in json.loads(str(file["trials"])))
            names = [name for name in file.files if name.startswith(STATES)]
            state = {name.removeprefix(STATES): file[name] for name in names}
    except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile) as error:
        raise OutputError(
            f"it is no state of a search: {error}",
            where=str(path),
            fix="begin anew by --fresh, or name a new folder",
        ) from error
    return dict(key), trials, state
