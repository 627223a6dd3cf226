"""The folder of a loop: what is ours in it, whether it may be used, and how it is emptied."""

from __future__ import annotations

import os
import shutil
import tempfile
from pathlib import Path

from morph.errors import OutputError
from morph.transfer.keep import STATE, TRIALS

RESULTS = (
    *("transfer.json", "report.html", "corrected.xml", "corrected.toml"),
    *("policy/policy.json", "policy/weights.safetensors", "policy/policy.onnx"),
)
"""All that a finished loop leaves beside its trials; the first makes it one."""

SOURCE = ("source/policy.json", "source/weights.safetensors")
"""The source's policy, where it was learned first."""

TRIAL = ("experience.npz", "origin.json", "policy/weights.safetensors", "policy/policy.json")
"""What is kept of a trial."""

OURS = (STATE, RESULTS[0])
"""Files by one of which a folder is known as ours."""

LOCK = "loop.lock"
"""File that is there and held while a loop works in the folder."""

RECORDED = "recorded"
"""Folder of what a live target showed; it is never removed."""


def check_out(text: str) -> Path:
    """Return the folder to write to, and refuse a place that must not be written to.

    Raises:
        OutputError: It is a file, a folder that holds something else, or a place where nothing
            can be written.
    """
    if not text.strip():
        # As a path it would be the folder where one stands.
        raise OutputError("no folder is named", where="--out", fix="name a new or an empty folder")
    out = Path(text)
    try:
        if not out.is_dir() and (out.exists() or out.is_symlink()):
            raise OutputError(
                "this is a file, and what a loop leaves is a folder",
                where=text,
                fix="name a new or an empty folder",
            )
        foreign = out.is_dir() and {each.name for each in out.iterdir()} - {RECORDED, LOCK}
        if foreign and not any((out / name).is_file() for name in OURS):
            raise OutputError(
                "the folder is not empty and holds no earlier loop",
                where=text,
                fix="name a new or an empty folder, or one that `morph loop` wrote",
            )
        standing = next(parent for parent in (out, *out.absolute().parents) if parent.is_dir())
        os.rmdir(tempfile.mkdtemp(dir=standing, prefix=".morph-"))
    except OSError as error:
        raise cannot(out, error) from error
    return out


def finished(out: Path) -> int:
    """Return how many trials a folder keeps."""
    trials = out / TRIALS
    return len(list(trials.glob(f"*/{TRIAL[0]}"))) if trials.is_dir() else 0


def clear(out: Path, *, trials: bool) -> None:
    """Remove what an earlier loop left: its results, and with `trials` all but recordings.

    Raises:
        OutputError: It cannot be removed.
    """
    try:
        _remove(out, RESULTS)
        if trials:
            _remove(out, (*SOURCE, STATE))
            for folder in sorted((out / TRIALS).glob("[0-9]*")):
                _remove(folder, TRIAL)
                _drop(folder)
            _drop(out / TRIALS)
            _drop(out)
    except OSError as error:
        raise cannot(out, error) from error


def _remove(folder: Path, names: tuple[str, ...]) -> None:
    for name in names:
        (folder / name).unlink(missing_ok=True)
    for parent in {(folder / name).parent for name in names} - {folder}:
        _drop(parent)


def _drop(folder: Path) -> None:
    """Remove a folder of ours if nothing is left in it."""
    if folder.is_dir() and not folder.is_symlink() and not any(folder.iterdir()):
        shutil.rmtree(folder)


def cannot(out: Path, error: OSError) -> OutputError:
    """Return the refusal of a folder that cannot be written to."""
    return OutputError(
        f"nothing can be written there: {error.strerror or error}",
        where=str(out),
        fix="name a folder that you may write to",
    )
