from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.errors import DiagnosisError, RecordingError
from morph.inference.diagnose import diagnose
from morph.model.corrected import notes
from morph.model.episodes import episode, fills
from morph.model.measurement import Measurement
from morph.model.pieces import gaps, pieces
from morph.model.segments import cut
from morph.model.validate_recordings import (
    check_channels,
    check_falls,
    check_motion,
    check_recordings,
    check_settings,
    check_tree,
)
from morph.record.recording import Channel, Recording

Recorded = Callable[..., Recording]


@pytest.fixture(scope="module")
def swing(pendulum: Robot, recorded: Recorded) -> Recording:
    return recorded(pendulum, start={"hinge": 0.8}, command=lambda t: np.sin(3.0 * t))


def with_position(recording: Recording, time: object, value: object) -> Recording:
    channel = Channel(time=np.asarray(time), value=np.asarray(value))
    return replace(recording, channels={**recording.channels, "hinge.position": channel})


CHAIN = """<mujoco><worldbody>
  <body name="crank"><joint name="crank" axis="0 1 0"/><geom size="0.1"/><site name="one"/></body>
  <body name="rod"><joint name="rod" axis="0 1 0"/><geom size="0.1"/><site name="other"/></body>
</worldbody><equality><connect name="pin" site1="one" site2="other"/></equality></mujoco>"""


def test_a_closed_chain_is_refused_if_it_is_welded(tmp_path: Path) -> None:
    path = tmp_path / "chain.xml"
    path.write_text(CHAIN.replace("connect", "weld"))
    with pytest.raises(DiagnosisError, match="the closed chain pin is welded") as caught:
        check_tree(load(path))
    assert "close the chain by a pin" in caught.value.fix
    path.write_text(CHAIN)
    check_tree(load(path))


@pytest.mark.parametrize(
    ("ties", "joint"),
    [
        ('<joint joint1="rod" joint2="crank" polycoef="0 1 0.5 0 0"/>', "rod"),
        ('<joint joint1="rod"/>', "rod"),
        ('<joint joint1="rod" joint2="crank" polycoef="0.1 0 0 0 0"/>', "rod"),
        ('<joint joint1="rod" joint2="crank"/><joint joint1="rod" joint2="crank"/>', "rod"),
        ('<joint joint1="rod" joint2="crank"/><joint joint1="crank" joint2="rod"/>', "rod"),
        ('<joint joint1="rod" joint2="crank" polycoef="0.1 -2 0 0 0"/>', ""),
        ('<joint joint1="rod" joint2="crank" polycoef="0 1 0.5 0 0" active="false"/>', ""),
    ],
)
def test_joints_may_follow_others_in_proportion_alone(
    tmp_path: Path, ties: str, joint: str
) -> None:
    path = tmp_path / "chain.xml"
    path.write_text(CHAIN.replace('<connect name="pin" site1="one" site2="other"/>', ties))
    robot = load(path)
    if not joint:
        check_tree(robot)
        return
    with pytest.raises(DiagnosisError, match=f"joint {joint} is tied otherwise") as caught:
        check_tree(robot)
    assert "or weld it" in caught.value.fix


def test_a_clock_that_jumps_is_refused_with_its_sample(pendulum: Robot, swing: Recording) -> None:
    channel = swing.channel("hinge.position")
    time = channel.time + np.where(np.arange(len(channel.time)) > 99, 1e7, 0.0)
    with pytest.raises(RecordingError, match=r"jumps by 1e\+07 s after sample 99"):
        check_channels(with_position(swing, time, channel.value), pendulum, ["hinge.position"])


@pytest.mark.parametrize(("value", "what"), [(1e300, "reads 1e"), (np.nan, "NaN or infinity")])
def test_positions_that_no_robot_has_are_refused(
    pendulum: Robot, swing: Recording, value: float, what: str
) -> None:
    channel = swing.channel("hinge.position")
    bad = channel.value.copy()
    bad[7] = value
    with pytest.raises(RecordingError, match=what):
        diagnose(pendulum, [with_position(swing, channel.time, bad)])


def test_a_robot_that_never_moves_is_refused(pendulum: Robot, swing: Recording) -> None:
    channel = swing.channel("hinge.position")
    still = with_position(swing, channel.time, 0.0 * channel.value)
    with pytest.raises(DiagnosisError, match="nothing moves"):
        diagnose(pendulum, [still])


def test_one_still_joint_among_others_is_told_and_stops_nothing(recorded: Recorded) -> None:
    robot = load("double_pendulum")
    runs = []
    for k in range(2):
        # The log of a dead encoder: zeros, whatever the elbow does.
        run = recorded(robot, start={"shoulder": 0.3 + 0.1 * k}, name=f"run_{k}", seconds=3.0)
        elbow = run.channel("elbow.position")
        dead = Channel(time=elbow.time, value=0.0 * elbow.value)
        runs.append(replace(run, channels={**run.channels, "elbow.position": dead}))
    assert check_motion(runs, ("shoulder.position", "elbow.position")) == ("elbow",)
    found = diagnose(robot, runs, budget=2.0)
    assert any("Joint elbow does not move in any run" in note for note in found.notes)
    assert all(np.isfinite(list(row.values())).all() for row in found.held_out_rmse.values())


def test_rollouts_across_a_gap_are_left_out_and_the_gap_is_told(
    pendulum: Robot, swing: Recording
) -> None:
    channel = swing.channel("hinge.position")
    kept = (channel.time < 1.2) | (channel.time > 3.1)
    holed = with_position(swing, channel.time[kept], channel.value[kept])
    laid = episode(holed, pendulum, 0.004)
    ((last, first),) = gaps(laid.time)
    # Episodes keep every other reading of 200 Hz.
    assert 1.189 < last < 1.2
    assert 3.1 < first < 3.111
    # Of the seconds 0-1, 1-2, 2-3, 3-4 the third holds nothing and the second a fifth.
    assert cut([laid], 1.0).first.tolist() == [0, 750]


def test_a_recording_is_cut_at_a_gap(pendulum: Robot, recorded: Recorded) -> None:
    swing = recorded(pendulum, start={"hinge": 0.8}, seconds=6.0)
    channel = swing.channel("hinge.position")
    # The log begins at 0.5 s, and times of pieces count from there.
    early, late = (channel.time > 0.5) & (channel.time < 3.2), channel.time > 3.7
    brief = early & (channel.time < 1.2)
    holed = with_position(swing, channel.time[early | late], channel.value[early | late])
    one, other = pieces(holed, pendulum, 0.004)
    assert (one.begin, other.begin) == (0.0, pytest.approx(3.2, abs=0.011))
    assert one.recording is holed
    # Each piece as if it had been recorded alone: readings by their times in the whole.
    np.testing.assert_array_equal(one.reading[:, 0], channel.value[early][::2])
    np.testing.assert_array_equal(other.reading[:, 0], channel.value[late][::2])
    assert other.time[-1] + other.begin == pytest.approx(channel.time[-1] - 0.5, abs=0.016)
    # A piece of 0.7 s would make the rollouts of all runs shorter than the second they take.
    torn = with_position(swing, channel.time[brief | late], channel.value[brief | late])
    (left,) = pieces(torn, pendulum, 0.004)
    assert left.begin == pytest.approx(3.2, abs=0.011)
    (said,) = notes([torn], [left], [])
    assert said.startswith("run: no reading for 2.51 s after 0.69")
    # Where nothing is left long enough, that is told too.
    last = channel.time > 5.7
    short = with_position(swing, channel.time[last], channel.value[last])
    assert pieces(short, pendulum, 0.004) == []
    assert notes([short], [], [])[0].startswith("run: left out; an episode takes 0.5 s")
    (whole,) = pieces(swing, pendulum, 0.004)
    assert whole.whole


def test_a_clock_in_milliseconds_is_told(pendulum: Robot, swing: Recording) -> None:
    channel = swing.channel("hinge.position")
    slow = with_position(swing, 1e3 * channel.time, channel.value)
    with pytest.raises(RecordingError, match="readings come 5 s apart") as caught:
        check_channels(slow, pendulum, ("hinge.position",))
    assert 'unit = "ms"' in caught.value.fix


def test_commands_that_the_logger_lost_are_told(pendulum: Robot, swing: Recording) -> None:
    time = np.arange(0.0, 4.0, 0.01)
    kept = ~np.isin(np.arange(len(time)), [100, 250, 251])
    lossy = Channel(time=time[kept], value=np.sin(3.0 * time[kept]), hold=True)
    holed = replace(swing, channels={**swing.channels, "hinge.command": lossy})
    laid = episode(holed, pendulum, 0.004)
    assert fills(laid) == ["commands that the logger lost are interpolated, gaps: 2"]
    # Steps of 4 ms that begin within 1.00 to 1.01 s, and within 2.50 to 2.52 s.
    assert np.flatnonzero(laid.unsure[:, 0]).tolist() == [250, 251, 252, 625, 626, 627, 628, 629]
    assert fills(episode(swing, pendulum, 0.004)) == []


@pytest.mark.parametrize(("train", "held_out"), [(["a", "a"], []), (["a"], ["a"])])
def test_recordings_of_one_name_are_refused(
    swing: Recording, train: list[str], held_out: list[str]
) -> None:
    with pytest.raises(DiagnosisError, match="several recordings are called a"):
        check_recordings(
            [replace(swing, name=name) for name in train],
            [replace(swing, name=name) for name in held_out],
        )


def test_holding_everything_out_is_refused(swing: Recording) -> None:
    with pytest.raises(DiagnosisError, match="every recording is held out"):
        check_recordings([], [swing])


def test_a_seed_below_zero_is_refused() -> None:
    with pytest.raises(DiagnosisError, match="a seed of -1"):
        check_settings(1.0, None, -1)


@pytest.mark.parametrize("horizon", [1.0, 3.0, None])
def test_clean_runs_are_clean_at_every_horizon(
    pendulum: Robot, recorded: Recorded, horizon: float | None
) -> None:
    runs = [
        recorded(
            pendulum,
            start={"hinge": 0.7 - 0.3 * k},
            command=lambda t, k=k: np.sin((2.0 + 0.5 * k) * t),
            seed=k,
            name=f"run_{k}",
        )
        for k in range(3)
    ]
    found = diagnose(pendulum, runs, horizon=horizon)
    assert (found.verdict, found.findings) == ("consistent", ())


def test_a_link_that_something_holds_up_is_refused_and_one_that_falls_is_not() -> None:
    robot, time = load("humanoid"), np.linspace(0.0, 1.0, 201)
    measurement = Measurement.of(robot)
    channels = {f"{a.name}.command": 0.0 * time for a in robot.actuators}
    channels |= {name: 0.01 * np.sin(6.0 * time) for name in measurement.needed}
    (names,) = measurement.quaternions
    channels[names[0]] = 1.0 + 0.0 * time
    fallen = {**channels, measurement.recorded[2]: 2.0 - 4.905 * time**2}
    stands, falls = (
        Recording(name=name, channels={k: Channel(time=time, value=v) for k, v in values.items()})
        for name, values in (("stands", channels), ("falls", fallen))
    )
    check_falls([episode(falls, robot, 0.005)], robot)
    with pytest.raises(DiagnosisError, match="does not fall as it would alone"):
        check_falls([episode(stands, robot, 0.005)], robot)


def test_a_link_that_floats_as_described_is_not_refused(tmp_path: Path) -> None:
    path, time = tmp_path / "buoy.xml", np.linspace(0.0, 1.0, 201)
    still: dict[str, Array] = {"hull.orientation.w": 1.0 + 0.0 * time}
    for axis in "xyz":
        still |= {f"hull.orientation.{axis}": 0.0 * time, f"hull.position.{axis}": 0.0 * time}
    for floats in (1.0, 0.0):
        # Half of the mass is lifted by twice its weight.
        path.write_text(
            "<mujoco model='buoy'><worldbody><body name='hull'><freejoint/>"
            "<inertial pos='0 0 0' mass='1' diaginertia='.1 .1 .1'/>"
            f"<body name='foam' pos='0 0 .1' gravcomp='{2.0 * floats}'>"
            "<inertial pos='0 0 0' mass='1' diaginertia='.1 .1 .1'/></body>"
            "</body></worldbody></mujoco>"
        )
        channels = {name: Channel(time=time, value=value) for name, value in still.items()}
        robot, run = load(path), Recording(name="run", channels=channels)
        with nullcontext() if floats else pytest.raises(DiagnosisError, match="does not fall"):
            check_falls([episode(run, robot, 0.005)], robot)
