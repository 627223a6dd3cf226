from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import h5py
import numpy as np
import pytest

from morph.record.load import load_recordings
from morph.record.recording import Channel, Recording
from morph.record.write import write

STEP = 8_000_000
"""Nanoseconds from sample to sample."""


@pytest.fixture
def motion() -> Recording:
    # Nanoseconds below 2^53 over 1e9 are rounded once, so every reader must find the same float.
    time = np.arange(40) * STEP / 1e9
    rng = np.random.default_rng(7)
    names = ("hip.position", "knee.position", "hip.velocity", "knee.velocity", "hip.command")
    return Recording(
        name="run",
        channels={
            name: Channel(time=time, value=rng.normal(size=40), hold=name.endswith("command"))
            for name in names
        },
    )


def as_hdf5(motion: Recording, path: Path) -> Path:
    with h5py.File(path, "w") as file:
        file["time"] = motion.channel("hip.position").time
        for name, channel in motion.channels.items():
            file[name] = channel.value
    return path


def as_bag(
    motion: Recording,
    folder: Path,
    storage: str,
    ros: SimpleNamespace,
    write_bag: Callable[..., Path],
) -> Path:
    block = [
        motion[f"{name}.{what}"] for what in ("position", "velocity") for name in ("hip", "knee")
    ]
    states = [
        (at * STEP + 77, ros.joints(at * STEP, ["hip", "knee"], row[:2], row[2:]))
        for at, row in enumerate(np.stack(block, axis=1))
    ]
    sent = [(at * STEP, ros.array([u])) for at, u in enumerate(motion["hip.command"])]
    topics = [
        ("/joint_states", "sensor_msgs/JointState", states),
        ("/hip/command", "std_msgs/Float64MultiArray", sent),
    ]
    return write_bag(folder, topics, storage=storage)


@pytest.mark.parametrize(
    "form",
    ["run.csv", "run.npz", "run.parquet", "run.h5", "mcap", "sqlite3", "one mcap", "one db3"],
)
def test_the_same_motion_is_the_same_recording_in_every_form(
    tmp_path: Path,
    motion: Recording,
    form: str,
    ros: SimpleNamespace,
    write_bag: Callable[..., Path],
) -> None:
    if form == "run.h5":
        path = as_hdf5(motion, tmp_path / form)
    elif form.startswith("run."):
        path = write(motion, tmp_path / form)
    else:
        storage = "mcap" if form.endswith("mcap") else "sqlite3"
        path = as_bag(motion, tmp_path / "run", storage, ros, write_bag)
        path = path if form == storage else next(path.glob(f"*.{form.split()[1]}"))
    before = sorted(tmp_path.rglob("*"))
    (run,) = load_recordings(path)
    assert sorted(tmp_path.rglob("*")) == before
    assert run.name == "run"
    assert run.notes == ()
    assert set(run.channels) == set(motion.channels)
    for name, channel in motion.channels.items():
        assert np.array_equal(run.channel(name).time, channel.time)
        assert np.array_equal(run[name], channel.value)
        assert run.channel(name).hold == channel.hold


def test_a_folder_of_bags_and_files_is_read_in_order_of_name(
    tmp_path: Path, motion: Recording, ros: SimpleNamespace, write_bag: Callable[..., Path]
) -> None:
    as_bag(motion, tmp_path / "b", "mcap", ros, write_bag)
    less = {name: one for name, one in motion.channels.items() if name != "hip.command"}
    as_hdf5(Recording(name="a", channels=less), tmp_path / "a.h5")
    (tmp_path / "notes").mkdir()
    assert [run.name for run in load_recordings(tmp_path)] == ["a", "b"]
