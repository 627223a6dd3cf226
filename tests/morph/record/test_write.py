from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from morph.errors import OutputError
from morph.record.load import load_recordings
from morph.record.recording import Channel, Recording
from morph.record.write import write


def recording(*, same_clock: bool) -> Recording:
    rng = np.random.default_rng(0)
    time = np.cumsum(rng.uniform(0.001, 0.003, 200))
    sent = time if same_clock else time[::2] - 1e-4
    return Recording(
        name="run",
        channels={
            "hip.command": Channel(time=sent, value=rng.normal(size=len(sent)), hold=True),
            "hip.position": Channel(time=time, value=rng.normal(size=200)),
        },
    )


@pytest.mark.parametrize("ending", [".csv", ".csv.gz", ".parquet", ".npz"])
def test_what_is_written_reads_back_bit_by_bit(tmp_path: Path, ending: str) -> None:
    wrote = recording(same_clock=True)
    (read,) = load_recordings(write(wrote, tmp_path / f"run{ending}"))
    assert list(read.channels) == list(wrote.channels)
    for name, channel in wrote.channels.items():
        assert np.array_equal(read.channel(name).time, channel.time)
        assert np.array_equal(read[name], channel.value)
        assert read.channel(name).hold == channel.hold


@pytest.mark.parametrize("ending", [".csv", ".parquet", ".npz"])
@pytest.mark.parametrize("often", [1, 3])
def test_every_clock_is_kept(tmp_path: Path, ending: str, often: int) -> None:
    """Commands are sent at every second sample, or more often than anything is read."""
    wrote = recording(same_clock=False)
    sent = wrote.channel("hip.command")
    if often > 1:
        time = np.linspace(sent.time[0], sent.time[-1], often * 200)
        sent = replace(sent, time=time, value=np.cos(time))
    wrote = replace(wrote, channels={**wrote.channels, "hip.command": sent})
    (read,) = load_recordings(write(wrote, tmp_path / f"run{ending}"))
    assert not read.notes
    for name, channel in wrote.channels.items():
        assert np.array_equal(read.channel(name).time, channel.time)
        assert np.array_equal(read[name], channel.value)


def test_a_cell_that_is_missing_above_the_last_sample_is_told(tmp_path: Path) -> None:
    path = write(recording(same_clock=False), tmp_path / "run.csv")
    rows = path.read_text().splitlines()
    cells = rows[7].split(",")
    path.write_text("\n".join([*rows[:7], ",".join(["", *cells[1:]]), *rows[8:], ""]))
    (read,) = load_recordings(path)
    assert [note.dropped for note in read.notes] == [1]
    assert "line 8" in read.notes[0].where
    assert len(read["hip.position"]) == 199
    assert len(read["hip.command"]) == 100


def test_the_same_recording_gives_the_same_bytes(tmp_path: Path) -> None:
    one, other = (write(recording(same_clock=True), tmp_path / f"{at}.csv.gz") for at in "ab")
    assert one.read_bytes() == other.read_bytes()


def test_an_unknown_ending_is_refused(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"cannot be written as 'run\.xls'"):
        write(recording(same_clock=True), tmp_path / "run.xls")
