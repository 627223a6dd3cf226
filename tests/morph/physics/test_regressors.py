"""Each regressor against the force that a simulation of its law needs beyond the nominal one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.physics import EFFECTS, effect_class
from morph.physics.body_motion import BodyMotion, body_motions
from morph.physics.effect import Effect
from morph.physics.motion import Motion
from morph.sim.simulator import Simulator, compiled

STEP = 0.002
"""Seconds."""

ARM = """<mujoco model="arm">
  <compiler angle="radian" inertiafromgeom="false"/>
  <worldbody>
    <body name="upper" euler="0.3 0 0.2">
      <inertial pos="0.02 0.03 -0.2" mass="1.2" diaginertia="0.02 0.03 0.02"/>
      <joint name="shoulder" axis="0 1 0" armature="0.01"/>
      <body name="lower" pos="0 0 -0.4">
        <inertial pos="0 0.01 -0.15" mass="0.7" diaginertia="0.01 0.012 0.01"/>
        <joint name="elbow" axis="0.6 0.8 0" armature="0.02"/>
      </body>
    </body>
  </worldbody>
  <actuator>%s</actuator>
</mujoco>"""
"""It moves in space, so that all of a force's directions show."""

MOTORS = '<motor name="shoulder" joint="shoulder"/><motor name="elbow" joint="elbow" gear="2"/>'
SERVOS = (
    '<position name="shoulder" joint="shoulder" kp="20" kv="0.5"/>'
    '<position name="elbow" joint="elbow" kp="12" kv="0.3" gear="1.5"/>'
)

FELT: Mapping[str, Mapping[str, float]] = {
    "load_dependent_friction": {"c0": 0.02, "k": 0.1},
    "position_dependent_friction": {"c": 0.05, "a": 0.03, "n": 3.0, "phase": 0.5},
    "cogging": {"a": 0.3, "n": 6.0, "phase": -2.0},
    "hysteresis": {"c": 0.4, "z": 0.05},
    "backlash": {"gap": 0.06},
    "series_elasticity": {"k": 15.0, "d": 0.03},
    "end_stop": {"q_stop": 0.15, "side": -1.0, "k": 40.0, "d": 0.3},
    "torque_saturation": {"limit": 0.4},
    "speed_torque_limit": {"tau0": 0.5, "v0": 3.0},
    "back_emf": {"k": 0.1},
    "thermal_derating": {"floor": 0.3, "rate": 5.0, "level": 0.8},
    "voltage_sag": {"k": 0.6},
    "dead_zone": {"threshold": 0.2},
    "external_push": {"start": 0.1013, "end": 0.2027, "x": 0.1, "y": -0.2, "z": 0.15},
    "tether": {"k": 5.0, "length": 0.3, "x": 0.5, "y": 0.4, "z": -0.3, "cx": 0.1, "cz": -0.2},
    "base_tilt": {"roll": 2e-6, "pitch": -1e-6},
}
"""Parameters at which each law is felt."""

CUT = {"torque_saturation", "series_elasticity"}
"""Laws that take a servo's damping away from MuJoCo."""
DRY = {"load_dependent_friction", "position_dependent_friction"}


@pytest.fixture(scope="module", params=[MOTORS, SERVOS], ids=["motors", "servos"])
def robot(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Robot:
    path = tmp_path_factory.mktemp("arm") / "arm.xml"
    path.write_text(ARM % request.param)
    return load(path)


def told(times: Array, after: float) -> Array:
    """Return a command that changes its sign, jumps and is exactly zero for a while."""
    wave = np.sin(2.0 * np.pi * 2.3 * (times + after)) + 0.5 * np.sign(np.sin(25.0 * times))
    return np.where((times > 0.3) & (times < 0.35), 0.0, 0.8 * wave)


def run(robot: Robot, effects: tuple[Effect, ...]) -> tuple[Array, Array, Array]:
    """Return positions, velocities and commands at each step."""
    moved = Simulator(robot, effects, step=STEP).trajectory(
        seconds=0.6,
        start={"shoulder": 0.5, "elbow": 0.2},
        command={"shoulder": lambda t: told(t, 0.0), "elbow": lambda t: told(t, 0.1)},
    )
    return moved.position, moved.velocity, np.stack(list(moved.command.values()), axis=1)


def seen(robot: Robot, q: Array, v: Array, u: Array) -> tuple[Motion, Array]:
    """Return a motion, and the force that it needs beyond the nominal model's."""
    model = compiled(spec_of(robot, timestep=STEP), (), robot).model
    model.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_INVDISCRETE)
    data = mujoco.MjData(model)
    a = np.diff(v, axis=0) / STEP
    samples = len(a)
    need, drive = np.empty((samples, 2)), np.zeros((samples, 2, 2))
    for k in range(samples):
        data.qpos, data.qvel, data.qacc, data.ctrl = q[k], v[k], a[k], u[k]
        mujoco.mj_inverse(model, data)
        mujoco.mj_fwdActuation(model, data)
        need[k] = data.qfrc_inverse - data.qfrc_actuator
        drive[k] = np.diag(data.qfrc_actuator)
    gear, bias = model.actuator_gear[:, :1], model.actuator_biasprm[:, 1:3]
    motion = Motion(
        position=q[:-1],
        velocity=v[:-1],
        acceleration=a,
        drive=drive,
        drive_rate=np.zeros_like(drive),
        stiffness=np.zeros((samples, 2, 2)),
        joints={"shoulder": 0, "elbow": 1},
        actuators={"shoulder": 0, "elbow": 1},
        bodies=body_motions(model, ["upper", "lower"], q[:-1], v[:-1], a),
        time=STEP * np.arange(samples),
        command=u,
        driven={"shoulder": "shoulder", "elbow": "elbow"},
        servo=-(gear**2) * bias,
        armature=model.dof_armature.copy(),
    )
    return motion, need


def test_every_law_that_is_new_has_an_example_here() -> None:
    new = {k.name for k in EFFECTS if not k.suspected}
    assert new == set(FELT) | {"sensor_scale", "timestamp_offset", "fluid_current"}


@pytest.mark.parametrize("name", FELT)
@pytest.mark.parametrize("place", [0, -1], ids=["first", "last"])
def test_a_regressor_tells_the_force_that_the_simulation_feels(
    robot: Robot, name: str, place: int
) -> None:
    kind = effect_class(name)
    effect = replace(kind.at(kind.places(robot)[place]), **FELT[name])  # type: ignore[type-var]
    motion, need = seen(robot, *run(robot, (effect,)))
    due = effect.regressor(motion) @ effect.coefficients
    assert due.shape == need.shape
    assert np.abs(due).max() > 1e-6
    # Velocities of 1 rad/s are known to 1e-16, and their differences over a step of 2 ms are
    # accelerations to 1e-13. A servo's slopes are found over 1e-6 rad: 1e-16 / 1e-6 of 27
    # N m/rad, for about 1 rad.
    within = np.full(need.shape, 1e-8)
    if name == "base_tilt":
        # To first order: (2e-6)^2 of the weight, 19 N on 0.5 m.
        within[:] = 5e-11
    if name in CUT:
        # MuJoCo damps a servo that is not cut off by its speed after the step.
        within += STEP * motion.servo[:, 1] * np.abs(motion.acceleration)
    chosen = np.ones(need.shape, dtype=bool)
    if name in DRY:
        # A joint that turns back within a step, or nearly rests, is held by less.
        dof = motion.joints[effect.where]
        speed, held = motion.velocity[:, dof], motion.sign(effect.where)
        after = speed + STEP * motion.acceleration[:, dof]
        chosen[:, dof] = (held == np.sign(speed)) & (held == np.sign(after))
        chosen[:, dof] &= np.abs(speed) > 0.1 * np.sqrt(np.mean(speed**2))
        assert chosen[:, dof].mean() > 0.8
    assert np.all(np.abs(due - need)[chosen] < within[chosen])


@pytest.fixture(scope="module")
def swing() -> Motion:
    """Return a smooth motion of two joints, the last one under a servo."""
    time = np.linspace(0.0, 2.0, 2001)
    waves = np.stack([0.3 * np.sin(2.0 * time), 0.5 * np.sin(3.0 * time)], axis=1)
    rates = np.stack([0.6 * np.cos(2.0 * time), 1.5 * np.cos(3.0 * time)], axis=1)
    drive = np.zeros((2001, 2, 2))
    drive[:, 0, 0], drive[:, 1, 1] = np.cos(2.0 * time), 2.0 * np.cos(3.0 * time)
    ones = np.ones((2001, 1, 1))
    body = BodyMotion(
        jacobian=np.eye(6)[:, :2] * ones,
        velocity=np.zeros((2001, 6)),
        acceleration=np.zeros((2001, 6)),
        gravity=np.tile([0.0, 0.0, -9.81], (2001, 1)),
        origin=np.stack([waves[:, 0], waves[:, 1], 0.2 * time], axis=1),
        axes=np.eye(3) * ones,
        mass=1.0,
        com=np.array([0.1, 0.0, 0.2]),
        inertia=np.eye(3),
    )
    return Motion(
        position=waves,
        velocity=rates,
        acceleration=-waves * np.array([4.0, 9.0]),
        drive=drive,
        drive_rate=np.zeros_like(drive),
        stiffness=np.zeros((2001, 2, 2)),
        joints={"shoulder": 0, "elbow": 1},
        actuators={"shoulder": 0, "elbow": 1},
        bodies={"lower": body},
        time=time,
        command=drive.sum(axis=2),
        driven={"shoulder": "shoulder", "elbow": "elbow"},
        servo=np.array([[0.0, 0.0], [5.0, 0.3]]),
        armature=np.array([0.0, 0.05]),
    )


def placed(name: str) -> Effect:
    kind = effect_class(name)
    return kind.at({"body": "lower", "world": "world"}.get(kind.kind, "elbow"))


@pytest.mark.parametrize("name", FELT)
def test_a_law_is_read_back_from_its_own_coefficients(name: str) -> None:
    law = replace(placed(name), **FELT[name])  # type: ignore[type-var]
    again = law.with_strengths(law.coefficients)
    for known in law.parameters():
        # A sine, an arc tangent and a quotient: roundoff.
        assert getattr(again, known.name) == pytest.approx(getattr(law, known.name), rel=1e-12)


@pytest.mark.parametrize("name", FELT)
def test_a_linear_fit_within_the_bounds_of_coefficients_is_a_law(name: str) -> None:
    law = replace(placed(name), **FELT[name])  # type: ignore[type-var]
    low, high = law.coefficient_bounds()
    assert ((low <= law.coefficients) & (law.coefficients <= high)).all()
    # A strength at its least: a law, and the others stay as they are where bounds are their own.
    for at in np.flatnonzero(np.isfinite(low)):
        least = law.coefficients.copy()
        least[at] = low[at]
        assert law.with_strengths(least).coefficients[at] == pytest.approx(low[at], abs=1e-5)
        # Less than nothing of a law that only takes away, as of a mass, is none.
        beyond = np.where(np.arange(len(low)) == at, low[at] - 1.0, least)
        assert law.with_strengths(beyond).coefficients[at] >= low[at] - 1e-9


@pytest.mark.parametrize("name", ["payload", "tether"])
def test_a_load_and_a_cable_have_a_least_coefficient(name: str) -> None:
    low, _ = placed(name).coefficient_bounds()
    assert low.tolist() == [0.0, -np.inf, -np.inf, -np.inf]


@pytest.mark.parametrize("name", FELT)
def test_every_shape_to_try_is_one_that_the_recording_could_show(name: str, swing: Motion) -> None:
    # A push is looked for where a missing force stands out: one of 0.08 s here.
    late = np.abs(swing.time - 0.5 * swing.time[-1]) < 0.04
    swing = replace(swing, missing=np.stack([late, late], axis=1).astype(float))
    shapes = placed(name).shapes(swing)
    # One column each that no other is a multiple of.
    directions = set()
    for shape in shapes:
        columns = shape.regressor(swing)
        assert columns.shape == (2001, 2, len(shape.strengths))
        assert np.isfinite(columns).all()
        size = np.sqrt((columns**2).sum(axis=(0, 1)))
        # Only a stop that the joint enters from rest on has no damping yet to tell.
        assert size.max() > 1e-6
        directions.add(tuple(np.round(columns[::10, :, 0].ravel() / size.max(), 9)))
    assert len(directions) == len(shapes) or name in {
        "position_dependent_friction", "tether", "external_push",
    }  # fmt: skip
    # What is followed together is as it was alone, to the last bits.
    alone = np.concatenate([shape.regressor(swing) for shape in shapes], axis=2)
    assert shapes[0].regressors(shapes, swing) == pytest.approx(alone, rel=1e-12, abs=1e-15)


def test_a_stiff_spring_lags_by_what_it_carries(swing: Motion) -> None:
    # The rotor is ahead by x = (u - J a) / k, u - J a = (2 cos - 0.05 (-4.5 sin)) (3 t). Its own
    # inertia, servo and damping miss J x'' + 0.3 x' + 5 x of it: k times that is known.
    law, time = placed("series_elasticity"), 3.0 * swing.time
    carried = 2.0 * np.cos(time) + 0.225 * np.sin(time)
    rate = 3.0 * (-2.0 * np.sin(time) + 0.225 * np.cos(time))
    due = -(0.05 * -9.0 * carried + 0.3 * rate + 5.0 * carried)
    limit = law.regressor(swing)[:, 1, 0]
    # Second differences at steps of 1 ms, w h = 3e-3: 1e-5 of it, but at the ends.
    assert limit[3:-3] == pytest.approx(due[3:-3], abs=2e-4)
    # A spring of 1e4 N m/rad with some damping: (5 + 9 * 0.05) / 1e4 of it once it is quiet.
    stiff = replace(law, k=1e4, d=10.0).regressor(swing)[:, 1, 0]  # type: ignore[call-arg]
    assert np.sqrt(np.mean((stiff - due)[200:] ** 2)) < 0.01 * np.sqrt(np.mean(due**2))
