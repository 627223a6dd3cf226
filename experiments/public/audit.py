"""Holding a folder of data against the manifests, and writing manifests from one."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from experiments.public.content import DataError, measure, verify
from experiments.public.manifest import MANIFESTS, MAX_STORED, DataSet
from morph.files import write_whole
from morph.regular_file import read_regular


@dataclass(frozen=True, kw_only=True)
class Audit:
    """What is amiss in a folder of data; paths begin with the set's name."""

    right: int
    """Files that are those that were used."""
    missing: tuple[str, ...]
    """Files that manifests list and that are not there."""
    different: tuple[str, ...]
    """Files that are there and hold something else, each with what."""
    unlisted: tuple[str, ...]
    """Files that no manifest lists."""

    @property
    def whole(self) -> bool:
        """Whether every file is there as it was used, and nothing else."""
        return not (self.missing or self.different or self.unlisted)


def audit(root: Path, sets: Sequence[DataSet]) -> Audit:
    """Return what a folder holds of some sets.

    Args:
        root: Holds `recordings/<set>` and `robots/<set>`, or `<set>` at once.
        sets: The sets to look for.
    """
    right, missing, different, unlisted = 0, [], [], []
    for whole in sets:
        folder = _folder(whole, root)
        for public in whole.files:
            name = f"{whole.name}/{public.file}"
            path = folder / public.file
            try:
                verify(public, read_regular(path, MAX_STORED, follow=False), name)
                right += 1
            except FileNotFoundError:
                missing.append(name)
            except OSError as error:
                linked = path.is_symlink()
                different.append(f"{name}: {'it is a link' if linked else error.strerror or error}")
            except DataError as error:
                different.append(f"{name}: {error.what}")
        listed = {public.file for public in whole.files} | set(whole.notes)
        unlisted += [f"{whole.name}/{name}" for name in files_below(folder) if name not in listed]
    return Audit(
        right=right,
        missing=tuple(missing),
        different=tuple(different),
        unlisted=tuple(unlisted),
    )


def _folder(whole: DataSet, root: Path) -> Path:
    """Return where a set is under a root of both kinds, or of its own kind."""
    direct = root / whole.name
    return direct if direct.is_dir() else whole.folder(root)


def files_below(folder: Path) -> list[str]:
    """Return the paths of all but folders below a folder, sorted; links are not followed."""
    found = []
    for place, folders, files in os.walk(folder):
        links = [name for name in folders if os.path.islink(os.path.join(place, name))]
        found += [os.path.relpath(os.path.join(place, name), folder) for name in files + links]
    return sorted(found)


def write_manifest(root: Path, whole: DataSet, manifests: Path = MANIFESTS) -> Path:
    """Write the manifest of a set from a folder that holds it, and return its path.

    Raises:
        DataError: The folder does not hold the set, or has a file without an origin.
    """
    folder = _folder(whole, root)
    rows = []
    for name in files_below(folder):
        if name in whole.notes:
            continue
        public = whole.source_of(name)
        try:
            content = read_regular(folder / name, MAX_STORED, follow=False)
        except OSError as error:
            raise DataError(
                f"cannot be read: {error.strerror or error}",
                where=str(folder / name),
                fix="leave only regular files in the folder",
            ) from error
        size, digest = measure(content, public.form, str(folder / name))
        rows.append(f'"{name}" = [{size}, "{digest}"]\n')
    if not rows:
        raise DataError(
            f"holds no file of {whole.name}", where=str(root), fix="name the folder that has it"
        )
    head = (
        f"# Size and sha256 of each file of {whole.name}, written by\n"
        "# `python -m experiments.data --write-manifest DIR`; origins stand in data.toml.\n"
    )
    return write_whole(manifests / f"{whole.name}.toml", f"{head}[file]\n{''.join(rows)}")
