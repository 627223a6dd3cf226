"""Checkpoint of a search, for resuming."""

from __future__ import annotations

import io
import json
import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from morph.app.cli.outputs import LEARN, claim, clear
from morph.arrays import JSON
from morph.errors import OutputError
from morph.files import write_whole
from morph.npz import load_npz
from morph.regular_file import read_regular
from morph.search.search import State, Trial

STATE, RECORD = "state.npz", "record.json"
"""Files of a search's state, and of its record, which a finished search has."""

WRITE_INTERVAL = 1.0
"""Least seconds between two writes: a generation may take 1 ms, and a write 10 ms."""

MAX_STATE = 2**30
"""Largest state in memory, bytes; all transitions of a long search have some hundred MB."""

MAX_RECORD = 2**24
"""Largest record, bytes; one of a thousand trials has 0.2 MB."""

PREFIX = "state."
"""Prefix of the search's own arrays in the file."""


@dataclass(frozen=True, kw_only=True)
class Before:
    """Trials and state that an interrupted search saved."""

    trials: tuple[Trial, ...] = ()
    """Trials in order: the learning curve so far."""
    state: State | None = None
    """State to resume from; None to start anew."""


class Checkpoint:
    """Checkpoint of one search in one folder.

    Args:
        out: The folder.
        key: Names and values that must be equal to resume: task, body, search, seed.
    """

    def __init__(self, out: Path, key: Mapping[str, str]) -> None:
        self.out, self.key = out, dict(key)
        self.trials: list[Trial] = []
        self._state: dict[str, Any] = {}
        self._written, self._added, self._cleared = -np.inf, False, False

    def before(self) -> Before:
        """Return the saved trials and state of a search with the same key; empty if there are none.

        Raises:
            OutputError: The folder holds a search with another key, or a damaged state.
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
        """Add a trial and replace the state; written unless `WRITE_INTERVAL` has not passed.

        Trials of the same or a later number are dropped: a resumed search repeats them.

        Raises:
            OutputError: The folder cannot be written to.
        """
        self.trials = [each for each in self.trials if each.number < trial.number] + [trial]
        self._state = {name: np.array(value) for name, value in state.items()}
        self._added = True
        if time.monotonic() - self._written >= WRITE_INTERVAL:
            self.write()

    def write(self) -> None:
        """Write the checkpoint; without an added trial nothing is written.

        Raises:
            OutputError: The folder cannot be written to.
        """
        if not self._added:
            return
        if not self._cleared:
            # Results of an earlier search would be taken for those of the newer state.
            clear(self.out, LEARN, progress=False)
            claim(self.out, LEARN, results=False)
            self._cleared = True
        write_whole(self.out / STATE, _bytes(self.key, self.trials, self._state))
        self._written = time.monotonic()


def record_of(out: Path) -> tuple[str, JSON] | None:
    """Return the record of a finished search, as text and parsed; None if there is none.

    Raises:
        OutputError: It is damaged, or the search's state is missing.
    """
    path = out / RECORD
    if not path.is_file():
        return None
    try:
        text, record = _read_record(path)
    except (OSError, ValueError, RecursionError) as error:
        raise OutputError(
            f"it is no record of a search: {getattr(error, 'strerror', None) or error}",
            where=str(path),
            fix="begin anew by --fresh, or name a new folder",
        ) from error
    if not (out / STATE).is_file():
        raise OutputError(
            "the folder holds a finished search without its state",
            where=str(out),
            fix="begin anew by --fresh, or name a new folder",
        )
    return text, record


def _read_record(path: Path) -> tuple[str, JSON]:
    """Return a record as text and parsed; ValueError where it is none."""
    text = read_regular(path, MAX_RECORD).decode()
    record = json.loads(text)
    if not isinstance(record, dict) or not {"asked_trials", "succeeded"} <= record.keys():
        raise ValueError("it does not say whether the search succeeded")
    return text, record


def _bytes(key: Mapping[str, str], trials: list[Trial], state: Mapping[str, Any]) -> bytes:
    arrays: dict[str, Any] = {PREFIX + name: value for name, value in state.items()}
    for name, array in arrays.items():
        if array.dtype.hasobject:
            raise OutputError(
                f"the search's {name.removeprefix(PREFIX)} is no array of numbers or texts",
                where=STATE,
                fix="keep the state of a search as plain arrays",
            )
    curve = json.dumps([asdict(trial) for trial in trials])
    buffer = io.BytesIO()
    np.savez(buffer, key=json.dumps(dict(key)), trials=curve, **arrays)
    return buffer.getvalue()


def _read(path: Path) -> tuple[dict[str, str], tuple[Trial, ...], dict[str, Any]]:
    try:
        arrays = load_npz(path, MAX_STATE)
        key = json.loads(str(arrays["key"]))
        trials = tuple(Trial(**fields) for fields in json.loads(str(arrays["trials"])))
        names = [name for name in arrays if name.startswith(PREFIX)]
        state = {name.removeprefix(PREFIX): arrays[name] for name in names}
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise OutputError(
            f"it is no state of a search: {getattr(error, 'strerror', None) or error}",
            where=str(path),
            fix="begin anew by --fresh, or name a new folder",
        ) from error
    return dict(key), trials, state
