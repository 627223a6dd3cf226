"""What an HDF5 file holds: a data set is a column, and a group is an episode.

Nothing outside the file is opened: links to other files, raw data kept in other files and virtual
data sets are refused. Every declared size is checked before memory is taken. Damaged bytes may end
HDF5 and the process with it, so that `morph.record.read.hdf5_child` runs this in one of its own.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Generator, Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from morph.arrays import Array
from morph.errors import RecordingError
from morph.nearest import nearest
from morph.record.limits import (
    MOST_CHUNK,
    MOST_COLUMNS,
    MOST_ENTRIES,
    most_unpacked,
    too_much,
)
from morph.record.read.inflate import check_chunks, chunk_bytes
from morph.record.read.table import listed

DEEPEST = 32
"""How deep groups may lie within each other."""
OUTSIDE = "it lies outside the file"
"""What the reason of a data set that is not in the file begins with."""


@dataclass(frozen=True, kw_only=True)
class EpisodeColumns:
    """The columns of one episode, before their numbers are read."""

    key: str | None
    """The group or data set; None for the whole file."""
    named: bool
    """Whether columns have names; those of a single data set have numbers only."""
    columns: dict[str, Any]
    """The data sets by their paths."""
    note: str = ""
    """What was not read, and why; empty if all was."""


def blocks_in(
    file: Any, path: Path, key: str | None, wanted: Collection[str] | None, every: bool
) -> Iterator[EpisodeColumns]:
    """Give the episodes of a file that is open: one, or with `every` those of all groups.

    Raises:
        RecordingError: There is no such group or column, or it cannot be used.
    """
    for one in _episodes(file, path) if every else (key,):
        yield _block(file, one, wanted, path)


class Bounds:
    """Counts what the data sets of a file take, over all episodes: these may share their bytes."""

    def __init__(self, path: Path) -> None:
        """Start the count of one file."""
        self._path = path
        self._most = most_unpacked(path.stat().st_size)
        self._numbers = self._chunks = 0

    def check(self, name: str, dataset: Any) -> None:
        """Count a data set.

        Raises:
            RecordingError: Its size, or how it is packed, is not to be trusted.
        """
        self._numbers += math.prod(dataset.shape) * max(dataset.dtype.itemsize, 8)
        if self._numbers > self._most:
            shape = " x ".join(map(str, dataset.shape))
            why = f"with its {shape} numbers the columns take more than {self._most} bytes"
            raise too_much(f"{name} cannot be read: {why}", f"{self._path}, {name}")
        # A chunk is unpacked whole, however few of its numbers are the data set's.
        self._chunks += chunk_bytes(dataset)
        most = max(self._most, MOST_CHUNK)
        if self._chunks > most:
            raise too_much(
                f"{name} cannot be read: with its chunks more than {most} bytes are unpacked",
                f"{self._path}, {name}",
            )
        why = check_chunks(dataset)
        if why:
            raise _refused(name, why, self._path)


def numbers_of(block: EpisodeColumns, bounds: Bounds) -> Iterator[Array]:
    """Give the numbers of an episode's columns, one data set after another.

    Raises:
        RecordingError: Their sizes, or how they are packed, are not to be trusted.
    """
    for name, one in block.columns.items():
        bounds.check(name, one)
    for one in block.columns.values():
        with np.errstate(over="ignore"):
            yield np.asarray(one[()]).astype(np.float64)


def _block(
    file: Any, key: str | None, wanted: Collection[str] | None, path: Path
) -> EpisodeColumns:
    node = file if key is None else _keyed(file, key, path)
    if not _is_group(node):
        return EpisodeColumns(key=key, named=False, columns={str(key): node})
    result, other = _sorted_out(node, path)
    if wanted is None:
        return EpisodeColumns(key=key, named=True, columns=result, note=_note(result, other, path))
    for name in sorted(set(wanted) - set(result)):
        raise _missing(name, result, other, path)
    columns = {name: one for name, one in result.items() if name in wanted}
    return EpisodeColumns(key=key, named=True, columns=columns)


def _episodes(file: Any, path: Path) -> tuple[str | None, ...]:
    """Return the groups at the top, or None alone where there are numbers or no group."""
    _left(MOST_COLUMNS, file, path)
    nodes = {name: _entry(file, name) for name in file}
    groups = tuple(name for name, node in nodes.items() if _is_group(node))
    room = MOST_ENTRIES
    for name in groups:
        room = _left(room, nodes[name], path)
    numbers = any(not _is_group(node) and not _unfit(node) for node in nodes.values())
    return (None,) if numbers or not groups else groups


def _is_group(node: Any) -> bool:
    return isinstance(node, h5py.Group)


def _entry(group: Any, name: str) -> Any:
    """Return what stands in a group under a name, or why it is not followed."""
    link = group.get(name, getlink=True)
    if isinstance(link, h5py.ExternalLink):
        return f"{OUTSIDE}: it is a link to {link.filename!r}"
    if not isinstance(link, h5py.HardLink):
        return "it is a link; name what it points to"
    return group[name]


def _keyed(file: Any, key: str, path: Path) -> Any:
    """Return the group or data set of a key, going from group to group inside the file."""
    node = file
    for name in filter(None, key.split("/")):
        if not _is_group(node) or name not in node:
            known = list(islice(node, MOST_COLUMNS)) if _is_group(node) else []
            raise RecordingError(
                f"there is no group {key!r}; {node.name!r} holds {listed(known) or 'none'}",
                where=str(path),
                fix=f"name a group that is there; the nearest are {nearest(name, known)}",
            )
        node = _entry(node, name)
        why = node if isinstance(node, str) else "" if _is_group(node) else _unfit(node)
        if why:
            raise _refused(key, why, path)
    return node


def _sorted_out(group: Any, path: Path) -> tuple[dict[str, Any], dict[str, str]]:
    """Return the data sets of plain numbers in a group, and why all else is no column."""
    results: dict[str, Any] = {}
    other: dict[str, str] = {}
    # All are counted before one is looked at.
    for name, node in list(_inside(group, "", frozenset(), MOST_COLUMNS, path)):
        why = _unfit(node)
        if why:
            other[name] = why
        else:
            results[name] = node
    return results, other


def _inside(
    group: Any, prefix: str, above: frozenset[int], room: int, path: Path
) -> Generator[tuple[str, Any], None, int]:
    """Give what lies in a group and in those below it, by its path; return the room left."""
    room = _left(room, group, path)
    # A group may be linked from below itself; its address tells that it is the same.
    above |= {h5py.h5o.get_info(group.id).addr}
    for name in group:
        node, at = _entry(group, name), prefix + name
        if not _is_group(node):
            yield at, node
        elif h5py.h5o.get_info(node.id).addr in above or len(above) >= DEEPEST:
            yield at, "it is a group within itself, or too deep"
        else:
            room = yield from _inside(node, f"{at}/", above, room, path)
    return room


def _left(room: int, group: Any, path: Path) -> int:
    """Return how many entries may still be read after those of a group.

    Raises:
        RecordingError: The group has more than that.
    """
    # Their number is known before one is opened, which takes some hundred times longer.
    if len(group) > room:
        raise RecordingError(
            f"with the {len(group)} entries of {group.name} there are more groups and data sets "
            "than are read at once",
            where=str(path),
            fix="name the group of one episode as its key in a recording.toml, or cut the file",
        )
    return room - len(group)


def _unfit(node: Any) -> str:
    """Return why something in a file is no column, or nothing if it is one."""
    if isinstance(node, str):
        return node
    if not isinstance(node, h5py.Dataset):
        return "it is no data set"
    if node.is_virtual or node.external:
        return f"{OUTSIDE}: it is a view of other data sets or files"
    # Before any other look at it: text and objects of Python may need to be unpacked for one.
    if node.shape is None:
        return "it holds nothing"
    if node.dtype.kind not in "fiub":
        held = "text or objects" if node.dtype.kind in "OSU" else node.dtype
        return f"it holds {held}, no plain numbers"
    return "" if node.ndim in (1, 2) else f"it has {node.ndim} dimensions"


def _note(results: dict[str, Any], other: dict[str, str], path: Path) -> str:
    """Return what to say of that which is no column; refuse what lies outside of the file."""
    for name, why in other.items():
        if why.startswith(OUTSIDE):
            raise _refused(name, why, path)
    if not results:
        raise RecordingError(
            "the file holds no data set of numbers of one or two dimensions",
            where=str(path),
            fix="save the samples as data sets of shape (rows,) or (rows, columns)",
        )
    each = listed((f"{name} ({why})" for name, why in other.items()), most=10)
    return f"not read: {each}" if other else ""


def _missing(
    name: str, results: dict[str, Any], other: dict[str, str], path: Path
) -> RecordingError:
    if name in other:
        return _refused(name, other[name], path)
    return RecordingError(
        f"there is no column {name!r}; the columns are {listed(results) or 'none'}",
        where=str(path),
        fix=f"name a column that is there; the nearest are {nearest(name, results)}",
    )


def _refused(name: str, why: str, path: Path) -> RecordingError:
    return RecordingError(
        f"{name} cannot be read: {why}",
        where=f"{path}, {name}",
        fix="write the samples into the file itself, as plain numbers of shape (rows,) or "
        "(rows, columns), plain or packed by gzip (`h5repack -f GZIP=4`)",
    )
