"""Reading HDF5 files: a data set is a column, and a group is an episode.

Nothing outside the file is opened: links to other files, raw data kept in other files and virtual
data sets are refused. Every declared size is checked before memory is taken.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from morph.arrays import Array
from morph.errors import RecordingError
from morph.record.nearest import nearest
from morph.record.read.file import MOST_BYTES, MOST_COLUMNS, size_of
from morph.record.read.inflate import check_chunks
from morph.record.read.table import Table, listed
from morph.record.recording import Note

DEEPEST = 32
"""How deep groups may lie within each other."""
OUTSIDE = "it lies outside the file"
"""What the reason of a data set that is not in the file begins with."""


def read_hdf5(path: Path, key: str | None = None, wanted: Collection[str] | None = None) -> Table:
    """Return the data sets of an HDF5 file as columns, named by their paths: `arm/position`.

    Args:
        path: The file.
        key: The group whose data sets are the columns of one episode; or a data
            set of shape (rows, columns), whose columns have numbers only. None:
            the whole file.
        wanted: The columns to read; None for all. What holds no plain numbers of
            one or two dimensions is no column.

    Raises:
        RecordingError: The file is missing, empty or damaged, has no such group or
            column, reaches outside itself, or declares absurd sizes.
    """
    with _opened(path) as file:
        node = file if key is None else _keyed(file, key, path)
        if not _is_group(node):
            (values,) = _numbers({str(key): node}, path)
            columns = tuple(values.T) if values.ndim == 2 else (values,)
            return Table(path=path, names=(), columns=columns)
        found, other = _sorted_out(node, path)
        if wanted is None:
            return _all(found, other, path)
        for name in sorted(set(wanted) - set(found)):
            raise _missing(name, found, other, path)
        found = {name: one for name, one in found.items() if name in wanted}
        return Table(path=path, names=tuple(found), columns=_numbers(found, path))


def episodes_of(path: Path) -> tuple[str | None, ...]:
    """Return the keys of a file's episodes; None alone where the file is one episode.

    A file whose top level has groups and no numbers has an episode in each group.

    Raises:
        RecordingError: The file is missing, empty or damaged.
    """
    with _opened(path) as file:
        nodes = {name: _entry(file, name) for name in file}
        groups = tuple(name for name, node in nodes.items() if _is_group(node))
        numbers = any(not _is_group(node) and not _unfit(node) for node in nodes.values())
        return (None,) if numbers or not groups else groups


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """Give the file; whatever HDF5 stumbles over becomes an error of ours."""
    size_of(path)
    import h5py

    try:
        with h5py.File(path, "r", locking=False) as file:
            yield file
    except RecordingError:
        raise
    # h5py raises a dozen unrelated errors on damaged bytes.
    except Exception as error:
        raise RecordingError(
            f"the file is truncated, damaged or not HDF5: {str(error)[:200]}",
            where=str(path),
            fix="copy the file again, or write it again",
        ) from error


def _is_group(node: Any) -> bool:
    import h5py

    return isinstance(node, h5py.Group)


def _entry(group: Any, name: str) -> Any:
    """Return what stands in a group under a name, or why it is not followed."""
    import h5py

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
            known = list(node) if _is_group(node) else []
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
    found: dict[str, Any] = {}
    other: dict[str, str] = {}
    for name, node in _inside(group, "", frozenset()):
        if len(found) + len(other) >= MOST_COLUMNS:
            raise _refused(group.name, f"it holds more than {MOST_COLUMNS} data sets", path)
        why = _unfit(node)
        if why:
            other[name] = why
        else:
            found[name] = node
    return found, other


def _inside(group: Any, prefix: str, above: frozenset[int]) -> Iterator[tuple[str, Any]]:
    """Give what lies in a group and in those below it, by its path."""
    import h5py

    # A group may be linked from below itself; its address tells that it is the same.
    above |= {h5py.h5o.get_info(group.id).addr}
    for name in group:
        node, path = _entry(group, name), prefix + name
        if not _is_group(node):
            yield path, node
        elif h5py.h5o.get_info(node.id).addr in above or len(above) >= DEEPEST:
            yield path, "it is a group within itself, or too deep"
        else:
            yield from _inside(node, f"{path}/", above)


def _unfit(node: Any) -> str:
    """Return why something in a file is no column, or nothing if it is one."""
    import h5py

    if isinstance(node, str):
        return node
    if not isinstance(node, h5py.Dataset):
        return "it is no data set"
    if node.is_virtual or node.external:
        return f"{OUTSIDE}: it is a view of other data sets or files"
    # Before any other look at it: text and objects of Python may need to be unpacked for one.
    if node.shape is None or node.dtype.kind not in "fiub":
        kind = "nothing" if node.shape is None else node.dtype
        return f"it holds {'text or objects' if kind == object else kind}, no plain numbers"
    return "" if node.ndim in (1, 2) else f"it has {node.ndim} dimensions"


def _all(found: dict[str, Any], other: dict[str, str], path: Path) -> Table:
    """Return all columns, with a note on what is none."""
    for name, why in other.items():
        if why.startswith(OUTSIDE):
            raise _refused(name, why, path)
    if not found:
        raise RecordingError(
            "the file holds no data set of numbers of one or two dimensions",
            where=str(path),
            fix="save the samples as data sets of shape (rows,) or (rows, columns)",
        )
    each = listed((f"{name} ({why})" for name, why in other.items()), most=10)
    notes = (Note(what=f"not read: {each}", where=str(path)),) if other else ()
    return Table(path=path, names=tuple(found), columns=_numbers(found, path), notes=notes)


def _numbers(found: dict[str, Any], path: Path) -> tuple[Array, ...]:
    """Return the numbers of data sets, as long as all of them together are of sane size."""
    total = 0
    for name, one in found.items():
        total += math.prod(one.shape) * max(one.dtype.itemsize, 8)
        if total > MOST_BYTES:
            shape = " x ".join(map(str, one.shape))
            why = f"with its {shape} numbers the columns take more than {MOST_BYTES >> 30} GiB"
            raise _refused(name, why, path)
        why = check_chunks(one)
        if why:
            raise _refused(name, why, path)
    with np.errstate(over="ignore"):
        return tuple(np.asarray(one[()]).astype(np.float64) for one in found.values())


def _missing(name: str, found: dict[str, Any], other: dict[str, str], path: Path) -> RecordingError:
    if name in other:
        return _refused(name, other[name], path)
    return RecordingError(
        f"there is no column {name!r}; the columns are {listed(found) or 'none'}",
        where=str(path),
        fix=f"name a column that is there; the nearest are {nearest(name, found)}",
    )


def _refused(name: str, why: str, path: Path) -> RecordingError:
    return RecordingError(
        f"{name} cannot be read: {why}",
        where=f"{path}, {name}",
        fix="write the samples into the file itself, as plain numbers of shape (rows,) or "
        "(rows, columns), plain or packed by gzip (`h5repack -f GZIP=4`)",
    )
