from __future__ import annotations

import os
import signal
import threading
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from morph.arrays import Array
from morph.errors import SearchError, TransferError, TrialStopped
from morph.policy.linear import Linear
from morph.policy.observing import observations_of
from morph.policy.policy import actions_of
from morph.policy_transfer.live import callable_target
from morph.policy_transfer.live.callable_target import Called, Paced, Step
from morph.policy_transfer.live.limits import Limits
from morph.policy_transfer.live.live import Live
from morph.policy_transfer.live.stop import Stop
from morph.policy_transfer.live.watch import Watch
from morph.policy_transfer.live.wiring import hello_for
from morph.task.task import UNSTABLE, Task

PUSH = np.full((10, 1), 1.0)
QUICK = Watch(answer_within=0.2, begin_within=0.2, stop_within=0.2)


def live(swing: Task, step: Step, stopped: object = lambda: None, **more: object) -> Live:
    connection = Called(step, hello_for(swing.robot, swing.period), stopped=stopped)  # type: ignore[arg-type]
    return Live(swing, connection, **{"watch": QUICK, **more})  # type: ignore[arg-type]


def wrapped(cart: Step, at: int, what: object) -> Step:
    """Return the cart, with something else happening at one call."""
    count = [0]

    def step(command: Array | None) -> Mapping[str, float]:
        count[0] += 1
        reading = cart(command)
        return what(reading) if count[0] == at else reading  # type: ignore[operator,no-any-return]

    return step


def test_a_function_is_driven_as_it_moves_in_closed_form(swing: Task, cart: Step) -> None:
    target = live(swing, cart, cart.stop)  # type: ignore[attr-defined]
    shown = target.trial(PUSH, np.random.default_rng(0))
    time_ = 0.05 * np.arange(11)
    # 1 N on 1 kg: t^2 / 2, and t; the readings' noise is 1e-6.
    np.testing.assert_allclose(shown.position[:, 0], 0.5 * time_**2, atol=1e-5)
    np.testing.assert_allclose(shown.velocity[:, 0], time_, atol=1e-5)
    np.testing.assert_array_equal(shown.command, PUSH)
    assert not shown.success
    assert cart.stops == 1  # type: ignore[attr-defined]
    assert target.conduct is not None
    assert (target.conduct.stopped, target.conduct.safe) == ("", True)


def test_a_policy_sees_the_readings_that_are_recorded(swing: Task, cart: Step) -> None:
    gain = np.array([[-3.0, 0.0, -2.0, 0.0]])
    policy = Linear(
        action=actions_of(swing.robot),
        observation=observations_of(swing.robot),
        period=swing.period,
        weight=gain,
        bias=np.array([2.0]),
    )
    shown = live(swing, cart).trial(policy, np.random.default_rng(0))
    seen = np.concatenate([shown.position, shown.velocity], axis=1)[:-1]
    np.testing.assert_allclose(shown.command, seen @ gain.T + 2.0, atol=1e-12)


def test_a_function_that_hangs_is_stopped_in_time_and_what_it_showed_is_kept(
    swing: Task, cart: Step
) -> None:
    release = threading.Event()
    hangs = wrapped(cart, 5, lambda reading: release.wait(600.0) and reading)
    target = live(swing, hangs, cart.stop)  # type: ignore[attr-defined]
    with pytest.raises(TrialStopped, match=r"stopped answering: no state came within 0.2") as error:
        target.trial(PUSH, np.random.default_rng(0))
    release.set()
    assert cart.stops == 1  # type: ignore[attr-defined]
    shown = error.value.shown
    assert (len(shown.position), len(shown.command)) == (4, 3)
    assert (shown.loss, shown.success) == (UNSTABLE, False)


def test_a_stop_that_does_not_come_back_is_said(swing: Task, cart: Step) -> None:
    never = threading.Event()
    target = live(swing, cart, lambda: never.wait(20.0))
    target.trial(PUSH, np.random.default_rng(0))
    never.set()
    assert target.conduct is not None
    assert not target.conduct.safe
    assert target.conduct.notes[-1] == "it did not say that it stopped, and was let go"
    # The next trial speaks with it anew.
    assert len(target.trial(PUSH, np.random.default_rng(0)).position) == 11


def fails(reading: Mapping[str, float]) -> Mapping[str, float]:
    raise OSError("no such bus")


@pytest.mark.parametrize(
    ("what", "says"),
    [
        (fails, r"it raised OSError: no such bus"),
        (lambda r: {**r, "hinge.position": float("nan")}, r"hinge.position is no finite number"),
        (lambda r: {k: v for k, v in r.items() if k[0] == "s"}, r"hinge.position, hinge.velocity"),
        (lambda r: {**r, "slide.position": "far"}, r"slide.position is no finite number"),
        (lambda r: None, r"it raised TypeError"),
        (lambda r: {**r, "t": float("inf")}, r"its state says no time"),
    ],
)
def test_a_reading_that_is_none_ends_the_trial(
    swing: Task, cart: Step, what: object, says: str
) -> None:
    with pytest.raises(TrialStopped, match=says) as error:
        live(swing, wrapped(cart, 4, what), cart.stop).trial(PUSH, np.random.default_rng(0))  # type: ignore[attr-defined]
    assert cart.stops == 1  # type: ignore[attr-defined]
    assert not error.value.pressed
    assert not error.value.beyond


def test_commands_are_held_within_bounds_and_rates_and_recorded_as_sent(
    swing: Task, cart: Step
) -> None:
    limits = Limits(rate={"slide": 40.0}, command={"slide": (-5.0, 5.0)})
    target = live(swing, cart, limits=limits)
    shown = target.trial(100.0 * PUSH, np.random.default_rng(0))
    # 2 N more each period, up to 5 N; every one of ten commands was held back.
    told = [2.0, 4.0, *[5.0] * 8]
    assert shown.command[:, 0].tolist() == told == cart.told  # type: ignore[attr-defined]
    assert target.conduct is not None
    assert target.conduct.clipped == 10


def test_a_body_beyond_its_limits_is_stopped(swing: Task, cart: Step) -> None:
    limits = Limits(speed={"slide": 0.22})
    with pytest.raises(TrialStopped, match=r"slide moves at 0.25 m/s, beyond its") as error:
        live(swing, cart, limits=limits).trial(PUSH, np.random.default_rng(0))
    # 1 m/s2: 0.25 m/s after five periods, the sixth state, which is kept.
    assert len(error.value.shown.position) == 6
    assert error.value.beyond


def test_a_command_that_is_no_number_is_never_sent(swing: Task, cart: Step) -> None:
    told = np.array([[1.0], [np.nan]])
    with pytest.raises(TrialStopped, match=r"the policy commands \[nan\]"):
        live(swing, cart).trial(told, np.random.default_rng(0))
    assert cart.told == [1.0]  # type: ignore[attr-defined]


def test_a_trial_that_begins_elsewhere_is_refused(swing: Task, cart: Step) -> None:
    elsewhere = wrapped(cart, 1, lambda reading: {**reading, "hinge.position": 0.3})
    with pytest.raises(TrialStopped, match=r"hinge begins 0.3 rad and [-\de.]+ rad/s from where"):
        live(swing, elsewhere).trial(PUSH, np.random.default_rng(0))
    # A pole that was counted round once hangs all the same.
    turned = wrapped(cart, 1, lambda reading: {**reading, "hinge.position": 2.0 * np.pi})
    assert len(live(swing, turned).trial(PUSH, np.random.default_rng(0)).position) == 11


def test_a_velocity_in_another_unit_than_its_position_is_noticed(swing: Task, cart: Step) -> None:
    def degrees(command: Array | None) -> Mapping[str, float]:
        reading = dict(cart(command))
        return {**reading, "slide.velocity": reading["slide.velocity"] * 1000.0}

    target = live(swing, degrees)
    target.trial(PUSH, np.random.default_rng(0))
    assert target.conduct is not None
    # The cart moves 0.125 m, and 1 mm/s is 0.001 m/s.
    assert target.conduct.notes[0].startswith("slide.position changes by 0.001 times slide.vel")


@pytest.mark.parametrize("by", ["function", "file", "SIGINT", "SIGTERM"])
def test_the_button_stops_the_target_whoever_presses_it(
    swing: Task, cart: Step, tmp_path: Path, by: str
) -> None:
    button = tmp_path / "stop"

    def press(reading: Mapping[str, float]) -> Mapping[str, float]:
        if by.startswith("SIG"):
            os.kill(os.getpid(), getattr(signal, by))
        button.touch()
        return reading

    handlers = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    pressed = button.exists if by == "function" else button if by == "file" else None
    step = wrapped(cart, 4, press)
    target = live(swing, step, cart.stop, stop=Stop(pressed))  # type: ignore[attr-defined]
    with pytest.raises(TrialStopped, match=r"the stop button was pressed by") as error:
        target.trial(PUSH, np.random.default_rng(0))
    assert error.value.pressed
    assert cart.stops == 1  # type: ignore[attr-defined]
    # The state that came as it was pressed may be taken or not.
    assert len(error.value.shown.position) in {3, 4, 5}
    assert [signal.getsignal(n) for n in (signal.SIGINT, signal.SIGTERM)] == handlers


def test_an_error_of_a_policy_leaves_no_target_moving(swing: Task, cart: Step) -> None:
    class Broken(Linear):
        def act(self, observation: Array, time: Array) -> Array:
            raise ZeroDivisionError

    policy = Broken(
        action=actions_of(swing.robot),
        observation=observations_of(swing.robot),
        period=swing.period,
        weight=np.zeros((1, 4)),
        bias=np.zeros(1),
    )
    with pytest.raises(ZeroDivisionError):
        live(swing, cart, cart.stop).trial(policy, np.random.default_rng(0))  # type: ignore[attr-defined]
    assert cart.stops == 1  # type: ignore[attr-defined]


def test_reading_and_writing_are_paced_and_overruns_are_counted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now, slept, written = [100.0], list[float](), list[float]()

    def sleep(seconds: float) -> None:
        slept.append(seconds)
        now[0] += seconds

    def write(command: Array) -> None:
        written.append(float(command[0]))
        # The third command takes more than four periods to write, every other one half a period.
        now[0] += 1.0625 if len(written) == 3 else 0.125

    monkeypatch.setattr(callable_target.time, "monotonic", lambda: now[0])
    monkeypatch.setattr(callable_target.time, "sleep", sleep)
    paced = Paced(lambda: {"slide.position": float(len(written))}, write, 0.25)
    times = [paced(None if at == 0 else np.array([float(at)]))["t"] for at in range(11)]
    assert written == [float(at) for at in range(1, 11)]
    # A float holds all these fractions of a second exactly. Reading 3 is due at 0.75 s and comes at
    # 0.5 + 1.0625; those after it come every 0.125 s; the tenth, due at 2.5, is early again.
    late = [1.5625 + 0.125 * more for more in range(7)]
    assert times == [0.0, 0.25, 0.5, *late, 2.5]
    assert slept == [0.125, 0.125, 0.0625]
    assert paced.overruns == 7


def test_a_paced_target_is_watched_by_its_clock(swing: Task, cart: Step) -> None:
    state = dict(cart(None))

    def write(command: Array) -> None:
        state.update(cart(command))

    quick = replace(swing, period=0.05)
    hello = replace(hello_for(swing.robot, 0.05), clock="target")
    step = Paced(lambda: dict(state), write, 0.05)
    target = Live(quick, Called(step, hello, stopped=lambda: None))
    shown = target.trial(PUSH, np.random.default_rng(0))
    assert target.conduct is not None
    assert len(shown.position) == 11
    assert target.conduct.latest < 0.05


def test_a_period_of_a_policy_that_is_not_the_tasks_is_refused_before_anything_moves(
    swing: Task, cart: Step
) -> None:
    policy = Linear(
        action=actions_of(swing.robot),
        observation=observations_of(swing.robot),
        period=0.01,
        weight=np.zeros((1, 4)),
        bias=np.zeros(1),
    )
    with pytest.raises(SearchError, match=r"every 0.01 s"):
        live(swing, cart).trial(policy, np.random.default_rng(0))
    assert cart.told == []  # type: ignore[attr-defined]


def test_another_body_is_refused_before_anything_moves(swing: Task, cart: Step) -> None:
    hello = replace(hello_for(swing.robot, swing.period), actuators=())
    with pytest.raises(TransferError, match=r"no actuator 'slide'"):
        Live(swing, Called(cart, hello, stopped=lambda: None)).trial(PUSH, np.random.default_rng(0))
    assert cart.told == []  # type: ignore[attr-defined]
