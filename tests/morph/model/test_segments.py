from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from morph.body.load import load
from morph.body.robot import Robot
from morph.errors import DiagnosisError, RecordingError
from morph.inference.observed import _sampled
from morph.model.episodes import Episode, episode, longest_step, step_for
from morph.model.hypothesis import Hypothesis
from morph.model.pieces import stretches
from morph.model.segments import cut
from morph.model.shooting import predict
from morph.physics.sensor.sensor_scale import SensorScale
from morph.record.recording import Channel, Recording

Recorded = Callable[..., Recording]


@pytest.fixture(scope="module")
def episodes(cartpole: Robot, recorded: Recorded) -> list[Episode]:
    """Episodes of 4.2 s and 2.7 s at 200 Hz."""
    runs = [
        recorded(cartpole, seconds=seconds, start={"hinge": 1.0}, noise=0.0, name=name)
        for seconds, name in ((4.2, "long"), (2.7, "short"))
    ]
    step = step_for(runs, cartpole)
    return [episode(run, cartpole, step) for run in runs]


def test_a_step_is_a_whole_part_of_the_recordings_clock(
    pendulum: Robot, recorded: Recorded
) -> None:
    # 5 ms is more than the 4 ms that a motor asks for: two steps a sample.
    assert step_for([recorded(pendulum)], pendulum) == pytest.approx(0.0025, abs=1e-12)


def test_a_step_turns_the_fastest_link_by_a_twentieth_of_a_radian(
    recorded: Recorded,
) -> None:
    double_pendulum = load("double_pendulum")
    run = recorded(double_pendulum, seconds=1.0)
    laid = episode(run, double_pendulum, step_for([run], double_pendulum))
    # The links turn at 10 and at 10 + 15 rad/s: 0.05 rad take 2 ms.
    rate = np.tile([10.0, 15.0], (len(laid.velocity), 1))
    laid = replace(laid, velocity=rate)
    assert longest_step(double_pendulum, [laid]) == pytest.approx(0.002, rel=1e-9)
    # Of a run whose half is at 5 and half at 25 rad/s the mean square by squares is
    # (25^8 + 5^8) / (25^4 + 5^4), the fourth power of 24.99 rad/s.
    rate[::2] *= 0.2
    assert longest_step(double_pendulum, [laid]) == pytest.approx(0.0020008, rel=2e-3)


@pytest.mark.parametrize(("horizon", "counts"), [(1.0, (4, 2)), (0.5, (8, 5)), (2.0, (2, 1))])
def test_episodes_are_cut_end_to_end(
    episodes: list[Episode], horizon: float, counts: tuple[int, int]
) -> None:
    segments = cut(episodes, horizon)
    assert len(segments) == sum(counts)
    assert segments.steps * segments.step == pytest.approx(horizon, abs=1e-9)
    assert [int((segments.episode == index).sum()) for index in (0, 1)] == list(counts)
    for index in range(len(segments)):
        nth = int((segments.episode[:index] == segments.episode[index]).sum())
        due = (nth * horizon, (nth + 1) * horizon)
        assert segments.seconds(index) == pytest.approx(due, abs=1e-9)


@pytest.mark.parametrize(
    "seconds",
    [
        2.0,
        4.0,
    ],
)
def test_whole_seconds_are_cut_into_as_many_segments(
    pendulum: Robot, recorded: Recorded, seconds: float
) -> None:
    run = recorded(pendulum, seconds=seconds, start={"hinge": 1.0})
    step = step_for([run], pendulum)
    assert len(cut([episode(run, pendulum, step)], 1.0)) == seconds


def test_a_segment_holds_the_readings_after_its_start_up_to_its_end(
    episodes: list[Episode],
) -> None:
    segments = cut(episodes, 1.0)
    rows, readings, _ = segments.valid.shape
    # Readings are thinned to 100 Hz: 100 in a second.
    assert (rows, readings) == (6, 100)
    assert segments.reading.shape == (rows, readings, 2)
    assert segments.start.shape == (rows, 4)
    assert segments.start_trust.shape == (4,)
    for row in range(rows):
        e = episodes[segments.episode[row]]
        begin, end = segments.seconds(row)
        there = segments.valid[row].all(axis=1)
        when = begin + (segments.before[row] + segments.part[row])[there] * 0.0025
        inside = (e.time > begin + 1e-6) & (e.time < end + 1e-6)
        assert when == pytest.approx(e.time[inside], abs=1e-9)
        assert np.array_equal(segments.reading[row][there], e.reading[inside])
    assert segments.before.min() >= 0
    assert segments.before.max() < segments.steps
    assert segments.part.min() >= 0.0
    assert segments.part.max() <= 1.0 + 1e-9


def test_a_start_has_the_position_then_and_the_velocity_half_a_step_before(
    episodes: list[Episode],
) -> None:
    segments = cut(episodes, 1.0)
    e, half = episodes[0], 0.5 * segments.step
    for row in np.flatnonzero(segments.episode == 0):
        begin = segments.seconds(row)[0]
        when = [begin, begin, begin - half, begin - half]
        at = [np.interp(t, e.time, c) for t, c in zip(when, e.state.T, strict=True)]
        assert segments.start[row] == pytest.approx(at, abs=1e-12)


def test_each_segment_gets_its_part_of_its_own_command(episodes: list[Episode]) -> None:
    segments = cut(episodes, 1.0)
    # A command that says its own episode and step.
    told = [np.arange(len(e.command))[:, None] + 10_000.0 * k for k, e in enumerate(episodes)]
    parts = segments.command(told)
    assert parts.shape == (6, 400, 1)
    begin = 10_000.0 * segments.episode + 400 * np.array([0, 1, 2, 3, 0, 1])
    assert np.array_equal(parts[:, 0, 0], begin)
    assert np.array_equal(parts[:, -1, 0], begin + 399)


def test_of_many_segments_an_even_spread_is_kept(episodes: list[Episode]) -> None:
    segments = cut(episodes, 0.5, most=4)
    # 13 segments, 0 to 12: every fourth.
    assert segments.episode.tolist() == [0, 0, 1, 1]
    assert segments.first.tolist() == [0, 800, 0, 800]


def test_whole_episodes_are_cut_to_the_shortest(episodes: list[Episode]) -> None:
    segments = cut(episodes, None)
    assert segments.first.tolist() == [0, 0]
    assert segments.steps == min(len(e.command) for e in episodes)


def test_a_horizon_longer_than_every_episode_is_refused(episodes: list[Episode]) -> None:
    with pytest.raises(DiagnosisError, match="rollouts of 6 s are longer") as caught:
        cut(episodes, 6.0)
    assert caught.value.where == "long, short"
    assert "--horizon" in caught.value.fix


def test_a_channel_that_an_episode_lacks_is_named(pendulum: Robot, recorded: Recorded) -> None:
    run = recorded(pendulum)
    for missing in ("hinge.position", "hinge.command"):
        rest = {name: c for name, c in run.channels.items() if name != missing}
        with pytest.raises(RecordingError, match=f"there is no channel '{missing}'"):
            episode(Recording(name="run", channels=rest), pendulum, 0.0025)


def test_an_episode_of_less_than_half_a_second_is_refused(pendulum: Robot) -> None:
    time = 0.01 * np.arange(40)
    run = Recording(
        name="short",
        channels={
            "hinge.position": Channel(time=time, value=np.sin(time)),
            "hinge.command": Channel(time=time, value=0.0 * time, hold=True),
        },
    )
    with pytest.raises(DiagnosisError, match=r"it lasts 0\.39 s") as caught:
        episode(run, pendulum, 0.005)
    assert caught.value.where == "recording short"


def test_pieces_of_long_recordings_say_where_they_begin(
    pendulum: Robot, recorded: Recorded
) -> None:
    run = recorded(pendulum, seconds=31.0, start={"hinge": 1.0}, noise=0.0)
    whole = episode(run, pendulum, step_for([run], pendulum))
    # Two pieces of 5 s stand for 31 s: the first and the last.
    pieces = stretches([whole], 10.0)
    assert [piece.begin for piece in pieces] == pytest.approx([0.0, whole.time[-1] - 5.0], abs=0.01)
    assert [piece.name for piece in pieces] == [f"{run.name} from 0.0 s", f"{run.name} from 26.0 s"]
    for piece in pieces:
        assert piece.begin is not None
        # The readings and commands of a piece are those of the whole at that time.
        at = np.searchsorted(whole.time, piece.begin + piece.time - 1e-9)
        assert (piece.reading == whole.reading[at]).all()
        first = round(piece.begin / whole.step)
        assert (piece.command == whole.command[first : first + len(piece.command)]).all()
    assert stretches([whole], 40.0) == [whole]


def test_rollouts_of_a_scaled_sensor_start_at_the_truth(
    pendulum: Robot, recorded: Recorded
) -> None:
    scale = SensorScale(channel="hinge.position", gain=1.2)
    errors = []
    for effects in ((), (scale,)):
        run = recorded(pendulum, *effects, seconds=4.0, start={"hinge": 1.0}, noise=0.0)
        step = step_for([run], pendulum)
        segments = cut([episode(run, pendulum, step)], 1.0, skip=0.2)
        model = Hypothesis(robot=pendulum, step=step, knobs=(), effects=effects)
        (read,) = predict(model, segments, [model.start], [segments.start])
        errors.append(float(np.sqrt(np.mean((segments.reading - read)[segments.valid] ** 2))))
    # Smoothing errs alike in both, in proportion to what is read; a rate that is 1.2 times the true
    # one would turn the hinge by 0.2 rad in a second.
    assert errors[1] < 1.5 * 1.2 * errors[0]
    assert errors[0] < 0.01


def test_stretches_of_many_runs_share_no_reading(pendulum: Robot, recorded: Recorded) -> None:
    run = recorded(pendulum, seconds=7.0, start={"hinge": 1.0}, noise=0.0)
    whole = episode(run, pendulum, step_for([run], pendulum))
    runs = [replace(whole, recording=replace(run, name=f"run {at}")) for at in range(10)]
    found = stretches(runs, 60.0)
    # One stretch of 5 s of each: a second would share readings with the first.
    assert len({each.recording.name for each in found}) == len(found) == 10


def test_many_short_runs_are_not_all_left_out(pendulum: Robot) -> None:
    # 30 Hz and 0.6 s are 19 readings, of which a long run would tell too little.
    time = np.arange(0.0, 0.601, 1.0 / 30.0)
    channels = {
        "hinge.position": Channel(time=time, value=np.sin(time)),
        "hinge.command": Channel(time=time, value=0.0 * time),
    }
    run = Recording(name="short", channels=channels)
    whole = episode(run, pendulum, step_for([run], pendulum))
    assert len(stretches([whole] * 110, 60.0)) == pytest.approx(100, abs=5)


def test_joints_are_read_on_their_own_clocks() -> None:
    robot = load("double_pendulum")
    quick, slow = np.arange(0.0, 4.0, 0.01), 0.003 + np.arange(0.0, 3.9, 0.05)
    swing = {"shoulder": lambda t: np.sin(3.0 * t), "elbow": lambda t: np.cos(4.0 * t)}
    jumped = swing["shoulder"](quick)
    jumped[200] += 3.0
    channels = {
        "shoulder.position": Channel(time=quick, value=jumped),
        "elbow.position": Channel(time=slow, value=swing["elbow"](slow)),
    }
    still = Channel(time=quick, value=np.zeros(len(quick)))
    channels |= {f"{each.name}.command": still for each in robot.actuators}
    run = Recording(name="clocks", channels=channels)
    found = episode(run, robot, step_for([run], robot))
    # Every reading is one that was taken, at its time: none is interpolated; the jump is left out.
    begin = max(quick[0], slow[0])
    for at, (joint, clock) in enumerate((("shoulder", quick), ("elbow", slow))):
        there = found.valid[:, at]
        taken = clock[(clock >= begin) & (clock <= slow[-1])]
        taken = taken[taken != quick[200]]
        assert begin + found.time[there] == pytest.approx(taken, abs=1e-12)
        assert found.reading[there, at] == pytest.approx(swing[joint](taken), abs=1e-12)
    # A segment has the readings of both, none twice.
    segments = cut([found], 1.0)
    assert segments.valid.sum(axis=1).min(axis=0).tolist() == [99, 20]
    run_on_grid, _ = _sampled(found)
    for at, joint in enumerate(swing):
        samples = np.flatnonzero(run_on_grid.valid[:, at])
        time = begin + samples * found.step + run_on_grid.time_offset[samples, at]
        assert run_on_grid.reading[samples, at] == pytest.approx(swing[joint](time), abs=1e-9)


SERVO = """<mujoco><worldbody><body name="arm"><joint name="hinge" axis="0 1 0"/>
  <inertial pos="0 0 0.1" mass="0.1" diaginertia="1e-3 1e-3 1e-3"/></body></worldbody>
  <actuator><position name="servo" joint="hinge" kp="9"%s/></actuator></mujoco>"""


@pytest.mark.parametrize(("limit", "levels"), [(' forcerange="-1 1"', 2), ("", 4)])
def test_steps_begin_when_the_command_of_a_limited_servo_changes(
    tmp_path: Path, limit: str, levels: int
) -> None:
    (tmp_path / "arm.xml").write_text(SERVO % limit)
    robot, time = load(tmp_path / "arm.xml"), 0.01 * np.arange(200)
    # 280 steps of 2.5 ms lie between the changes, and neither falls on half a step.
    told = Channel(time=np.array([0.0, 0.5037, 1.2037]), value=np.array([0.0, 1.0, 0.0]), hold=True)
    read = Channel(time=time, value=np.sin(time))
    run = Recording(name="run", channels={"hinge.position": read, "servo.command": told})
    laid = episode(run, robot, 0.0025)
    assert len(np.unique(laid.command.round(9))) == levels
    # Where a step has a command's mean, two of them have one that is neither.
    assert abs(laid.begin) <= 0.00125
    assert (laid.begin == 0.0) == (not limit)
    edge = laid.begin - 0.00125
    if limit:
        assert (0.5037 - edge) / 0.0025 == pytest.approx(round((0.5037 - edge) / 0.0025), abs=1e-6)
