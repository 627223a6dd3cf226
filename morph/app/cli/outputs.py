"""The folder of a command that can be resumed: which files in it are the command's own."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from morph.errors import OutputError
from morph.files import write_whole
from morph.regular_file import read_regular
from morph.run_folder import LOCK, OWNED

MAX_OWNED = 2**16
"""Most bytes of the file that names the command and the patterns of its files."""


@dataclass(frozen=True, kw_only=True)
class Outputs:
    """The files that a command writes into its folder, as patterns relative to it."""

    command: str
    """The command, such as `morph learn`."""
    results: tuple[str, ...]
    """What a finished command leaves; the first makes it a finished one."""
    progress: tuple[str, ...] = ()
    """What an interrupted command resumes from."""
    stays: tuple[str, ...] = ()
    """Names that may be there before, and are never removed."""


POLICY = ("policy/policy.json", "policy/weights.safetensors", "policy/policy.onnx")
"""Files of a policy and its export."""

SOURCE = ("source/policy.json", "source/weights.safetensors")
"""Files of the source's policy, where a loop learned it first."""

RECORDED = "recorded"
"""Folder in which a loop keeps what a live target did."""

LEARN = Outputs(
    command="morph learn",
    results=("record.json", "report.html", "strip.jpg", *POLICY),
    progress=("state.npz",),
)
"""Of a search."""

LOOP = Outputs(
    command="morph loop",
    results=("transfer.json", "report.html", "corrected.xml", "corrected.toml", *POLICY),
    progress=(
        *("loop.json", *SOURCE),
        *("trials/[0-9]*/experience.npz", "trials/[0-9]*/origin.json"),
        *("trials/[0-9]*/policy/weights.safetensors", "trials/[0-9]*/policy/policy.json"),
    ),
    stays=(RECORDED,),
)
"""Of a loop."""

ALIGN = Outputs(
    command="morph align",
    results=("align.json", "report.html", "maps/[0-9][0-9]_body_map.npz"),
)
"""Of an alignment."""

TRANSFER = Outputs(
    command="morph transfer",
    results=("transfer.json", "report.html", *POLICY),
    progress=(
        *("relay.json", "maps/[0-9][0-9]_body_map.npz"),
        *("hops/[0-9][0-9]/*.npz", "hops/[0-9][0-9]/*.json"),
    ),
)
"""Of a relay along a chain."""


def check_out(text: str, outputs: Outputs) -> Path:
    """Return the folder to write to, and refuse a place that must not be written to.

    Raises:
        OutputError: It is a file, a folder that holds something else, a file of somebody else
            stands where the command would write, or nothing can be written there.
    """
    if not text.strip():
        # As a path it would be the current folder.
        raise OutputError("no folder is named", where="--out", fix="name a new or an empty folder")
    out = Path(text)
    try:
        if not out.is_dir() and (out.exists() or out.is_symlink()):
            raise OutputError(
                f"this is a file, and what {outputs.command} leaves is a folder",
                where=text,
                fix="name a new or an empty folder",
            )
        if out.is_dir():
            _check_entries(out, outputs)
        parent = next(each for each in (out, *out.absolute().parents) if each.is_dir())
        os.rmdir(tempfile.mkdtemp(dir=parent, prefix=".morph-"))
        if shutil.disk_usage(parent).free == 0:
            raise OutputError("the disk is full", where=text, fix="make room")
    except OSError as error:
        raise _unwritable(out, error) from error
    return out


def claim(out: Path, outputs: Outputs, *, results: bool) -> None:
    """Record that a command writes its files into a folder, before it writes the first of them.

    Args:
        out: The folder.
        outputs: What the command writes.
        results: Whether it writes its results from now on, or progress alone.

    Raises:
        OutputError: The folder cannot be written to.
    """
    new = (*outputs.progress, *(outputs.results if results else ()))
    _save_owned(out, outputs.command, dict.fromkeys((*_owned(out)[1], *new)))


def clear(out: Path, outputs: Outputs, *, progress: bool) -> None:
    """Remove the results of an earlier command and, with `progress`, what it would resume from.

    Folders of which nothing is left are removed as well. What a command did not write stays.

    Raises:
        OutputError: They cannot be removed.
    """
    patterns = (*outputs.results, *(outputs.progress if progress else ()))
    command, owned = _owned(out)
    try:
        for pattern in patterns:
            if pattern not in owned:
                continue
            for path in sorted(out.glob(pattern)):
                path.unlink()
                _remove_empty(path.parent, out)
        left = [each for each in owned if each not in patterns]
        if left:
            _save_owned(out, command, left)
        else:
            (out / OWNED).unlink(missing_ok=True)
    except OSError as error:
        raise _unwritable(out, error) from error


def _check_entries(out: Path, outputs: Outputs) -> None:
    entries = {each.name for each in out.iterdir()} - {LOCK, OWNED, *outputs.stays}
    command, owned = _owned(out)
    if entries and command != outputs.command:
        raise OutputError(
            f"the folder is not empty and holds nothing of {outputs.command}",
            where=str(out),
            fix=f"name a new or an empty folder, or one that `{outputs.command}` wrote",
        )
    for path in _foreign(out, outputs, owned):
        raise OutputError(
            f"{outputs.command} did not write this, and would replace it",
            where=str(path),
            fix="move it elsewhere, or name a new folder",
        )


def _foreign(out: Path, outputs: Outputs, owned: tuple[str, ...]) -> Iterator[Path]:
    """Yield what stands where the command writes, and is not its own."""
    for pattern in (*outputs.results, *outputs.progress):
        first = out / Path(pattern).parts[0]
        if "/" in pattern and os.path.lexists(first) and (first.is_symlink() or first.is_file()):
            yield first
        elif pattern not in owned:
            yield from out.glob(pattern)


def _owned(out: Path) -> tuple[str, tuple[str, ...]]:
    """Return the command that wrote into a folder and the patterns of its files; else nothing."""
    with suppress(OSError, ValueError):
        command, *patterns = read_regular(out / OWNED, MAX_OWNED).decode().splitlines()
        return command, tuple(patterns)
    return "", ()


def _save_owned(out: Path, command: str, patterns: Iterable[str]) -> None:
    write_whole(out / OWNED, "".join(f"{line}\n" for line in (command, *patterns)))


def _remove_empty(folder: Path, out: Path) -> None:
    """Remove folders in which nothing is left, up to the command's own."""
    while folder != out and folder.is_relative_to(out) and not any(folder.iterdir()):
        folder.rmdir()
        folder = folder.parent


def _unwritable(out: Path, error: OSError) -> OutputError:
    return OutputError(
        f"nothing can be written there: {error.strerror or error}",
        where=str(out),
        fix="name a folder that you may write to",
    )
