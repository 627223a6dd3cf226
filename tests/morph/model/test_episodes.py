from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.body.spec import spec_of
from morph.model.episodes import episode, step_for, velocity_lag
from morph.model.measurement import Measurement
from morph.record.recording import Channel, Recording

Recorded = Callable[..., Recording]


def test_the_velocity_of_a_step_lags_by_half_of_it(recorded: Recorded) -> None:
    double_pendulum = load("double_pendulum")
    run = recorded(double_pendulum, seconds=1.0)
    laid = episode(run, double_pendulum, step_for([run], double_pendulum))
    # One posture, velocity and acceleration; bent by a right angle sin(q2) is 1 and cos(q2) is 0.
    q, v, a = np.array([0.3, 0.5 * np.pi]), np.array([0.4, 0.6]), np.array([3.0, -2.8])
    tiled = {"position": q, "velocity": v, "acceleration": a}
    laid = replace(laid, **{k: np.tile(x, (len(laid.position), 1)) for k, x in tiled.items()})
    model = spec_of(double_pendulum).compile()
    data = mujoco.MjData(model)

    def inertia(bend: float) -> Array:
        data.qpos[:] = 0.3, bend
        mujoco.mj_forward(model, data)
        whole = np.zeros((2, 2))
        mujoco.mj_fullM(model, data, whole)
        return whole

    # M11 = A + 2 H cos(q2): c1 = -H sin(q2) (2 v1 v2 + v2^2) and c2 = H sin(q2) v1^2, of which
    # half a step changes H (a1 v2 + v1 a2 + v2 a2) h and -H v1 a1 h.
    H = 0.5 * (inertia(0.0)[0, 0] - inertia(0.5 * np.pi)[0, 0])
    lag = H * np.array([a[0] * v[1] + v[0] * a[1] + v[1] * a[1], -v[0] * a[0]])
    share = np.abs(lag) / np.abs(inertia(0.5 * np.pi) @ a)
    # What is of second order in a step of 0.1 ms is a thousandth of that.
    found = velocity_lag(double_pendulum, [laid], 1e-4)
    assert found == pytest.approx(1e-4 * share, rel=0.002)


@pytest.mark.parametrize(
    ("floor", "step"), [("", 0.02), ('<geom type="plane" size="1 1 1"/>', 0.004)]
)
def test_a_single_body_that_touches_nothing_takes_a_tenth_of_its_period(
    floor: str, step: float, tmp_path: Path
) -> None:
    collides = "" if floor else 'contype="0" conaffinity="0"'
    (tmp_path / "ball.xml").write_text(
        f"<mujoco><worldbody>{floor}<body name='ball' pos='0 0 1'><freejoint/>"
        f"<geom size='0.1' mass='1' {collides}/></body></worldbody></mujoco>"
    )
    ball, time = load(tmp_path / "ball.xml"), 0.2 * np.arange(11)
    names = Measurement.of(ball).needed
    channels = {name: Channel(time=time, value=np.ones(11)) for name in names}
    assert step_for([Recording(name="run", channels=channels)], ball) == pytest.approx(step)
