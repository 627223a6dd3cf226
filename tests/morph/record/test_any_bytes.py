from __future__ import annotations

import io
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from morph.errors import RecordingError
from morph.record.load import load_recordings


def npz() -> bytes:
    sink = io.BytesIO()
    np.savez(sink, **{"time": np.arange(12.0), "hip.position": np.arange(12.0)})
    return sink.getvalue()


def parquet() -> bytes:
    import pyarrow
    from pyarrow import parquet as file

    sink = io.BytesIO()
    file.write_table(pyarrow.table({"time": np.arange(12.0), "a.position": np.ones(12)}), sink)
    return sink.getvalue()


def hdf5() -> bytes:
    import h5py

    sink = io.BytesIO()
    with h5py.File(sink, "w") as file:
        file["time"] = np.arange(12.0)
        file.create_dataset("a.position", data=np.ones(12), chunks=(5,), compression="gzip")
        file["about"] = "words"
    return sink.getvalue()


def bag(storage: str) -> bytes:
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    kind = "std_msgs/msg/Float64MultiArray"
    layout = store.types["std_msgs/msg/MultiArrayLayout"](dim=[], data_offset=0)
    message = store.serialize_cdr(store.types[kind](layout=layout, data=np.ones(1)), kind)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a"
        with Writer(path, version=9, storage_plugin=StoragePlugin[storage.upper()]) as writer:
            topic = writer.add_connection("/a/position", kind, typestore=store)
            for at in range(12):
                writer.write(topic, at, message)
        return next(one for one in path.iterdir() if one.suffix != ".yaml").read_bytes()


WHOLE = {
    ".h5": hdf5(),
    ".mcap": bag("mcap"),
    ".db3": bag("sqlite3"),
    ".npz": npz(),
    ".parquet": parquet(),
    ".csv": b"time,a.position\n" + b"".join(b"%d,0.5\n" % at for at in range(12)),
    ".toml": b'[[episode]]\nfile = "a.csv"\n[columns]\ntime = {column = 0, unit = "s"}\n'
    b'"a.position" = {column = 1, unit = "rad"}\n',
}


@pytest.mark.parametrize("ending", sorted(WHOLE.keys() - {".toml"}))
def test_each_file_is_read_as_long_as_it_is_whole(ending: str, tmp_path: Path) -> None:
    path = tmp_path / f"a{ending}"
    path.write_bytes(WHOLE[ending])
    assert list(load_recordings(path)[0].channels) == [
        "hip.position" if ending == ".npz" else "a.position"
    ]


@pytest.mark.parametrize("ending", sorted(WHOLE.keys() - {".h5"}))
@settings(max_examples=60, deadline=None, database=None)
@given(data=st.data())
def test_any_bytes_are_read_or_refused_by_name(ending: str, data: st.DataObject) -> None:
    check(ending, data)


# Each HDF5 file is read in a process of its own, which takes 0.2 s.
@settings(max_examples=15, deadline=None, database=None)
@given(data=st.data())
def test_any_bytes_of_hdf5_are_read_or_refused_by_name(data: st.DataObject) -> None:
    check(".h5", data)


def check(ending: str, data: st.DataObject) -> None:
    whole = WHOLE[ending]
    at = data.draw(st.integers(0, len(whole)))
    junk = data.draw(st.binary(max_size=12))
    rest = data.draw(st.sampled_from([b"", whole[at:], whole[at + len(junk) :]]))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"a{ending}"
        path.write_bytes(whole[:at] + junk + rest)
        runs, refused = (), None
        try:
            runs = load_recordings(path)
        except RecordingError as error:
            refused = error
        assert refused is None or (folder in refused.where and refused.fix)
        assert all(np.isfinite(one.value).all() for run in runs for one in run.channels.values())
