"""The folders of `morph align` and `morph transfer`: what is ours in them, and their emptying."""

from __future__ import annotations

import os
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path

from morph.app.cli.loop_folder import cannot
from morph.app.cli.loop_key import alone as alone
from morph.errors import OutputError

LOCK = "loop.lock"
"""File that is there and held while a command works in a folder."""


@dataclass(frozen=True, kw_only=True)
class Kind:
    """What a command leaves in its folder."""

    command: str
    """The command."""
    marks: tuple[str, ...]
    """Files by one of which a folder is known as ours."""
    results: tuple[str, ...]
    """Patterns of what a finished command leaves."""
    kept: tuple[str, ...] = ()
    """Patterns of what it goes on from."""


ALIGN = Kind(
    command="morph align",
    marks=("align.json",),
    results=("align.json", "report.html", "maps/[0-9][0-9]_body_map.npz"),
)
"""Of an alignment."""

TRANSFER = Kind(
    command="morph transfer",
    marks=("transfer.json", "relay.json"),
    results=(
        *("transfer.json", "report.html", "maps/[0-9][0-9]_body_map.npz"),
        *("policy/policy.json", "policy/weights.safetensors", "policy/policy.onnx"),
    ),
    kept=(*("relay.json", "hops/[0-9][0-9]/*.npz", "hops/[0-9][0-9]/*.json"),),
)
"""Of a relay along a chain."""


def check_out(text: str, kind: Kind) -> Path:
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
                f"this is a file, and what {kind.command} leaves is a folder",
                where=text,
                fix="name a new or an empty folder",
            )
        foreign = out.is_dir() and {each.name for each in out.iterdir()} - {LOCK}
        if foreign and not any((out / name).is_file() for name in kind.marks):
            raise OutputError(
                f"the folder is not empty and holds nothing of {kind.command}",
                where=text,
                fix=f"name a new or an empty folder, or one that `{kind.command}` wrote",
            )
        standing = next(parent for parent in (out, *out.absolute().parents) if parent.is_dir())
        os.rmdir(tempfile.mkdtemp(dir=standing, prefix=".morph-"))
    except OSError as error:
        raise cannot(out, error) from error
    return out


def clear(out: Path, kind: Kind, *, kept: bool) -> None:
    """Remove what an earlier command left: its results, and with `kept` what it would go on from.

    Raises:
        OutputError: It cannot be removed.
    """
    try:
        for pattern in (*kind.results, *(kind.kept if kept else ())):
            for path in sorted(out.glob(pattern)):
                if path.is_file() or path.is_symlink():
                    path.unlink()
                _drop(path.parent, out)
    except OSError as error:
        raise cannot(out, error) from error


def _drop(folder: Path, out: Path) -> None:
    """Remove folders of ours in which nothing is left, up to the command's own."""
    while folder != out and folder.is_relative_to(out):
        if folder.is_symlink() or not folder.is_dir() or any(folder.iterdir()):
            return
        shutil.rmtree(folder)
        folder = folder.parent
