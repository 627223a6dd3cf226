"""Manifest and rows of a study's folder; a folder without manifest is the user's."""

from __future__ import annotations

import json
import os
import platform
import subprocess
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

import morph
from morph.arrays import JSON
from morph.errors import StudyError
from morph.files import write_whole
from morph.regular_file import open_regular, read_regular
from morph.study.cell import Cell
from morph.study.code_hash import source_folder
from morph.study.encoding import encode_row
from morph.study.store import MAX_BYTES, Result

MANIFEST, ROWS = "study.json", "rows.json"
STUDY_SCHEMA, ROWS_SCHEMA = "morph.study/1", "morph.rows/1"
"""Names and versions of the schemas of the two files."""

SCHEMA_BYTES = 100
"""First bytes of a file, within which its schema stands."""


def save_manifest(folder: Path, cells: Sequence[Cell], *, name: str, engine: JSON) -> Path:
    """Write the manifest (cells, code, commit, machine, date, engine) and return its path.

    Raises:
        OutputError: The folder cannot be written to, or the disk is full.
    """
    manifest = {
        "schema": STUDY_SCHEMA,
        "name": name,
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "commit": _commit(source_folder(cells[0].function.partition(":")[0])),
        "morph_version": morph.__version__,
        "code": {cell.function: cell.code for cell in cells},
        "machine": {
            "host": platform.node(),
            "system": platform.platform(),
            "python": platform.python_version(),
            "cores": os.cpu_count(),
        },
        "engine": engine,
        "cells": [
            {"identity": cell.identity, "function": cell.function, "case": cell.encoded}
            for cell in cells
        ],
    }
    return write_whole(folder / MANIFEST, json.dumps(manifest, indent=1) + "\n")


def save_rows(folder: Path, results: Sequence[Result]) -> Path:
    """Write the rows of all cells in one file and return its path.

    Raises:
        OutputError: The folder cannot be written to, or the disk is full.
    """
    rows = [
        {
            "function": each.cell.function,
            "case": each.cell.encoded,
            "status": each.status,
            "row": encode_row(each.row),
            "error": each.error,
            "seconds": each.seconds,
            "stale": each.stale,
        }
        for each in results
    ]
    content = json.dumps({"schema": ROWS_SCHEMA, "rows": rows}, indent=1)
    return write_whole(folder / ROWS, content + "\n")


def load_manifest(folder: Path) -> JSON:
    """Return the manifest in a folder.

    Raises:
        StudyError: The folder holds no study, or its manifest is damaged.
    """
    try:
        manifest = json.loads(read_regular(folder / MANIFEST, MAX_BYTES))
        if manifest["schema"] != STUDY_SCHEMA:
            raise ValueError(f"schema {manifest['schema']!r}")
        if not all(isinstance(each["identity"], str) for each in manifest["cells"]):
            raise ValueError("a cell without identity")
        return {"name": manifest["name"], "code": dict(manifest["code"]), **manifest}
    except (OSError, ValueError, LookupError, TypeError) as error:
        raise StudyError(
            f"holds no study: {error}",
            where=str(folder),
            fix="name the folder that `morph study` wrote into",
        ) from error


def identities(folder: Path) -> list[str]:
    """Return the identities of the cells of the study in a folder, in their order.

    Raises:
        StudyError: The folder holds no study.
    """
    return [each["identity"] for each in load_manifest(folder)["cells"]]


def check_folder(folder: Path, cells: Sequence[Cell], *, name: str, resume: bool) -> None:
    """Check that a folder is empty, hidden files aside, or holds an earlier run of a study.

    Raises:
        StudyError: It holds other files, or `resume` would mix two studies.
    """
    names = sorted(path.name for path in folder.iterdir() if not path.name.startswith("."))
    schemas = {MANIFEST: STUDY_SCHEMA, ROWS: ROWS_SCHEMA}
    others = [
        each for each in schemas if each in names and not _holds(folder / each, schemas[each])
    ]
    if others or (names and MANIFEST not in names):
        raise StudyError(
            f"the folder holds {(others or names)[0]}, which no study wrote",
            where=str(folder),
            fix="name a new or an empty folder",
        )
    if not resume or not names:
        return
    earlier = load_manifest(folder)
    functions = {cell.function for cell in cells}
    if earlier["name"] != name or functions.isdisjoint(earlier["code"]):
        old, new = (", ".join(sorted(each)) for each in (earlier["code"], functions))
        raise StudyError(
            f"the folder holds the study {earlier['name']} of {old}, not {name} of {new}",
            where=str(folder),
            fix="name another folder",
        )


def _holds(path: Path, schema: str) -> bool:
    """Return whether a file begins with a schema as written here."""
    try:
        with open_regular(path) as file:
            return f'"schema": "{schema}"'.encode() in file.read(SCHEMA_BYTES)
    except (OSError, ValueError):
        return False


def _commit(source: Path) -> str | None:
    """Return the commit of a folder's repository, with `+` where files differ; None without git."""
    command = ["git", "-C", str(source), "describe", "--always", "--abbrev=40", "--dirty=+"]
    try:
        done = subprocess.run(
            [*command, "--exclude=*"], capture_output=True, text=True, check=False
        )
    except OSError:
        return None
    return done.stdout.strip() or None
