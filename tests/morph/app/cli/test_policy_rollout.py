from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from morph.app.cli.main import main
from morph.body.load import load
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.policy.linear import Linear
from morph.policy.observing import observations_of
from morph.policy.policy import actions_of
from morph.policy.store import write_policy
from morph.record.load import load_recordings

GAIN = np.array([[-2.7, 27.2, -3.3, 4.3]])
"""Feedback that balances the cart-pole; where it is from stands in `test_learn.py`."""
UPRIGHT = np.array([0.0, np.pi, 0.0, 0.0])


@pytest.fixture(scope="module")
def cartpole() -> Robot:
    return load("cartpole")


@pytest.fixture
def written(cartpole: Robot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., str]:
    monkeypatch.chdir(tmp_path)

    def write(gain: np.ndarray, period: float = 0.02) -> str:
        policy = Linear(
            weight=-gain,
            bias=gain @ UPRIGHT,
            action=actions_of(cartpole),
            observation=observations_of(cartpole),
            period=period,
        )
        return str(write_policy(policy, tmp_path / "policy", cartpole))

    return write


def simulated(*arguments: str, status: int = 0) -> dict[str, Any]:
    assert main(["simulate", "cartpole", *arguments, "--out", "run.npz", "--quiet"]) == status
    (recording,) = load_recordings(Path("run.npz"), robot=load("cartpole"))
    return {name: channel.value for name, channel in recording.channels.items()}


def by_hand(robot: Robot, steps: int, held: int) -> np.ndarray:
    """Return the states of a loop closed with MuJoCo's own step, shape (steps + 1, 4)."""
    model = spec_of(robot, timestep=0.002).compile()
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    data = mujoco.MjData(model)
    data.qpos[:] = (0.0, 3.0)
    states = []
    for step in range(steps + 1):
        state = np.r_[data.qpos, data.qvel]
        states.append(state)
        if step % held == 0:
            data.ctrl[:] = np.clip(-GAIN @ (state - UPRIGHT), -10.0, 10.0)
        mujoco.mj_step(model, data)
    return np.array(states)


def test_a_policy_that_observes_drives_as_a_loop_closed_by_hand(
    cartpole: Robot, written: Callable[..., str]
) -> None:
    folder = written(GAIN)
    # 1.005 s are not a whole number of steps: it runs the nearest 502, within the 51st period.
    run = simulated("--policy", folder, "--start", "hinge=3", "--seconds", "1.005")
    due = by_hand(cartpole, 502, held=10)
    found = np.stack(
        [
            run[f"{joint}.{what}"]
            for what in ("position", "velocity")
            for joint in ("slide", "hinge")
        ],
        axis=1,
    )
    # The same steps of the same engine, so that nothing but rounding lies between them.
    assert found == pytest.approx(due, abs=1e-9)
    told = np.clip(-(due[:-1] - UPRIGHT) @ GAIN[0], -10.0, 10.0)
    assert run["slide.command"] == pytest.approx(np.repeat(told[::10], 10)[:502], abs=1e-9)


def test_it_balances_what_falls_by_itself(written: Callable[..., str]) -> None:
    folder = written(GAIN)
    start = ("--start", "hinge=3.1", "--seconds", "3")
    assert abs(simulated("--policy", folder, *start)["hinge.position"][-1] - np.pi) < 0.01
    # Left alone it leans by 0.04 rad e^(3 s sqrt(1.5 g / l)) or so: it has long fallen.
    assert abs(simulated(*start)["hinge.position"] - np.pi).max() > 1.0


def test_a_command_comes_before_the_policy(written: Callable[..., str]) -> None:
    run = simulated("--policy", written(GAIN), "--command", "slide=2", "--seconds", "0.2")
    assert set(run["slide.command"]) == {2.0}


def test_an_unstable_run_is_recorded_as_far_as_it_was_stable(
    written: Callable[..., str], capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ("--policy", written(GAIN), "--speed", "hinge=1e9", "--seconds", "1")
    # Moved at once by 1e6 rad a step, it leaves what MuJoCo calls stable at some step or at once.
    status = main(["simulate", "cartpole", *arguments, "--json", "--quiet"])
    told = capsys.readouterr()
    assert status in {2, 3}
    if status == 3:
        assert "unstable" in json.loads(told.out)["stopped_short"]
    else:
        assert "unstable" in told.err


def test_a_period_that_no_step_divides_is_refused(
    written: Callable[..., str], capsys: pytest.CaptureFixture[str]
) -> None:
    folder = written(GAIN, period=0.015)
    assert main(["simulate", "cartpole", "--policy", folder, "--quiet"]) == 2
    assert "fits neither steps of 0.002 s" in capsys.readouterr().err
