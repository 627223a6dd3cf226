"""HDF5 files with more groups and data sets than are read."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest

from morph.errors import RecordingError
from morph.record.load import load_recordings
from morph.record.read import hdf5_file

TIME = np.arange(20) / 8


def sets(file: h5py.File) -> None:
    for at in range(10_000):
        file.id.links.create_hard(b"%d" % at, file.id, b"time")


def groups(file: h5py.File) -> None:
    """10^12 groups: twelve within each other, each by ten names."""
    group = file["a"] = file.create_group("b")
    for _ in range(11):
        inner = group.create_group("0")
        for at in range(1, 10):
            group[str(at)] = inner
        group = inner


@pytest.mark.parametrize(
    ("spoil", "what"),
    [(sets, "with the 10001 entries of /"), (groups, "with the 10 entries of /")],
)
def test_a_file_of_too_many_is_refused(
    tmp_path: Path, spoil: Callable[[h5py.File], None], what: str
) -> None:
    path = tmp_path / "run.h5"
    with h5py.File(path, "w") as file:
        file["time"] = TIME
        spoil(file)
    with pytest.raises(RecordingError, match=f"{what}.* than are read at once") as caught:
        load_recordings(path)
    assert caught.value.where == str(path)
    assert "key in a recording.toml" in caught.value.fix


def test_what_is_read_at_once_is_counted_groups_included(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "run.h5"
    with h5py.File(path, "w") as file:
        for day in "abc":
            file[f"{day}/arm/q"] = file[f"{day}/arm/v"] = file[f"{day}/time"] = TIME

    def read(every: bool, entries: int, columns: int) -> list[int]:
        monkeypatch.setattr(hdf5_file, "MOST_ENTRIES", entries)
        monkeypatch.setattr(hdf5_file, "MOST_COLUMNS", columns)
        with h5py.File(path) as file:
            blocks = hdf5_file.blocks_in(file, path, None, None, every)
            return [len(block.columns) for block in blocks]

    # Three groups; in each a data set and a group of two.
    assert read(every=False, entries=0, columns=3 + 3 * 4) == [9]
    # Each day is read for itself; at first the two of each are counted.
    assert read(every=True, entries=3 * 2, columns=4) == [3, 3, 3]
    for every, entries, columns in ((False, 99, 14), (True, 99, 3), (True, 5, 99), (True, 99, 2)):
        with pytest.raises(RecordingError, match="more groups and data sets than are read"):
            read(every, entries, columns)


def test_episodes_that_share_their_bytes_are_counted_together(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    with h5py.File(path, "w") as file:
        # Half of the 64 MB that a small file may unpack to.
        made = file.create_dataset("0/time", 4 * 2**20, "f8", chunks=(2**19,), fillvalue=1.0)
        for day in "123":
            file[f"{day}/time"] = made
    with pytest.raises(RecordingError, match="the columns take more than") as caught:
        load_recordings(path)
    assert caught.value.where == f"{path}, time"
