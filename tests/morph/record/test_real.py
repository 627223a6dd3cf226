from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from morph.record.distinct import check_distinct
from morph.record.load import load_recordings

BINDINGS = Path(__file__).resolve().parents[3] / "experiments" / "bindings"


@pytest.mark.parametrize(
    ("binding", "folder", "episodes"),
    [
        ("dfki_c0.toml", "dfki_double_pendulum", 9),
        ("dfki_a0.toml", "dfki_double_pendulum", 9),
        ("dfki_a0_long.toml", "dfki_double_pendulum", 1),
        ("so101.toml", "so101_sage", 38),
    ],
)
def test_our_bindings_read_every_real_episode(
    recordings: Path, binding: str, folder: str, episodes: int
) -> None:
    runs = load_recordings(BINDINGS / binding, root=recordings / folder)
    assert len(runs) == episodes
    assert all(run.seconds > 5.0 and not run.notes for run in runs)


def test_the_double_pendulum_is_read_as_numpy_reads_it(recordings: Path) -> None:
    folder = recordings / "dfki_double_pendulum"
    runs = {run.name: run for run in load_recordings(BINDINGS / "dfki_c0.toml", root=folder)}
    file = folder / "design_C.0_20220914" / "trajectory_03.csv.gz"
    theirs = np.genfromtxt(file, delimiter=",", names=True)
    run = runs["run_03"]
    assert np.array_equal(run.channel("shoulder.position").time, theirs["time"])
    assert np.array_equal(run["elbow.position"], theirs["pos_meas2"])
    assert np.array_equal(run["elbow.command"], theirs["tau_con2"])
    assert run.channel("elbow.command").hold


def test_sessions_of_two_bindings_are_distinct(recordings: Path) -> None:
    root = recordings / "dfki_double_pendulum"
    files = ("dfki_c0", "dfki_a0", "dfki_a0_long")
    runs = [run for file in files for run in load_recordings(BINDINGS / f"{file}.toml", root=root)]
    check_distinct(runs)
    assert {run.session for run in runs} == {"2022-09-14", "2022-08-15", "2022-08-12"}


def test_two_clocks_and_list_cells_are_bound(recordings: Path, tmp_path: Path) -> None:
    path = tmp_path / "recording.toml"
    path.write_text(f"""\
root = '{recordings / "so101_sage"}'

[[episode]]
file = "multisine/state_motor.csv.gz"
command = {{ file = "multisine/control.csv.gz", hold = "zero-order" }}

[columns]
time = {{ column = "timestamp", unit = "us" }}
"Elbow.position" = {{ column = "positions", element = 2, unit = "rad" }}
"Elbow.command" = {{ column = "positions", element = 2, unit = "rad" }}
""")
    (run,) = load_recordings(path)
    # The first lines of the two files, by eye.
    assert run["Elbow.position"][0] == pytest.approx(0.6097573631845423, rel=1e-15)
    assert run["Elbow.command"][0] == pytest.approx(0.539468, rel=1e-15)
    assert run.channel("Elbow.command").time[1] == pytest.approx(0.020080370013602078, rel=1e-12)


def test_an_npz_of_another_rig_is_bound_through_its_list_cells(
    recordings: Path, tmp_path: Path
) -> None:
    path = tmp_path / "recording.toml"
    path.write_text(f"""\
root = '{recordings / "bluerov2_saabmarine"}'

[[episode]]
file = "rosbag2_2025_05_27-11_57_50_0_3dof_data_all.npz"

[columns]
time = {{ column = "timestamps", unit = "ns" }}
"r.position" = {{ column = "positions", element = [0, 1, 2], unit = "m" }}
"r.orientation" = {{ column = "positions", element = [3, 4, 5], form = "euler-xyz", unit = "rad" }}
"r.linear_velocity" = {{ column = "velocities", element = [0, 1, 2], unit = "m/s", frame = "body" }}
"heave.command" = {{ column = "scaled_controls", element = 2 }}
""")
    (run,) = load_recordings(path)
    # The file has 1384 time stamps and 1383 rows of commands.
    assert run.samples == 1383
    assert [note.dropped for note in run.notes] == [1]
