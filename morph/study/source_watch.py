"""Detection of changes to the source and data files of cells while they run."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from morph.study.cell import Cell
from morph.study.code_hash import sources


class SourceWatch:
    """Modification times of all source and data files of cells, taken on construction.

    Construct it before any code is hashed: a file changed later may run under an outdated hash.
    """

    def __init__(self, cells: Sequence[Cell]) -> None:
        kinds = {(name, cell.path, cell.ignore) for cell in cells for name in cell.modules}
        files = {
            file for name, path, ignore in kinds for file in sources(name, path=path, ignore=ignore)
        }
        files |= {file for cell in cells for file in cell.data}
        self._modified = {file: _modified(file) for file in files}
        self._changed = False

    def look(self) -> bool:
        """Return whether any file has changed since construction."""
        self._changed = self._changed or any(
            _modified(file) != before for file, before in self._modified.items()
        )
        return self._changed


def _modified(file: Path) -> int:
    """Return the modification time of a file, ns; -1 where there is none."""
    try:
        return file.stat().st_mtime_ns
    except OSError:
        return -1
