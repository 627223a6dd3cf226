"""Writing a diagnosis so that a killed run leaves no half of one."""

from __future__ import annotations

import io
import json
import math
import os
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from morph.app.report.page import report_page
from morph.arrays import JSON
from morph.errors import OutputError
from morph.files import write_whole
from morph.model.diagnosis import Diagnosis

FILES = ("report.html", "corrected.xml", "corrected.toml", "residual.npz", "diagnosis.json")
"""All that a diagnosis may consist of; the last makes it one."""


def write_diagnosis(diagnosis: Diagnosis, out: Path) -> None:
    """Write a diagnosis into a folder, whole or not at all.

    The files are made in a temporary folder beside `out` and then moved into
    place. Those of an earlier diagnosis are replaced one by one, `diagnosis.json`
    last; other files in the folder stay.

    Raises:
        OutputError: `out` is a file, or a folder that holds something else; or it
            cannot be written to; or the diagnosis holds a number that is not finite.
    """
    check_out(out)
    contents = _contents(diagnosis)
    with _as_ours(out), _temporary(out.resolve()) as folder:
        for name, content in contents.items():
            write_whole(folder / name, content)
        if out.exists():
            _replace(folder, out, set(contents))
        else:
            os.rename(folder, out)


def check_out(out: Path) -> None:
    """Refuse a place that a diagnosis must not be written to, before the work is done.

    Raises:
        OutputError: `out` is a file, a folder that holds something else, or a place where
            nothing can be written.
    """
    with _as_ours(out):
        foreign = out.is_dir() and any(out.iterdir()) and not (out / FILES[-1]).is_file()
        taken = not out.is_dir() and (out.exists() or out.is_symlink())
    if foreign:
        raise OutputError(
            "the folder is not empty and holds no earlier diagnosis",
            where=str(out),
            fix="name a new or an empty folder, or one that holds a diagnosis.json",
        )
    if taken:
        raise OutputError(
            "this is a file, and a diagnosis is a folder",
            where=str(out),
            fix="name a new or an empty folder",
        )
    standing = next(parent for parent in (out, *out.absolute().parents) if parent.exists())
    try:
        os.rmdir(tempfile.mkdtemp(dir=standing, prefix=".morph-"))
    except OSError as error:
        raise OutputError(
            f"nothing can be written into {standing}: {error.strerror or error}",
            where=str(out),
            fix="name a folder that you may write to",
        ) from error


def _contents(diagnosis: Diagnosis) -> dict[str, str | bytes]:
    """Return what is to be written by name, in the order of `FILES`."""
    contents: dict[str, str | bytes] = {"report.html": report_page(diagnosis)}
    if diagnosis.corrected:
        from morph.physics.store import effects_text

        contents["corrected.xml"] = diagnosis.corrected
        contents["corrected.toml"] = effects_text(diagnosis.corrected_effects)
    if diagnosis.residual:
        contents["residual.npz"] = _arrays(diagnosis.residual)
    contents["diagnosis.json"] = diagnosis_text(diagnosis)
    return contents


def diagnosis_text(diagnosis: Diagnosis) -> str:
    """Return the text of `diagnosis.json`; the error of a simulation that blew up is null.

    Raises:
        OutputError: Another number is not finite.
    """
    content = diagnosis.as_json()
    content["fit"]["held_out_rmse"] = _finite(content["fit"]["held_out_rmse"])
    try:
        return json.dumps(content, allow_nan=False, ensure_ascii=False, indent=2) + "\n"
    except (TypeError, ValueError) as error:
        raise OutputError(
            f"the diagnosis holds what JSON cannot: {error}",
            where="diagnosis.json",
            fix="report this with the command that led to it: a number came out infinite",
        ) from error


def _finite(errors: Mapping[str, Mapping[str, float]]) -> JSON:
    return {
        model: {c: v if math.isfinite(v) else None for c, v in by_channel.items()}
        for model, by_channel in errors.items()
    }


def _arrays(arrays: Mapping[str, Any]) -> bytes:
    """Return arrays as an .npz that can be read without running anything in it."""
    held: dict[str, Any] = {name: np.asarray(value) for name, value in arrays.items()}
    for name, array in held.items():
        if array.dtype.hasobject:
            raise OutputError(
                f"the learned residual's {name} is no array of numbers or texts",
                where="residual.npz",
                fix="keep the residual as plain arrays",
            )
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **held)
    return buffer.getvalue()


@contextmanager
def _as_ours(out: Path) -> Iterator[None]:
    """Turn what the system refuses into an error that says what to do."""
    try:
        yield
    except OSError as error:
        raise OutputError(
            f"cannot write: {error.strerror or error}",
            where=str(out),
            fix="choose a folder that can be written to and has room",
        ) from error


@contextmanager
def _temporary(out: Path) -> Iterator[Path]:
    """Lend a folder beside `out` that is gone afterwards, however it ends."""
    out.parent.mkdir(parents=True, exist_ok=True)
    folder = Path(tempfile.mkdtemp(dir=out.parent, prefix=f".{out.name}."))
    try:
        folder.chmod(0o755)
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _replace(folder: Path, out: Path, made: set[str]) -> None:
    """Put new files in the place of old ones, and take away old ones without a heir."""
    for name in FILES:
        if name in made:
            os.replace(folder / name, out / name)
        else:
            (out / name).unlink(missing_ok=True)
