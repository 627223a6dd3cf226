from __future__ import annotations

import io
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from morph.errors import RecordingError
from morph.record.load import load


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


WHOLE = {
    ".npz": npz(),
    ".parquet": parquet(),
    ".csv": b"time,a.position\n" + b"".join(b"%d,0.5\n" % at for at in range(12)),
    ".toml": b'[[episode]]\nfile = "a.csv"\n[columns]\ntime = {column = 0, unit = "s"}\n'
    b'"a.position" = {column = 1, unit = "rad"}\n',
}


@pytest.mark.parametrize("ending", sorted(WHOLE))
@settings(max_examples=60, deadline=None, database=None)
@given(data=st.data())
def test_any_bytes_are_read_or_refused_by_name(ending: str, data: st.DataObject) -> None:
    whole = WHOLE[ending]
    at = data.draw(st.integers(0, len(whole)))
    junk = data.draw(st.binary(max_size=12))
    rest = data.draw(st.sampled_from([b"", whole[at:], whole[at + len(junk) :]]))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"a{ending}"
        path.write_bytes(whole[:at] + junk + rest)
        runs, refused = (), None
        try:
            runs = load(path)
        except RecordingError as error:
            refused = error
        assert refused is None or (folder in refused.where and refused.fix)
        assert all(np.isfinite(one.value).all() for run in runs for one in run.channels.values())
