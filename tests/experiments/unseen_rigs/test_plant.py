from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from experiments.unseen_rigs.__main__ import _controller, _start
from experiments.unseen_rigs.dynamics import PERIOD, STEP, STIFF, Simulated
from experiments.unseen_rigs.plant import Foot, Plant, Push
from experiments.unseen_rigs.rigs import RIGS
from morph.arrays import Array

GRAVITY = 9.81


def moved_by_mujoco(path: Path, told: dict[str, Array], seconds: float) -> tuple[object, Array]:
    """Return MuJoCo's own motion under the same commands, by Runge and Kutta's rule."""
    model = mujoco.MjModel.from_xml_path(str(path))
    model.opt.timestep, model.opt.integrator = STEP, mujoco.mjtIntegrator.mjINT_RK4
    data = mujoco.MjData(model)
    each, rows = round(PERIOD / STEP), []
    for at in range(round(seconds / STEP) + 1):
        if at % (5 * each) == 0:
            rows.append(data.qpos.copy())
        for name, values in told.items():
            data.ctrl[model.actuator(name).id] = values[at // each]
        mujoco.mj_step(model, data)
    return model, np.array(rows)


@pytest.mark.parametrize("name", ["swimmer", "arm", "vehicle"])
def test_a_rig_as_described_moves_as_in_mujoco(tmp_path: Path, name: str) -> None:
    rig = RIGS[name](tmp_path)
    plant = Simulated(rig.described)
    moved = plant.moved(_controller(rig, np.arange(12.0)), _start(rig, plant), 0.5)
    model, theirs = moved_by_mujoco(rig.described.description, dict(moved.told), 0.5)
    ours = {joint: moved.position[:, at] for joint, (at, _) in plant.hinges.items()}
    # Forces act half a step of 0.2 ms early, at up to 5 rad/s: 0.5 mrad.
    for joint, values in ours.items():
        at = model.joint(joint).qposadr[0]  # type: ignore[attr-defined]
        assert np.abs(values - theirs[:, at]).max() < 5e-4
        assert np.ptp(values) > 0.01
    if rig.base:
        assert np.abs(moved.position[:, :3] - theirs[:, :3]).max() < 5e-4


def ball(folder: Path, **lacks: object) -> Simulated:
    path = folder / "ball.xml"
    path.write_text(
        '<mujoco><worldbody><body name="ball"><freejoint name="base"/>'
        '<inertial pos="0 0 0" mass="2" diaginertia="1e6 1e6 1e6"/></body></worldbody></mujoco>'
    )
    foot = Foot(joint="base", place=(0.0, 0.0, 0.0), radius=0.1, mu=0.3)
    return Simulated(replace(Plant(description=path, feet=[foot]), **lacks))  # type: ignore[arg-type]


def at_height(plant: Simulated, height: float) -> Array:
    start = plant.pin.neutral(plant.model)
    start[2] = height
    return np.asarray(start)


def test_a_ball_rests_as_deep_as_its_weight_presses_it(tmp_path: Path) -> None:
    plant = ball(tmp_path)
    moved = plant.moved(lambda t, q, v: {}, at_height(plant, 0.1), 2.0)
    assert moved.position[-1, 2] == pytest.approx(0.1 - 2.0 * GRAVITY / STIFF, abs=1e-6)
    # An accelerometer at rest reads gravity upwards.
    assert moved.pull[-1] == pytest.approx([0.0, 0.0, GRAVITY], abs=1e-3)


def test_what_is_pushed_harder_than_friction_slides_and_stops(tmp_path: Path) -> None:
    # 10 N for 0.5 s against 5.886 N: 1.03 m/s and .257 m, then v^2 / (2 mu g) = .180 m.
    plant = ball(tmp_path, push=Push(start=0.0, end=0.5, force=(10.0, 0.0, 0.0)))
    moved = plant.moved(lambda t, q, v: {}, at_height(plant, 0.1 - 2.0 * GRAVITY / STIFF), 1.5)
    speed = (10.0 - 0.3 * 2.0 * GRAVITY) / 2.0 * 0.5
    way = 0.5 * speed * 0.5 + speed**2 / (2.0 * 0.3 * GRAVITY)
    # Friction grows over the first mu m g / k = 0.3 mm, 11 ms at 5 m/s2: up to 0.016 m/s are not
    # lost there, which go .016 (.5 + 1.03 / 2.94) m = 14 mm. 1 % less friction: 11 mm.
    assert way < moved.position[-1, 0] < way + 0.014


def test_a_loop_stays_closed_and_play_lets_the_crank_wait(tmp_path: Path) -> None:
    rig = RIGS["fourbar"](tmp_path)
    ends = []
    for described in (rig.described, rig.lacking):
        plant = Simulated(described)
        moved = plant.moved(_controller(rig, np.arange(12.0)), _start(rig, plant), 1.0)
        crank, coupler, leg = moved.position.T
        tip = _tip(crank, coupler)
        upper = np.stack([0.25 + 0.15 * np.sin(leg), 0.15 * np.cos(leg)], axis=1)
        # Baumgarte's rule leaves errors of a step's own order, h^2 times accelerations of 50.
        assert np.abs(tip - upper).max() < 1e-5
        ends.append(crank)
    # The motor may be half the gap, 15 mrad, ahead of the crank.
    assert 1e-3 < np.abs(ends[0] - ends[1]).max() < 0.06


def _tip(crank: Array, coupler: Array) -> Array:
    """Return where the coupler ends, x and z: turns are about y, from z to x."""
    x = 0.1 * np.cos(crank)
    z = -0.1 * np.sin(crank)
    turn = crank + coupler
    return np.stack(
        [
            x + 0.15 * np.cos(turn) + 0.15 * np.sin(turn),
            z - 0.15 * np.sin(turn) + 0.15 * np.cos(turn),
        ],
        axis=1,
    )
