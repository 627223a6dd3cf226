from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from morph.body.load import load
from morph.body.robot import Robot
from morph.errors import RobotError, SimulationFailed
from morph.physics.joint.joint_stiffness import JointStiffness
from morph.record.recording import Channel
from morph.sim.simulator import Simulator


@pytest.fixture(scope="module")
def pendulum() -> Robot:
    return load("pendulum")


def test_a_run_records_every_joint_and_what_was_commanded() -> None:
    run = Simulator(load("cartpole")).run(seconds=0.1, command={"slide": 0.5}, name="push")
    assert run.name == "push"
    assert set(run.channels) == {
        "slide.command",
        "slide.position",
        "slide.velocity",
        "hinge.position",
        "hinge.velocity",
    }
    # Only a command holds until the next one.
    assert [name for name, channel in run.channels.items() if channel.hold] == ["slide.command"]
    # 0.1 s at 2 ms: 50 steps, 51 states, each command half a step before its step: it carries the
    # velocity from there to half a step after.
    assert run.channel("hinge.position").time == pytest.approx(0.002 * np.arange(51), abs=1e-15)
    given = np.maximum(0.002 * np.arange(50) - 0.001, 0.0)
    assert run.channel("slide.command").time == pytest.approx(given, abs=1e-15)
    assert np.array_equal(run["slide.command"], np.full(50, 0.5))


def test_commands_are_stamped_when_they_act(tmp_path: Path) -> None:
    # A mass without friction under f(t) = sin(w t), each value held for a step: x'' = f / m. The
    # mean of a command over its step is that of the middle, where it is told.
    path = tmp_path / "cart.xml"
    path.write_text(
        '<mujoco><worldbody><body name="cart"><joint name="x" type="slide" axis="1 0 0"/>'
        '<geom size="0.1" mass="2"/></body></worldbody>'
        '<actuator><motor name="motor" joint="x"/></actuator></mujoco>'
    )
    rate, step = 9.0, 0.002
    made = Simulator(load(path), step=step, integrator="implicitfast").run(
        seconds=1.0, command={"motor": lambda t: np.sin(rate * t)}
    )
    told = made.channel("motor.command")
    # Exactly: the position after time t under commands that hold from their stamps on.
    edges = np.r_[told.time[1:], told.time[-1] + step]
    force, spans = told.value / 2.0, edges - np.r_[told.time[0], told.time[1:]]
    speed = np.cumsum(force * spans)
    before = np.r_[0.0, speed[:-1]]
    place = np.cumsum(before * spans + 0.5 * force * spans**2)
    exact = np.interp(made.channel("x.position").time[1:-1], edges, place)
    # Linear interpolation between edges errs by a h^2 / 8 = 2.5e-7 m; half a step late, by the
    # speed, 0.1 m/s, times 1 ms.
    assert np.abs(made["x.position"][1:-1] - exact).max() < 1e-6


def test_a_run_starts_where_it_is_told() -> None:
    run = Simulator(load("cartpole")).run(
        seconds=0.1, start={"hinge": 0.3, "slide": -0.1}, speed={"slide": 0.7}
    )
    first = {name: channel.value[0] for name, channel in run.channels.items()}
    assert first == {
        "hinge.position": 0.3,
        "hinge.velocity": 0.0,
        "slide.position": -0.1,
        "slide.velocity": 0.7,
    }


def test_a_pendulum_swings_with_the_period_of_paper_and_pencil(pendulum: Robot) -> None:
    run = Simulator(pendulum, step=0.0005).run(seconds=10.0, start={"hinge": 1.0})
    channel = run.channel("hinge.position")
    up = np.flatnonzero((channel.value[:-1] < 0.0) & (channel.value[1:] >= 0.0))
    passed = channel.time[up] - channel.value[up] * 0.0005 / np.diff(channel.value)[up]
    # T = 2 pi sqrt(I / m g l) / agm(1, cos(1 rad / 2)), Gauss 1799; I = 0.251 kg m2.
    one, other = 1.0, float(np.cos(0.5))
    for _ in range(6):
        one, other = 0.5 * (one + other), float(np.sqrt(one * other))
    due = 2.0 * np.pi * np.sqrt(0.251 / 4.905) / one
    # The leapfrog errs by (w h)^2 / 24 = 2e-7.
    assert np.diff(passed).mean() == pytest.approx(due, rel=1e-6)


def test_a_recorded_command_and_a_function_of_time_are_alike(pendulum: Robot) -> None:
    time = 0.002 * np.arange(100)
    recorded = Channel(time=time, value=np.sin(9.0 * time), hold=True)
    simulator = Simulator(pendulum)
    by_channel = simulator.run(seconds=0.2, command={"hinge": recorded})
    by_function = simulator.run(seconds=0.2, command={"hinge": lambda t: np.sin(9.0 * t)})
    assert np.array_equal(by_channel["hinge.position"], by_function["hinge.position"])


@pytest.mark.parametrize(
    ("told", "what"),
    [
        ({"start": {"knee": 0.1}}, "there is no joint 'knee'; there are hinge"),
        ({"speed": {"knee": 0.1}}, "there is no joint 'knee'; there are hinge"),
        ({"command": {"knee": 0.1}}, "there is no actuator 'knee'; there are hinge"),
    ],
)
def test_a_name_that_is_not_the_robots_is_refused(
    pendulum: Robot, told: dict[str, dict[str, float]], what: str
) -> None:
    with pytest.raises(RobotError, match=what) as caught:
        Simulator(pendulum).run(seconds=0.1, **told)  # type: ignore[arg-type]
    assert caught.value.where == "robot pendulum"
    assert caught.value.fix.startswith("name one of these")


def test_an_unstable_run_is_refused(
    pendulum: Robot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # MuJoCo may write its own log into the working folder.
    monkeypatch.chdir(tmp_path)
    # w h = sqrt(200 / 0.251) * 0.2 = 5.6, and a leapfrog is stable only below 2.
    spring = JointStiffness(joint="hinge", k=200.0)
    simulator = Simulator(pendulum, effects=(spring,), step=0.2)
    with pytest.raises(SimulationFailed, match="became unstable") as caught:
        simulator.run(seconds=20.0, start={"hinge": 1.0})
    assert caught.value.where == "100 steps of 0.2 s"
    assert "smaller step" in caught.value.fix


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_start_that_is_no_number_is_refused(
    pendulum: Robot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, value: float
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SimulationFailed):
        Simulator(pendulum).run(seconds=0.1, start={"hinge": value})


@pytest.mark.parametrize("step", [0.0, -0.1, np.nan])
def test_a_step_that_is_no_step_is_refused(pendulum: Robot, step: float) -> None:
    with pytest.raises(SimulationFailed):
        Simulator(pendulum, step=step).run(seconds=0.1)


@pytest.mark.parametrize("seconds", [-1.0, np.nan, np.inf])
def test_a_run_of_no_length_is_refused(pendulum: Robot, seconds: float) -> None:
    with pytest.raises(SimulationFailed):
        Simulator(pendulum).run(seconds=seconds)


@pytest.mark.parametrize("told", [np.nan, np.inf, lambda times: np.ones(3)])
def test_a_command_that_is_no_number_a_step_is_refused(
    pendulum: Robot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, told: object
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SimulationFailed):
        Simulator(pendulum).run(seconds=0.1, command={"hinge": told})  # type: ignore[dict-item]


def test_an_unstable_run_leaves_no_log_and_says_nothing_itself(
    pendulum: Robot,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SimulationFailed):
        Simulator(pendulum).run(seconds=0.1, start={"hinge": np.nan})
    assert list(tmp_path.iterdir()) == []
    assert capfd.readouterr() == ("", "")
