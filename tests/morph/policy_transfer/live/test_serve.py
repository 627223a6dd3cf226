"""The simulated target, as a process and within the test: both worlds must agree."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from morph.arrays import Array
from morph.errors import TransferError, TrialStopped
from morph.policy_transfer.live.live import Live
from morph.policy_transfer.live.pipe_lines import Reader
from morph.policy_transfer.live.process import Process
from morph.policy_transfer.live.recorded import Recorded
from morph.policy_transfer.live.serve import Serve, main, served
from morph.policy_transfer.live.watch import Watch
from morph.record.load import load_recordings
from morph.search.target import Experience
from morph.sim.closed_loop import closed_loop
from morph.task.moved import Moved
from morph.task.task import Task

PUSHES = 6.0 * np.sign(np.sin(0.7 * np.arange(60)))[:, None]


def within(asked: Serve) -> Process:
    """Return a connection to a served body that runs in a thread of this test."""
    process = Process(["within"], name="target")
    their_in, process._input = os.pipe()
    out, their_out = os.pipe()
    os.set_blocking(process._input, False)
    process._reader = Reader(out)

    def serve() -> None:
        served(asked).serve(their_in, their_out)
        os.close(their_out)

    thread = threading.Thread(target=serve, daemon=True)

    class Standing:
        """What stands for the process: it ends when its input does."""

        returncode = 0

        def poll(self) -> int | None:
            return None if thread.is_alive() else 0

        def wait(self, seconds: float | None = None) -> int:
            thread.join(seconds)
            return 0

        def terminate(self) -> None:
            """Nothing to end."""

        kill = terminate

    process._process = Standing()  # type: ignore[assignment]
    thread.start()
    process._hello = process._first(10.0)
    return process


@pytest.fixture
def targets() -> Iterator[list[Live]]:
    made: list[Live] = []
    yield made
    for each in made:
        each.close()


def simulated(whole: Task, seed: int, trial: int) -> tuple[Array, Array]:
    """Return what the served body must show, by another way through the simulator."""
    simulator = whole.simulator()
    rng = np.random.default_rng([seed, trial])
    position, velocity = whole.start.sample(whole.robot, simulator.model, 1, rng)
    noise = rng.normal(scale=whole.noise, size=(whole.samples, 4))
    loop = closed_loop(
        simulator,
        lambda q, v, time: PUSHES[None, round(time / whole.period)],
        position,
        velocity,
        period=whole.period,
        seconds=whole.horizon,
    )
    return loop.position[0] + noise[:, :2], loop.velocity[0] + noise[:, 2:]


def test_a_served_body_shows_what_the_simulator_shows_trial_after_trial(
    swing: Task, targets: list[Live], tmp_path: Path
) -> None:
    whole = replace(swing, horizon=3.0)
    targets.append(Live(whole, within(Serve(seed=103)), keep=tmp_path))
    shown = [targets[0].trial(PUSHES, np.random.default_rng(0)) for _ in range(2)]
    for trial, each in enumerate(shown, 1):
        position, velocity = simulated(whole, 103, trial)
        # Numbers go as text and come back the same; sums of steps may round otherwise.
        np.testing.assert_allclose(each.position, position, atol=1e-9)
        np.testing.assert_allclose(each.velocity, velocity, atol=1e-9)
    check_referee(whole, shown[0])
    check_recorded(whole, shown, tmp_path)


def check_referee(whole: Task, shown: Experience) -> None:
    """Loss and success are the task's, on the noisy states."""
    model = whole.simulator().model
    moved = Moved(
        robot=whole.robot,
        model=model,
        time=0.05 * np.arange(61),
        position=shown.position[None],
        velocity=shown.velocity[None],
        command=np.concatenate([shown.command, shown.command[-1:]])[None],
    )
    assert shown.loss == whole.loss(moved)[0]
    assert shown.success == whole.succeeded(moved)[0]


def check_recorded(whole: Task, shown: list[Experience], folder: Path) -> None:
    """What was kept comes back as the same runs."""
    recorded = Recorded(task=whole, recordings=load_recordings(folder, robot=whole.robot))
    for mine, its in zip(shown, recorded.runs(), strict=True):
        np.testing.assert_allclose(its.position, mine.position, atol=1e-9)
        np.testing.assert_allclose(its.velocity, mine.velocity, atol=1e-9)
        np.testing.assert_allclose(its.command, mine.command, atol=1e-9)
        assert its.loss == pytest.approx(mine.loss, abs=1e-9)


def test_a_served_body_that_keeps_time_keeps_it(swing: Task, targets: list[Live]) -> None:
    # Its horizon is its own, 3 s; a trial of half a second is stopped before that.
    targets.append(Live(swing, within(Serve(clock="target"))))
    for _ in range(2):
        shown = targets[0].trial(PUSHES, np.random.default_rng(0))
        assert len(shown.position) == 11
        conduct = targets[0].conduct
        assert conduct is not None
        assert conduct.safe
        # A simulation says the time of its states, and that is exact.
        assert (conduct.irregular, conduct.latest) == (0, pytest.approx(0.0, abs=1e-9))


FAULTS = {
    "hinge.position in degrees": (Serve(unit=("hinge.position=deg",)), r"is in deg"),
    "another name": (Serve(rename=("slide=cart",)), r"it has no actuator 'slide' \(N\)"),
    "a frozen channel": (Serve(frozen=("hinge.position=0.2",)), r"hinge.position gave the same"),
    "a lost channel": (Serve(lost=("slide.velocity=0.2",)), r"slide.velocity is no finite number"),
    "a state that is not sent": (Serve(skips=0.2, clock="target"), r"a state is lost"),
    "rubbish": (Serve(rubbish=True), r"6 lines are no states"),
    "silence": (Serve(hangs=0.2), r"it stopped answering"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_target_with_a_fault_is_refused_or_held_safe(
    swing: Task, targets: list[Live], fault: str
) -> None:
    asked, says = FAULTS[fault]
    watch = Watch(answer_within=0.4, unreadable=5, repeats=5)
    targets.append(Live(swing, within(asked), watch=watch))
    with pytest.raises(TransferError, match=says):
        targets[0].trial(PUSHES, np.random.default_rng(0))


def test_a_target_that_obeys_late_is_said_or_refused(swing: Task, targets: list[Live]) -> None:
    whole = replace(swing, horizon=2.0)
    targets.append(Live(whole, within(Serve(delay=0.1))))
    targets[0].trial(PUSHES, np.random.default_rng(0))
    conduct = targets[0].conduct
    assert conduct is not None
    # 2 s of pushes tell a delay within some ms; 10 ms are given.
    assert conduct.delay == pytest.approx(0.1, abs=0.01)
    assert conduct.notes[0].startswith("commands are obeyed 0.1")
    targets.append(Live(whole, within(Serve(delay=0.1)), watch=Watch(delay=0.05)))
    with pytest.raises(TrialStopped, match=r"obeyed 0\.\d+ s late .* more than 0.05 s") as error:
        targets[1].trial(PUSHES, np.random.default_rng(0))
    assert len(error.value.shown.position) == whole.samples


def test_the_program_itself_is_a_target_that_may_die(swing: Task) -> None:
    program = [sys.executable, "-m", "morph.policy_transfer.live.serve", "--dies", "0.2"]
    target = Live(swing, Process(program), watch=Watch(open_within=60.0))
    with pytest.raises(TrialStopped, match=r"ended with status 7; 4 of 11 states are kept"):
        target.trial(PUSHES, np.random.default_rng(0))
    target.close()


def test_what_cannot_be_served_is_refused_with_status_2(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["--robot", "cartpole", "--task", "walk"]) == 2
    assert capsys.readouterr().err.startswith("error: ")
