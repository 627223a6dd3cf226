"""Checks that the data of a study are complete, before anything is measured."""

from __future__ import annotations

from pathlib import Path

from experiments.plant.originals import packaged_root
from experiments.public.manifest import VARIABLES, DataSet, data_root, load_sets
from morph.errors import MorphError


class DataMissing(MorphError):
    """Data of a study are not on this machine, or only a part of them."""


def need_recordings(*sets: str) -> Path:
    """Return the folder of the recordings, in which the named sets are complete.

    Raises:
        DataMissing: A file of theirs is missing; a study of the rest would be another study.
    """
    return _need("recordings", sets)


def need_robots(*sets: str) -> Path:
    """Return the folder of the published descriptions, in which the named sets are complete.

    Without names, all sets must be.

    Raises:
        DataMissing: A file of theirs is missing; a study of the rest would be another study.
    """
    return _need("robots", sets)


def need_packaged(*paths: str) -> Path:
    """Return the folder of the package `example-robot-data`, which holds every named path.

    Raises:
        DataMissing: The package or a path is missing.
    """
    root = packaged_root()
    missing = [path for path in (*paths, "") if not (root / path).exists()]
    if missing:
        raise DataMissing(
            "the packaged descriptions are not there, or only a part of them",
            where=str(root / missing[0]),
            fix="install them: .venv/bin/python -m pip install example-robot-data",
        )
    return root


def _need(kind: str, names: tuple[str, ...]) -> Path:
    root = data_root(kind).resolve()
    wanted = [
        each for each in load_sets() if each.kind == kind and (not names or each.name in names)
    ]
    missing = {each.name: _missing(root, each) for each in wanted}
    incomplete = [each for each in wanted if missing[each.name]]
    if incomplete:
        first, *others = incomplete
        files = missing[first.name]
        more = f"; also incomplete: {', '.join(each.name for each in others)}" if others else ""
        commands = [
            f".venv/bin/python -m experiments.data --set {each.name}" for each in incomplete
        ]
        raise DataMissing(
            f"{len(files)} of {len(first.files)} files of {first.name} are not there{more}",
            where=str(root / first.name / files[0]),
            fix=f"run {' && '.join(commands)}, "
            f"and let {VARIABLES[kind]} name experiments/data/{kind}",
        )
    return root


def _missing(root: Path, data_set: DataSet) -> list[str]:
    folder = root / data_set.name
    return [each.file for each in data_set.files if not (folder / each.file).is_file()]
