"""Recordings against simulations whose difference is known beforehand."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from morph.app.viewer.mismatch.arrows import scale_of, wrenches
from morph.app.viewer.mismatch.case import MismatchCase
from morph.app.viewer.mismatch.diagnosed import load_diagnosed
from morph.app.viewer.mismatch.freedoms import axes
from morph.app.viewer.mismatch.heat import by_error, by_force, forces
from morph.app.viewer.mismatch.missing import clearest
from morph.app.viewer.mismatch.window import CORRECTED, DESCRIBED, Ask
from morph.app.viewer.mismatch.windows import windows
from morph.app.viewer.motion import RATE
from morph.body.load import load
from morph.body.robot import Robot
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.physics.joint.viscous_friction import ViscousFriction
from morph.physics.worlds import world
from morph.record.recording import Channel, Recording
from morph.sim.simulator import Simulator

RUBBING = CoulombFriction(joint="hinge", c=0.2)
OPEN = Ask(horizon=None)
EACH_SECOND = Ask(horizon=1.0)


def without(recording: Recording, *names: str) -> Recording:
    kept = {name: each for name, each in recording.channels.items() if name not in names}
    return replace(recording, channels=kept)


def test_where_nothing_is_missing_the_ghost_stays_with_the_recording(
    pendulum: Robot, swung: Callable[..., Recording]
) -> None:
    take = MismatchCase(pendulum, (swung(),)).take(EACH_SECOND)
    # Starts are read off smoothed motion: 15 Hz let through of motion below 1 Hz, and a step of
    # 4 ms against the recording's 2 ms; friction of 0.2 N m costs 0.1 rad in the same second.
    assert take.traces[0].rmse[DESCRIBED] < 2e-3
    assert np.abs(take.simulated[DESCRIBED] - take.measured).max() < 6e-3


def test_hidden_friction_is_the_force_that_is_missing(
    pendulum: Robot, swung: Callable[..., Recording]
) -> None:
    run = swung(RUBBING)
    missed = MismatchCase(pendulum, (run,)).take(EACH_SECOND).missing[DESCRIBED]
    speed = run.channel("hinge.velocity").at(missed.time)
    fast = np.abs(speed) > 0.8
    # -c sign(v), a square wave: smoothed, it rings by up to a quarter beside its edges, and the
    # mean away from them keeps its level.
    assert fast.mean() > 0.2
    assert np.allclose(missed.force[fast, 0], -0.2 * np.sign(speed[fast]), atol=0.05)
    assert np.mean(-missed.force[fast, 0] * np.sign(speed[fast])) == pytest.approx(0.2, rel=0.05)


def test_a_command_that_was_not_recorded_is_missing_as_a_constant_torque(pendulum: Robot) -> None:
    run = Simulator(pendulum).run(seconds=6.0, start={"hinge": 0.6}, command={"hinge": 0.3})
    case = MismatchCase(pendulum, (without(run, "hinge.command"),))
    take = case.take(EACH_SECOND)
    missed = take.missing[DESCRIBED]
    # The motion is a swing of 0.7 Hz seen through a filter of 3 Hz, which makes up a tenth of the
    # torque near the ends; a second from them, a fortieth.
    assert np.allclose(missed.force, 0.3, atol=0.03)
    middle = (missed.time > 1.4) & (missed.time < 4.6)
    assert np.allclose(missed.force[middle], 0.3, atol=0.0075)
    assert any("no command was recorded of hinge" in note for note in take.notes)
    scale = scale_of(case.figure, take)
    assert scale is not None
    arrows = wrenches(case.figure, take, DESCRIBED, scale)
    anchor, axis = axes(case.figure.model, case.figure.robot, take.measured)
    known = np.isfinite(arrows).all(axis=(1, 2, 3))
    assert known.mean() > 0.8
    # A torque along the hinge's axis, from its anchor, as long as the note says.
    assert np.allclose(arrows[known, 0, 0], anchor[known, 0])
    along = ((arrows[known, 0, 1] - arrows[known, 0, 0]) * axis[known, 0]).sum(axis=1)
    assert np.allclose(along / scale.metres["N m"], 0.3, atol=0.03)


def test_the_measured_effort_of_a_motor_stands_in_for_its_command(
    pendulum: Robot, swung: Callable[..., Recording]
) -> None:
    run = swung()
    told = run.channel("hinge.command")
    measured = Channel(time=told.time, value=told.value)
    channels = {**without(run, "hinge.command").channels, "hinge.effort": measured}
    take = MismatchCase(pendulum, (replace(run, channels=channels),)).take(EACH_SECOND)
    assert take.traces[0].rmse[DESCRIBED] < 2e-3
    assert any("the effort measured at its joint is taken" in note for note in take.notes)


def test_the_corrected_model_takes_the_error_away(
    pendulum: Robot, swung: Callable[..., Recording], diagnosis_of: Callable[..., Path]
) -> None:
    diagnosed = load_diagnosed(diagnosis_of(pendulum, RUBBING), pendulum)
    case = MismatchCase(pendulum, (swung(RUBBING),), diagnosed)
    take = case.take(EACH_SECOND)
    errors = take.traces[0].rmse
    assert errors[DESCRIBED] > 0.02
    assert errors[CORRECTED] < 0.1 * errors[DESCRIBED]
    size = {name: np.sqrt(np.mean(each.force**2)) for name, each in take.missing.items()}
    # Friction that fades within 2 % of typical speed smooths less than a sign: a third is left.
    assert size[CORRECTED] < 0.5 * size[DESCRIBED]


def test_a_restarted_ghost_meets_the_recording_at_every_restart(
    pendulum: Robot, swung: Callable[..., Recording]
) -> None:
    take = MismatchCase(pendulum, (swung(RUBBING),)).take(EACH_SECOND)
    apart = np.abs(take.simulated[DESCRIBED] - take.measured)[:, 0]
    # Rollouts start 0.15 s into a run, then every second: one picture later they are still near.
    starts = [int(np.ceil((0.15 + second) * RATE)) for second in range(5)]
    assert apart[starts].max() < 5e-3
    assert apart.max() > 0.05


def test_an_open_loop_is_never_put_back(pendulum: Robot, swung: Callable[..., Recording]) -> None:
    case = MismatchCase(pendulum, (swung(RUBBING),))
    take, restarted = case.take(OPEN), case.take(EACH_SECOND)
    jumps = np.abs(np.diff(take.simulated[DESCRIBED][:, 0])).max()
    # 5 rad/s at most is 0.09 rad a picture.
    assert jumps < 0.09
    assert take.traces[0].rmse[DESCRIBED] > restarted.traces[0].rmse[DESCRIBED]


def test_a_run_shorter_than_the_horizon_is_not_restarted_and_says_so(
    pendulum: Robot, swung: Callable[..., Recording]
) -> None:
    take = MismatchCase(pendulum, (swung(seconds=0.8),)).take(EACH_SECOND)
    assert take.horizon is None
    assert any("less than 1 s" in note for note in take.notes)


def test_a_run_too_short_to_be_diagnosed_is_still_shown(
    pendulum: Robot, swung: Callable[..., Recording]
) -> None:
    take = MismatchCase(pendulum, (swung(seconds=0.3),)).take(EACH_SECOND)
    assert take.missing == {}
    assert len(take.measured) == 19
    assert any("it lasts 0.3 s" in note for note in take.notes)


def test_full_red_is_where_the_description_is_at_its_worst(
    pendulum: Robot, swung: Callable[..., Recording]
) -> None:
    case = MismatchCase(pendulum, (swung(RUBBING),))
    take = case.take(EACH_SECOND)
    heat = by_error(case.figure, take, DESCRIBED)
    assert heat is not None
    link = case.figure.links.index(pendulum.joints[0].link)
    # One picture of twenty is at full red, for that is how it is defined.
    assert np.mean(heat.share[:, link] >= 1.0) == pytest.approx(0.05, abs=0.01)
    assert (heat.share[:, 0] == 0.0).all()
    force = by_force(case.figure, take, DESCRIBED)
    assert force is not None
    assert force.full["N m"] == pytest.approx(0.2, abs=0.05)


def test_a_finding_leads_to_where_its_force_is_missing(pendulum: Robot) -> None:
    # Dragged from 3 to 5 s by a torque against its motion that nobody recorded.
    def pushed(t: np.ndarray) -> np.ndarray:
        return 1.0 * np.sin(2 * np.pi * 0.8 * t)

    free = Simulator(pendulum).run(seconds=3.0, start={"hinge": 0.5}, command={"hinge": pushed})
    dragged = Simulator(pendulum, (ViscousFriction(joint="hinge", b=0.3),)).run(
        seconds=2.0,
        start={"hinge": float(free["hinge.position"][-1])},
        speed={"hinge": float(free["hinge.velocity"][-1])},
        command={"hinge": lambda t: pushed(t + 3.0)},
    )
    after = Simulator(pendulum).run(
        seconds=3.0,
        start={"hinge": float(dragged["hinge.position"][-1])},
        speed={"hinge": float(dragged["hinge.velocity"][-1])},
        command={"hinge": lambda t: pushed(t + 5.0)},
    )
    channels = {}
    for name in ("hinge.position", "hinge.command"):
        parts = [(0.0, free), (3.0, dragged), (5.0, after)]
        time = np.concatenate([at + run.channel(name).time[1:] for at, run in parts])
        value = np.concatenate([run[name][1:] for _, run in parts])
        channels[name] = Channel(time=time, value=value, hold=name.endswith("command"))
    case = MismatchCase(pendulum, (Recording(name="dragged", channels=channels),))
    found = ViscousFriction(joint="hinge", b=0.3)
    episode, _ = case.laid(0)
    assert episode is not None
    from morph.app.viewer.mismatch.missing import missing

    missed = missing(case.models[0], episode, [found])
    when = clearest(missed, found.label, "hinge", pendulum)
    assert when is not None
    assert 3.0 < when < 5.0


def test_windows_are_all_of_a_recording_and_none_is_a_sliver() -> None:
    for seconds in (0.7, 12.0, 24.9, 25.1, 40.0, 75.0, 204.6):
        found = windows(seconds)
        assert found[0][0] == 0.0
        assert found[-1][1] == seconds
        assert all(one[1] == other[0] for one, other in itertools.pairwise(found))
        assert all(end - begin >= min(seconds, 5.0) for begin, end in found)
        assert all(end - begin <= 25.0 for begin, end in found)


def test_a_window_holds_what_the_whole_holds_there(
    pendulum: Robot, swung: Callable[..., Recording]
) -> None:
    case = MismatchCase(pendulum, (swung(seconds=30.0),))
    assert [round(end) for _, end in case.windows(0)] == [20, 30]
    whole, _ = case.laid(0)
    assert whole is not None
    take = case.take(Ask(window=1, horizon=None))
    assert take.start == 20.0
    assert take.seconds == pytest.approx(10.0, abs=0.01)
    run = case.recordings[0]
    assert take.measured[60, 0] == pytest.approx(float(run.channel("hinge.position").at(21.0)))


def test_a_joint_that_was_not_measured_rests_and_is_named() -> None:
    robot = load("double_pendulum")
    run = Simulator(robot).run(seconds=2.0, start={"shoulder": 0.4, "elbow": 0.3})
    take = MismatchCase(robot, (without(run, "elbow.position"),)).take(OPEN)
    assert (take.measured[:, 1] == 0.0).all()
    assert np.ptp(take.measured[:, 0]) > 0.1
    assert any("elbow" in note for note in take.notes)
    assert [trace.channel for trace in take.traces] == ["shoulder.position"]
    assert take.missing == {}


def test_a_tracked_body_and_its_ghost_float_as_recorded() -> None:
    robot = load("hexapod_swimmer")
    water = world("water", robot).effects
    run = Simulator(robot, water).run(
        seconds=1.0,
        start={"left_front": 0.5},
        speed={"hull.linear_velocity.x": 0.3},
        command={"left_front": 0.0},
    )
    case = MismatchCase(robot, (run,), around=water)
    # A rollout from 0.15 s on: smoothing rounds the fin's release, 0.02 rad.
    take = case.take(Ask(horizon=0.6))
    x = int(case.figure.model.joint("root").qposadr[0])
    # Sixty pictures a second, the last at 1 s; both by steps of 2 ms.
    assert take.measured[-1, x] == pytest.approx(run["hull.position.x"][-1], abs=1e-6)
    assert take.measured[-1, x] > 0.1
    assert not np.array_equal(take.simulated[DESCRIBED], take.measured)
    assert {trace.link for trace in take.traces} == {joint.link for joint in robot.joints}
    assert np.allclose(take.simulated[DESCRIBED], take.measured, atol=1e-3)


def test_the_pictures_of_forces_are_unknown_where_smoothing_makes_them_up(
    pendulum: Robot, swung: Callable[..., Recording]
) -> None:
    take = MismatchCase(pendulum, (swung(RUBBING),)).take(EACH_SECOND)
    found = forces(take, DESCRIBED, len(take.measured))
    assert np.isnan(found[0]).all()
    assert np.isnan(found[-1]).all()
    assert np.isfinite(found[len(found) // 2]).all()


def test_what_is_bolted_to_the_world_is_drawn_once(
    pendulum: Robot, swung: Callable[..., Recording]
) -> None:
    case = MismatchCase(pendulum, (swung(),))
    assert any(shape.body == 0 for shape in case.figure.shapes)
    assert {shape.body for shape in case.ghost.shapes} == {1}


def test_the_stretches_of_a_run_whose_end_was_held_out_lie_in_its_last_quarter(
    pendulum: Robot, swung: Callable[..., Recording], diagnosis_of: Callable[..., Path]
) -> None:
    where = {"episode": "run from 5.8 s", "recording": "run", "begin_s": 5.8}
    times = [{**where, "start_s": 0.4, "end_s": 1.4, "share": 0.6}]
    located = {"channels": [], "states": "", "times": times}
    fit = {"horizon_s": 1.0, "train": ["run"], "held_out": ["run"], "split": "by time"}
    folder = diagnosis_of(pendulum, RUBBING, located=located, fit=fit)
    case = MismatchCase(pendulum, (swung(RUBBING, seconds=8.0),), load_diagnosed(folder, pendulum))
    # The last quarter of 8 s begins at 6 s.
    assert case.unseen_from(0) == pytest.approx(6.0, abs=0.003)
    assert case.take(EACH_SECOND).worst[0] == pytest.approx((6.2, 7.2), abs=0.003)


def test_a_long_gap_in_a_log_is_told(pendulum: Robot, swung: Callable[..., Recording]) -> None:
    run = swung(RUBBING)
    angle = run.channel("hinge.position")
    kept = (angle.time < 2.0) | (angle.time > 4.0)
    holed = Channel(time=angle.time[kept], value=angle.value[kept])
    channels = {**run.channels, "hinge.position": holed}
    take = MismatchCase(pendulum, (replace(run, channels=channels),)).take(EACH_SECOND)
    assert any(note.startswith("There is no reading for 2") for note in take.notes)
