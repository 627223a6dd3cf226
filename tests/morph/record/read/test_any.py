from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from morph.errors import RecordingError
from morph.record.read.any import ENDINGS, read

CODE = """
import sys
import morph
assert not {"rosbags", "h5py", "apsw", "pyarrow"} & set(sys.modules)
from pathlib import Path
from morph.record.load import load_recordings
load_recordings(Path(sys.argv[1]))
assert not {"rosbags", "h5py", "apsw"} & set(sys.modules)
"""


def test_neither_morph_nor_a_csv_loads_the_libraries_of_other_files(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    path.write_text("time,hip.position\n" + "".join(f"{at},0.5\n" for at in range(12)))
    run = subprocess.run(
        [sys.executable, "-c", CODE, str(path)], capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stderr


@pytest.mark.parametrize("ending", ENDINGS)
@pytest.mark.parametrize("content", [None, b"", b"rubbish"])
def test_a_file_that_is_missing_empty_or_rubbish_is_refused(
    tmp_path: Path, ending: str, content: bytes | None
) -> None:
    path = tmp_path / f"run{ending}"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(RecordingError) as caught:
        read(path)
    assert str(path) in caught.value.where
    assert caught.value.fix
    assert [one.name for one in tmp_path.iterdir()] == ([] if content is None else [path.name])


@pytest.mark.parametrize("ending", ENDINGS)
def test_a_folder_by_the_name_of_a_file_is_refused(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"run{ending}"
    path.mkdir()
    with pytest.raises(RecordingError) as caught:
        read(path)
    assert caught.value.where.startswith(str(path))
