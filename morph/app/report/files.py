"""Writing a diagnosis so that a killed run leaves no half of one."""

from __future__ import annotations

import io
import json
import math
import os
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from morph.app.report.page import report_page
from morph.arrays import JSON
from morph.atomic_directory import atomic_directory
from morph.errors import OutputError
from morph.files import write_whole
from morph.model.diagnosis import SCHEMA, Diagnosis
from morph.regular_file import open_regular

FILES = ("report.html", "corrected.xml", "corrected.toml", "residual.npz", "diagnosis.json")
"""All that a diagnosis may consist of; the last makes it one."""


def write_diagnosis(diagnosis: Diagnosis, out: Path) -> None:
    """Write a diagnosis into a folder, which is replaced whole or not at all.

    An earlier diagnosis is there until the new one is; other files in the folder stay.

    Raises:
        OutputError: `out` is a file, or a folder that holds something else, or the one where one
            stands; or it cannot be written to; or the diagnosis holds a number that is not finite.
    """
    check_out(out)
    contents = _contents(diagnosis)
    with atomic_directory(out, check_out, FILES) as folder:
        for name, content in contents.items():
            write_whole(folder / name, content)


def _holds(path: Path, schema: str) -> bool:
    """Return whether a file is of a schema of ours, however damaged its end."""
    try:
        with open_regular(path) as file:
            return schema.encode() in file.read(4096)
    except OSError:
        return False


def check_out(out: Path) -> None:
    """Refuse a place that a diagnosis must not be written to, before the work is done.

    Raises:
        OutputError: As `check_folder` says.
    """
    check_folder(out, FILES[-1], SCHEMA, "a diagnosis")


def check_folder(out: Path, marker: str, schema: str, noun: str) -> None:
    """Refuse a folder that a result must not be written to, before the work is done.

    Args:
        out: The folder, which the result replaces whole.
        marker: The file that makes a folder such a result.
        schema: What that file says it follows.
        noun: What the result is, as `a diagnosis`.

    Raises:
        OutputError: `out` is a file, a link, a folder that holds something else, or a place where
            nothing can be written.
    """
    try:
        taken = out.is_symlink() or (out.exists() and not out.is_dir())
        here = out.is_dir() and out.samefile(Path())
        foreign = out.is_dir() and any(out.iterdir()) and not _holds(out / marker, schema)
        standing = next(parent for parent in (out, *out.absolute().parents) if parent.exists())
        if not (taken or foreign):
            os.rmdir(tempfile.mkdtemp(dir=standing, prefix=".morph-"))
    except OSError as error:
        raise OutputError(
            f"nothing can be written there: {error.strerror or error}",
            where=str(out),
            fix="name a folder that you may write to",
        ) from error
    if foreign:
        raise OutputError(
            f"the folder is not empty and holds no earlier {noun.partition(' ')[2]}",
            where=str(out),
            fix=f"name a new or an empty folder, or one that holds an earlier {marker}",
        )
    if taken:
        raise OutputError(
            f"this is a file or a link, and {noun} is a folder",
            where=str(out),
            fix="name a new or an empty folder",
        )
    if here:
        raise OutputError(
            f"this is the folder where you stand, and {noun} replaces its folder whole",
            where=str(out),
            fix="name a folder in it",
        )


def _contents(diagnosis: Diagnosis) -> dict[str, str | bytes]:
    """Return what is to be written by name, in the order of `FILES`."""
    contents: dict[str, str | bytes] = {"report.html": report_page(diagnosis)}
    if diagnosis.corrected:
        from morph.physics.store import effects_text

        beside = ", ".join(effect.label for effect in diagnosis.corrected_effects)
        # Two hyphens would end the comment.
        lacks = f"<!-- It lacks {beside.replace('--', '- -')}: see corrected.toml. -->\n"
        contents["corrected.xml"] = (lacks if beside else "") + diagnosis.corrected
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
