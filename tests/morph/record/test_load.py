from __future__ import annotations

import gzip
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from morph.body.robot import Actuator, Joint, Link, Robot
from morph.errors import RecordingError
from morph.record.load import check_distinct, load_recordings
from morph.record.recording import Channel, Recording

HEADER = "time,hinge.position,hinge.command"


@pytest.fixture
def pendulum() -> Robot:
    return Robot(
        name="pendulum",
        links=(Link(name="arm", mass=1.0, com=(0, 0, 0), inertia=(1.0,) * 6),),
        joints=(Joint(name="hinge", kind="hinge", link="arm"),),
        actuators=(Actuator(name="hinge", joint="hinge", kind="motor"),),
        mjcf="",
    )


def lines(count: int = 20, header: str = HEADER) -> list[str]:
    return [header, *(f"{0.01 * at:.2f},{0.1 * at},{at}" for at in range(count))]


def save(path: Path, rows: list[str]) -> Path:
    path.write_text("\n".join(rows) + "\n")
    return path


def changed(row: int, text: str) -> Callable[[list[str]], list[str]]:
    return lambda rows: [*rows[:row], text, *rows[row + 1 :]]


def test_a_canonical_csv_is_read_and_its_command_holds(tmp_path: Path, pendulum: Robot) -> None:
    (run,) = load_recordings(save(tmp_path / "run_1.csv", lines()), robot=pendulum)
    assert run.name == "run_1"
    assert run.notes == ()
    # Half way from sample 3 to 4: the position, 0.1 a sample, is 0.35; the command still is 3.
    assert run.channel("hinge.position").at(np.array([0.035])) == pytest.approx(0.35, rel=1e-12)
    assert run.channel("hinge.command").at(np.array([0.035])) == pytest.approx(3.0)


@pytest.mark.parametrize(
    ("spoil", "what", "place"),
    [
        (changed(5, "0.04,inf,4"), "hinge.position is infinite in 1 of 20", "line 6"),
        (changed(5, "0.01,0.4,4"), "clock runs backwards at 1 of 20 samples", "line 6"),
        (changed(5, "0.04,zero,4"), "the cell 'zero' in column 'hinge.position'", "line 6"),
        (changed(5, "0.04,0.4"), "the line has 2 fields, the first has 3", "line 6"),
        (changed(0, "time,hinge.positon,hinge.command"), "no known quantity", "line 1"),
        (changed(0, "time,time,hinge.command"), "a column twice: 'time'", "line 1"),
        (changed(0, "t,hinge.position,hinge.command"), "no column 'time'", "line 1"),
        (lambda rows: rows[:1], "a header and no samples", "line 1"),
        (lambda rows: rows[:10], "9 samples are left of 9; .* at least 10", "run.csv"),
        (lambda rows: [], "the file is empty", "run.csv"),
    ],
)
def test_a_spoilt_file_is_refused_at_its_line(
    tmp_path: Path, spoil: Callable[[list[str]], list[str]], what: str, place: str
) -> None:
    path = save(tmp_path / "run.csv", spoil(lines()))
    with pytest.raises(RecordingError, match=what) as caught:
        load_recordings(path)
    assert str(path) in caught.value.where
    assert caught.value.where.endswith(place)
    assert caught.value.fix


def test_rare_missing_samples_and_repeated_stamps_are_dropped_and_counted(tmp_path: Path) -> None:
    rows = lines(300)
    rows[8], rows[101] = "0.07,nan,7", "1.00,,100"
    rows[200] = "1.98,3.0,3"  # The line before has 1.98 too.
    (run,) = load_recordings(save(tmp_path / "run.csv", rows))
    # 1 % of 300 is 3 missing samples at most; 2 are.
    assert run.samples == 300 - 2 - 1
    missing, repeated = run.notes
    assert (missing.dropped, repeated.dropped) == (2, 1)
    assert "hinge.position: NaN or missing in 2 of 300" in missing.what
    assert missing.where.endswith("lines 9, 102")
    assert repeated.where.endswith("line 201")


def test_more_missing_samples_than_one_percent_are_refused(tmp_path: Path) -> None:
    rows = lines(300)
    rows[10:14] = [f"0.{at:02d},nan,1" for at in range(9, 13)]
    with pytest.raises(RecordingError, match="in 4 of 300 samples; at most 3") as caught:
        load_recordings(save(tmp_path / "run.csv", rows))
    assert caught.value.where.endswith("lines 11, 12, 13, 14")
    assert "remove these samples" in caught.value.fix


def test_blank_lines_do_not_shift_the_line_that_an_error_names(tmp_path: Path) -> None:
    rows = lines()
    rows.insert(3, "")
    rows[9] = "0.07,inf,7"
    with pytest.raises(RecordingError, match="infinite") as caught:
        load_recordings(save(tmp_path / "run.csv", rows))
    assert caught.value.where.endswith("line 10")


@pytest.mark.parametrize("kept", [5, 40, -1])
def test_a_truncated_gzip_is_refused(tmp_path: Path, kept: int) -> None:
    path = tmp_path / "run.csv.gz"
    path.write_bytes(gzip.compress("\n".join(lines()).encode())[:kept])
    with pytest.raises(RecordingError, match="truncated or damaged") as caught:
        load_recordings(path)
    assert caught.value.where == str(path)
    assert "copy the file again" in caught.value.fix


@pytest.mark.parametrize(
    ("channel", "what", "near"),
    [
        ("hindge.position", "names no joint of pendulum; its joints are hinge", "'hinge'"),
        ("arm.command", "names no actuator of pendulum; its actuators are hinge", "'hinge'"),
        ("leg.position.x", "names no link of pendulum; its links are arm", "'arm'"),
    ],
)
def test_a_channel_that_names_no_part_of_the_robot_is_refused(
    tmp_path: Path, pendulum: Robot, channel: str, what: str, near: str
) -> None:
    path = save(tmp_path / "run.csv", lines(header=f"time,hinge.position,{channel}"))
    with pytest.raises(RecordingError, match=what) as caught:
        load_recordings(path, robot=pendulum)
    assert caught.value.where == str(path)
    assert near in caught.value.fix
    assert len(load_recordings(path)) == 1


def test_the_sites_of_a_robot_are_not_checked(tmp_path: Path, pendulum: Robot) -> None:
    path = save(tmp_path / "run.csv", lines(header="time,imu.gyro.x,imu.gyro.y"))
    assert len(load_recordings(path, robot=pendulum)) == 1


def test_a_folder_is_read_in_order_of_name(tmp_path: Path) -> None:
    for at in (2, 1):
        save(tmp_path / f"run_{at}.csv", lines(20 + at))
    (tmp_path / "README.md").write_text("notes")
    assert [run.name for run in load_recordings(tmp_path)] == ["run_1", "run_2"]


def test_of_two_identical_episodes_one_is_kept_even_if_one_is_compressed(tmp_path: Path) -> None:
    save(tmp_path / "a.csv", lines())
    copy = save(tmp_path / "b.csv", lines())
    save(tmp_path / "c.csv", lines(30))
    one, other = load_recordings(tmp_path)
    assert [one.name, other.name] == ["a", "c"]
    (note,) = one.notes
    assert "'b' is identical to 'a' in all its values, and was left out" in note.what
    assert note.where == str(copy)
    (tmp_path / "b.csv.gz").write_bytes(gzip.compress(copy.read_bytes()))
    copy.unlink()
    assert [each.name for each in load_recordings(tmp_path)] == ["a", "c"]


def test_a_torn_last_line_is_left_out_and_told(tmp_path: Path) -> None:
    (run,) = load_recordings(save(tmp_path / "run.csv", changed(20, "0.19,1.")(lines())))
    assert len(run["hinge.position"]) == 19
    assert any("was left out: the file seems to be truncated" in note.what for note in run.notes)


def test_the_same_recording_in_two_loads_is_found(tmp_path: Path) -> None:
    (one,) = load_recordings(save(tmp_path / "a.csv", lines()))
    (other,) = load_recordings(save(tmp_path / "b.csv", lines(30)))
    check_distinct((one, other))
    with pytest.raises(RecordingError, match="identical"):
        check_distinct((one, other, replace(one, name="again")))


@pytest.mark.parametrize("name", ["none.csv", "none.bag", "empty"])
def test_what_cannot_be_read_is_refused(tmp_path: Path, name: str) -> None:
    (tmp_path / "empty").mkdir()
    with pytest.raises(RecordingError) as caught:
        load_recordings(tmp_path / name)
    assert caught.value.where == str(tmp_path / name)
    assert caught.value.fix


def test_a_copy_on_another_clock_is_a_copy() -> None:
    time = np.linspace(0.0, 1.0, 50)
    one, other = (
        Recording(name=name, channels={"q.position": Channel(time=at, value=np.sin(time))})
        for name, at in (("one", time), ("other", time + 100.0))
    )
    with pytest.raises(RecordingError, match="'one' and 'other' are identical"):
        check_distinct((one, other))


def test_a_path_without_anything_is_told_as_that(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="there is no such file or folder"):
        load_recordings(tmp_path / "nothing")


def test_a_file_with_a_binding_beside_it_names_the_folder(tmp_path: Path, pendulum: Robot) -> None:
    file = save(tmp_path / "log.csv", lines(header="t,angle,torque"))
    (tmp_path / "recording.toml").write_text(
        """[[episode]]
file = "log.csv"
[columns]
time = { column = "t", unit = "s" }
"hinge.position" = { column = "angle", unit = "rad" }
"hinge.command" = { column = "torque", unit = "N m" }
"""
    )
    with pytest.raises(RecordingError) as caught:
        load_recordings(file, robot=pendulum)
    assert caught.value.fix.startswith(f"give {tmp_path} in its place")
    # What it says works.
    assert len(load_recordings(tmp_path, robot=pendulum)) == 1
