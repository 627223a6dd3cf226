from __future__ import annotations

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


def test_an_npz_keeps_every_clock(tmp_path: Path) -> None:
    wrote = recording(same_clock=False)
    (read,) = load_recordings(write(wrote, tmp_path / "run.npz"))
    assert np.array_equal(read.channel("hip.command").time, wrote.channel("hip.command").time)


def test_a_csv_holds_commands_on_the_clock_of_what_is_measured(tmp_path: Path) -> None:
    wrote = recording(same_clock=False)
    (read,) = load_recordings(write(wrote, tmp_path / "run.csv"))
    # Commands are sent at every second sample, just before it, and hold for the next.
    assert np.array_equal(read["hip.command"], np.repeat(wrote["hip.command"], 2))


def test_the_same_recording_gives_the_same_bytes(tmp_path: Path) -> None:
    one, other = (write(recording(same_clock=True), tmp_path / f"{at}.csv.gz") for at in "ab")
    assert one.read_bytes() == other.read_bytes()


def test_an_unknown_ending_is_refused(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"cannot be written as 'run\.xls'"):
        write(recording(same_clock=True), tmp_path / "run.xls")
