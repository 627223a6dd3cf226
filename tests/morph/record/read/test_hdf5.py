from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

import h5py
import numpy as np
import pytest

from morph.errors import RecordingError
from morph.record.load import load_recordings
from morph.record.read import hdf5

TIME = np.arange(20) / 8
BINDING = """\
[[episode]]
file = "run.h5"
key = "rig/17"

[columns]
time = { column = "clock", unit = "ms" }
"hip.position" = { column = "arm/q", element = 1, unit = "deg" }
"""


def canonical(group: h5py.Group, **more: object) -> None:
    group["time"] = TIME
    group["hip.position"] = np.sin(TIME)
    for name, value in more.items():
        group[name.replace("_", ".")] = value


@pytest.mark.parametrize(
    "settings",
    [{}, {"chunks": (7,)}, {"compression": "gzip", "shuffle": True}, {"compression": "lzf"}],
)
@pytest.mark.parametrize("kind", ["<f8", ">f8", "<f4", "<i2", "?"])
def test_numbers_of_any_kind_and_packing_are_read(
    tmp_path: Path, settings: dict[str, object], kind: str
) -> None:
    numbers = (np.arange(20) % 3 == 0).astype(kind)
    with h5py.File(tmp_path / "run.h5", "w") as file:
        canonical(file)
        file.create_dataset("hip.command", data=numbers, **settings)
    (run,) = load_recordings(tmp_path / "run.h5")
    assert np.array_equal(run["hip.command"], numbers.astype(np.float64))
    assert np.array_equal(run["hip.position"], np.sin(TIME))


def test_a_channel_may_have_a_clock_of_its_own(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "run.hdf5", "w") as file:
        canonical(file)
        file["hip.command"] = np.arange(12.0)
        file["hip.command.time"] = np.arange(12.0) / 4
    (run,) = load_recordings(tmp_path / "run.hdf5")
    assert np.array_equal(run.channel("hip.command").time, np.arange(12.0) / 4)
    assert np.array_equal(run.channel("hip.position").time, TIME)


def test_a_file_of_groups_is_a_recording_for_each(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "run.h5", "w") as file:
        for at in (1, 2):
            canonical(file.create_group(f"day_{at}"), knee_position=np.arange(20.0) * at)
        file["about"] = "two days"
    runs = load_recordings(tmp_path / "run.h5")
    assert [run.name for run in runs] == ["run_day_1", "run_day_2"]
    assert np.array_equal(runs[1]["knee.position"], 2.0 * np.arange(20))


def test_a_key_names_the_group_of_an_episode(tmp_path: Path) -> None:
    angles = np.random.default_rng(0).normal(size=(20, 3))
    with h5py.File(tmp_path / "run.h5", "w") as file:
        file["rig/17/clock"] = np.arange(20) * 4
        file["rig/17/arm/q"] = angles
        file["rig/17/camera"] = np.zeros((20, 4, 4, 3), dtype=np.uint8)
    path = tmp_path / "recording.toml"
    path.write_text(BINDING)
    (run,) = load_recordings(path)
    assert run.name == "run_rig/17"
    # Two products of floats, each rounded by 1.1e-16, may differ in order; 1e-15 is 4 such steps.
    assert np.allclose(run["hip.position"], np.radians(angles[:, 1]), rtol=1e-15, atol=0)
    assert np.allclose(run.channel("hip.position").time, np.arange(20) * 0.004, rtol=1e-15, atol=0)


def test_a_key_may_name_one_block_of_columns(tmp_path: Path) -> None:
    block = np.arange(60.0).reshape(20, 3)
    with h5py.File(tmp_path / "run.h5", "w") as file:
        file["rig/17"] = block
    path = tmp_path / "recording.toml"
    path.write_text(BINDING.replace('"clock"', "0").replace('"arm/q", element = 1', "2"))
    (run,) = load_recordings(path)
    assert np.allclose(run["hip.position"], np.radians(block[:, 2]), rtol=1e-15, atol=0)


def test_what_is_no_column_is_noted(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "run.h5", "w") as file:
        canonical(file)
        file["about"] = "a text"
        file["camera"] = np.zeros((20, 4, 4))
        file["again"] = h5py.SoftLink("/time")
    (run,) = load_recordings(tmp_path / "run.h5")
    assert list(run.channels) == ["hip.position"]
    (note,) = run.notes
    assert "about (it holds text or objects" in note.what
    assert "camera (it has 3 dimensions)" in note.what
    assert "again (it is a link" in note.what


def outside(file: h5py.File, folder: Path) -> None:
    with h5py.File(folder / "other.h5", "w") as other:
        other["q"] = TIME
    file["hip.velocity"] = h5py.ExternalLink("other.h5", "q")


def virtual(file: h5py.File, folder: Path) -> None:
    with h5py.File(folder / "other.h5", "w") as other:
        other["q"] = TIME
    layout = h5py.VirtualLayout(shape=(20,), dtype="f8")
    layout[:] = h5py.VirtualSource(folder / "other.h5", "q", shape=(20,))
    file.create_virtual_dataset("hip.velocity", layout)


def raw(file: h5py.File, folder: Path) -> None:
    (folder / "raw.bin").write_bytes(bytes(160))
    file.create_dataset("hip.velocity", (20,), "f8", external=[(folder / "raw.bin", 0, 160)])


def vast(file: h5py.File, folder: Path) -> None:
    file.create_dataset("hip.velocity", (2**45,), "f8", chunks=(2**10,), compression="gzip")


def many(file: h5py.File, folder: Path) -> None:
    file.create_dataset("a", (2**26,), "f4", chunks=(2**10,))
    for at in range(9):
        file[f"hip_{at}.velocity"] = file["a"]


def wide(file: h5py.File, folder: Path) -> None:
    file.create_dataset("hip.velocity", (20,), "f8", maxshape=(None,), chunks=(2**28,))


def bomb(file: h5py.File, folder: Path) -> None:
    """A chunk of 400 KB that declares to hold 2 MiB and unpacks to 400 MB."""
    import zlib

    packer = zlib.compressobj(9)
    data = b"".join(packer.compress(bytes(2**20)) for _ in range(400)) + packer.flush()
    made = file.create_dataset("hip.velocity", (2**18,), "f8", chunks=(2**18,), compression="gzip")
    made.id.write_direct_chunk((0,), data)


def fat(file: h5py.File, folder: Path) -> None:
    made = file.create_dataset("hip.velocity", (20,), "f8", chunks=(20,), compression="gzip")
    made.id.write_direct_chunk((0,), bytes(200_000))


def strange(file: h5py.File, folder: Path) -> None:
    file.create_dataset("hip.velocity", data=np.arange(20), chunks=(20,), scaleoffset=0)


def nothing(file: h5py.File, folder: Path) -> None:
    del file["time"], file["hip.position"]
    file["about"] = "a text"


def blocks(file: h5py.File, folder: Path) -> None:
    file["hip.velocity"] = np.zeros((20, 2))


def lengths(file: h5py.File, folder: Path) -> None:
    file["hip.velocity"] = np.zeros(19)


def words(file: h5py.File, folder: Path) -> None:
    file["velocities"] = TIME


@pytest.mark.parametrize(
    ("spoil", "what"),
    [
        (outside, "lies outside the file: it is a link to 'other.h5'"),
        (virtual, "lies outside the file: it is a view"),
        (raw, "lies outside the file: it is a view"),
        (vast, "with its 35184372088832 numbers the columns take more than 6[0-9]{7} bytes"),
        (many, "with its 67108864 numbers the columns take more than 6[0-9]{7} bytes"),
        (wide, "its chunks declare 2147483648 bytes each"),
        (bomb, "a chunk unpacks to more than the 2097152 bytes that it declares"),
        (fat, "a chunk of 160 bytes takes 200000 bytes packed"),
        (strange, "packed by filter 6; gzip and lzf are read"),
        (nothing, "no data set of numbers"),
        (blocks, "each cell of column 'hip.velocity' holds 2 numbers"),
        (lengths, "hip.velocity has 19 samples, its clock 'time' has 20"),
        (words, "'velocities' names no known quantity"),
    ],
)
def test_a_file_that_cannot_be_used_is_refused_at_once(
    tmp_path: Path,
    spoil: Callable[[h5py.File, Path], None],
    what: str,
    processor: Callable[[float], AbstractContextManager[None]],
) -> None:
    path = tmp_path / "run.h5"
    with h5py.File(path, "w") as file:
        canonical(file)
        spoil(file, tmp_path)
    before = sorted(tmp_path.iterdir())
    # The 2^45 numbers of one would be read for ever.
    with processor(3.0), pytest.raises(RecordingError, match=what) as caught:
        load_recordings(path)
    assert str(path) in caught.value.where
    assert caught.value.fix
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize(
    ("old", "new", "what", "fix"),
    [
        ("rig/17", "rig/18", "no group 'rig/18'; '/rig' holds 17", "'17'"),
        ("rig/17", "rig/17/clock/a", "there is no group", "none"),
        ("rig/17", "away", "lies outside the file", "into the file itself"),
        ('"clock"', '"clok"', "no column 'clok'; the columns are arm/q, clock", "'clock'"),
        ('"clock"', '"about"', "it holds text or objects, no plain numbers", "plain numbers"),
        ('"clock"', '"there"', "lies outside the file", "into the file itself"),
        (", element = 1", "", "each cell of column 'arm/q' holds 3", "element = 0"),
    ],
)
def test_a_binding_that_does_not_fit_its_file_is_refused(
    tmp_path: Path, old: str, new: str, what: str, fix: str
) -> None:
    with h5py.File(tmp_path / "run.h5", "w") as file:
        file["rig/17/clock"] = np.arange(20.0)
        file["rig/17/arm/q"] = np.ones((20, 3))
        file["rig/17/about"] = "text"
        file["rig/17/there"] = h5py.ExternalLink("other.h5", "q")
        file["away"] = h5py.ExternalLink("other.h5", "q")
    path = tmp_path / "recording.toml"
    path.write_text(BINDING)
    assert len(load_recordings(path)) == 1
    path.write_text(BINDING.replace(old, new, 1))
    with pytest.raises(RecordingError, match=what) as caught:
        load_recordings(path)
    assert str(tmp_path / "run.h5") in caught.value.where
    assert fix in caught.value.fix


def test_a_group_within_itself_ends(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "run.h5", "w") as file:
        canonical(file)
        file["loop"] = file["/"]
    (run,) = load_recordings(tmp_path / "run.h5")
    assert "loop (it is a group within itself" in run.notes[0].what


@pytest.mark.parametrize("kept", [0.0, 0.1, 0.5, 0.95])
def test_a_truncated_file_is_refused(tmp_path: Path, kept: float) -> None:
    path = tmp_path / "run.h5"
    with h5py.File(path, "w") as file:
        canonical(file)
    data = path.read_bytes()
    path.write_bytes(data[: int(kept * len(data))])
    with pytest.raises(RecordingError, match=r"truncated, damaged or not HDF5|file is empty"):
        load_recordings(path)


@pytest.mark.parametrize(
    "end",
    [
        "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)",
        "import sys; sys.exit(1)",
        "import sys; sys.stdout.write('{\"key\": null')",
        "import resource; resource.setrlimit(resource.RLIMIT_CPU, (1, 1))\nwhile True: pass",
    ],
)
def test_what_ends_the_process_that_reads_does_not_end_ours(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, end: str
) -> None:
    # Damaged bytes make HDF5 2.0 write and read where nothing is: a fuzzer found some in minutes.
    path = tmp_path / "run.h5"
    with h5py.File(path, "w") as file:
        canonical(file)
    monkeypatch.setattr(hdf5, "COMMAND", end)
    with pytest.raises(RecordingError, match="damaged or not HDF5: HDF5 gives up on it") as caught:
        load_recordings(path)
    assert caught.value.where == str(path)
    assert "copy the file again" in caught.value.fix
