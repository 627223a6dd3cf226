"""Each law, through the simulator, against what paper and pencil say."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.errors import SimulationFailed
from morph.physics import EFFECTS
from morph.physics.actuator.actuator_delay import ActuatorDelay
from morph.physics.actuator.actuator_lag import ActuatorLag
from morph.physics.actuator.torque_scale import TorqueScale
from morph.physics.effect import Effect
from morph.physics.joint.armature import Armature
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.physics.joint.joint_stiffness import JointStiffness
from morph.physics.joint.quadratic_damping import QuadraticDamping
from morph.physics.joint.stribeck_friction import StribeckFriction
from morph.physics.joint.viscous_friction import ViscousFriction
from morph.physics.sensor.sensor_bias import SensorBias
from morph.record.recording import Channel, Recording
from morph.sim.simulator import Simulator

INERTIA = 0.25
"""Of the wheel, kg m2."""
STEP = 0.0005
"""Seconds."""

WHEEL = """<mujoco model="wheel">
  <compiler angle="radian" inertiafromgeom="false"/>
  <option gravity="0 0 0"/>
  <worldbody>
    <body name="rim">
      <inertial pos="0 0 0" mass="1" diaginertia="0.2 0.25 0.2"/>
      <joint name="axle" axis="0 1 0"/>
    </body>
  </worldbody>
  <actuator><motor name="axle" joint="axle"/></actuator>
</mujoco>"""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    path = tmp_path_factory.mktemp("wheel") / "wheel.xml"
    path.write_text(WHEEL)
    return load(path)


@pytest.fixture(scope="module")
def pendulum() -> Robot:
    return load("pendulum")


def spun(wheel: Robot, effect: Effect, speed: float, seconds: float) -> Recording:
    return Simulator(wheel, effects=(effect,), step=STEP).run(
        seconds=seconds, speed={"axle": speed}
    )


def period(run: Recording, joint: str, about: float) -> float:
    """Return the mean time between upward passages of a position, s."""
    channel = run.channel(f"{joint}.position")
    time, value = channel.time, channel.value - about
    up = np.flatnonzero((value[:-1] < 0.0) & (value[1:] >= 0.0))
    passed = time[up] - value[up] * np.diff(time)[up] / (value[up + 1] - value[up])
    return float(np.diff(passed).mean())


def test_viscous_friction_slows_a_wheel_exponentially(wheel: Robot) -> None:
    run = spun(wheel, ViscousFriction(joint="axle", b=0.5), 4.0, 2.0)
    time = run.channel("axle.velocity").time
    # An implicit step divides by 1 + x, x = h b / I = 0.001, where exp(x) is due: x^2 / 2
    # a step, 4000 steps: exp(0.002), 0.2001 %.
    rate = 0.5 / INERTIA
    assert run["axle.velocity"] == pytest.approx(4.0 * np.exp(-rate * time), rel=0.0021)


def test_coulomb_friction_stops_a_wheel_when_its_momentum_is_spent(wheel: Robot) -> None:
    run = spun(wheel, CoulombFriction(joint="axle", c=0.5), 2.0, 2.0)
    time, speed = run.channel("axle.velocity").time, run["axle.velocity"]
    stop = INERTIA * 2.0 / 0.5  # 1 s
    # MuJoCo's friction is softer by a ten-thousandth of its impedance.
    assert speed == pytest.approx(np.maximum(2.0 * (1.0 - time / stop), 0.0), abs=2e-3)
    # It turned w0 T / 2 = 1 rad, give or take the half step by which velocities lag.
    assert run["axle.position"][-1] == pytest.approx(1.0, abs=2.0 * STEP)
    # And it stays: what is left of 2 rad/s is nothing.
    assert np.abs(speed[time > stop + 0.01]).max() < 1e-6


@pytest.mark.parametrize(("level", "holds"), [(0.35, True), (0.05, False)])
@pytest.mark.parametrize("kind", ["coulomb", "stribeck"])
def test_friction_at_rest_holds_what_gravity_would_drop(
    pendulum: Robot, kind: str, level: float, holds: bool
) -> None:
    # Gravity: 1 kg * 9.81 m/s^2 * 0.5 m * sin(0.05) = 0.245 N m, between 0.05 and 0.35.
    effect: Effect = CoulombFriction(joint="hinge", c=level)
    if kind == "stribeck":
        effect = StribeckFriction(joint="hinge", c=0.05, s=level)
    run = Simulator(pendulum, effects=(effect,)).run(start={"hinge": 0.05}, seconds=1.0)
    # A held joint creeps at torque / inertia (1 - d) / d * time / 2, d = 0.9999, over twice
    # the step of 2 ms: 0.245 / 0.251 * 1e-4 * 0.002 = 2e-7 rad/s.
    moved = abs(run["hinge.position"][-1] - 0.05)
    assert (moved < 1e-6) == holds


def test_stribeck_friction_slides_at_its_lower_level(wheel: Robot) -> None:
    run = spun(wheel, StribeckFriction(joint="axle", c=0.1, s=0.5, vs=0.2), 2.0, 4.0)
    time, speed = run.channel("axle.velocity").time, run["axle.velocity"]
    # Above 3 vs = 0.6 rad/s what s adds is below 0.4 exp(-9) = 5e-5 N m of 0.1 N m.
    fast = speed > 0.6
    assert speed[fast] == pytest.approx(2.0 - 0.1 / INERTIA * time[fast], abs=1e-3)
    assert fast.sum() * STEP == pytest.approx((2.0 - 0.6) * INERTIA / 0.1, abs=0.01)


def test_stribeck_friction_brakes_harder_before_it_stops(wheel: Robot) -> None:
    effect = StribeckFriction(joint="axle", c=0.1, s=0.5, vs=0.2)
    run = spun(wheel, effect, 0.3, 1.0)
    # dt = I dw / level(w), by quadrature from 0.3 rad/s to rest.
    speeds = np.linspace(0.0, 0.3, 3001)
    level = 0.1 + 0.4 * np.exp(-((speeds / 0.2) ** 2))
    stop = float(np.trapezoid(INERTIA / level, speeds))
    moving = run["axle.velocity"] > 1e-3
    # The level is taken at the start of each step, and the last step is not whole: two steps.
    assert moving.sum() * STEP == pytest.approx(stop, abs=2.0 * STEP + 1e-3)


def test_quadratic_damping_slows_a_wheel_hyperbolically(wheel: Robot) -> None:
    run = spun(wheel, QuadraticDamping(joint="axle", b2=0.1), 5.0, 2.0)
    time = run.channel("axle.velocity").time
    rate = 0.1 * 5.0 / INERTIA  # 2 / s
    # An implicit step errs by at most h rate = 0.001 of the speed over the whole run.
    assert run["axle.velocity"] == pytest.approx(5.0 / (1.0 + rate * time), rel=0.001)


def test_joint_stiffness_swings_a_wheel_about_where_it_is_slack(wheel: Robot) -> None:
    effect = JointStiffness(joint="axle", k=4.0, q0=0.3)
    run = Simulator(wheel, effects=(effect,), step=STEP).run(seconds=8.0)
    # A leapfrog's period errs by (w h)^2 / 24 = (4 * 0.0005)^2 / 24 = 2e-7 of it.
    assert period(run, "axle", 0.3) == pytest.approx(2.0 * np.pi * np.sqrt(INERTIA / 4.0), rel=1e-6)
    # From rest at zero it swings to 2 q0, within half a step of 1.2 rad/s.
    assert run["axle.position"].max() == pytest.approx(0.6, abs=0.5 * STEP * 1.2)
    assert run["axle.position"].min() == pytest.approx(0.0, abs=0.5 * STEP * 1.2)


def test_joint_stiffness_adds_to_a_spring_that_is_there(tmp_path: Path) -> None:
    path = tmp_path / "sprung.xml"
    path.write_text(
        WHEEL.replace('axis="0 1 0"', 'axis="0 1 0" stiffness="1" springref="-0.5" damping="3"')
    )
    effect = JointStiffness(joint="axle", k=3.0, q0=0.5)
    run = Simulator(load(path), effects=(effect,)).run(seconds=20.0)
    # Rest where 1 (q + 0.5) + 3 (q - 0.5) = 0: q = 0.25. The slow root of
    # 0.25 x^2 + 3 x + 4 is -1.53 / s: after 20 s exp(-30) = 5e-14 of it is left.
    assert run["axle.position"][-1] == pytest.approx(0.25, abs=1e-10)


def test_armature_lengthens_the_period_of_a_pendulum(pendulum: Robot) -> None:
    effect = Armature(joint="hinge", J=0.1)
    run = Simulator(pendulum, effects=(effect,), step=STEP).run(seconds=8.0, start={"hinge": 0.01})
    # 1 kg at 0.5 m with 0.001 of its own, and the rotor; gravity 1 * 9.81 * 0.5 N m.
    # An amplitude of 0.01 rad adds 0.01^2 / 16 = 6e-6, the leapfrog takes (w h)^2 / 24 = 1e-7.
    due = 2.0 * np.pi * np.sqrt((0.251 + 0.1) / 4.905)
    assert period(run, "hinge", 0.0) == pytest.approx(due, rel=1e-5)


def test_a_delay_moves_a_command_by_whole_steps(wheel: Robot) -> None:
    time = 0.002 * np.arange(500)
    told = np.random.default_rng(0).normal(size=500)
    late = np.concatenate([np.full(10, told[0]), told[:-10]])

    def run(values: Array, *effects: Effect) -> Recording:
        command = {"axle": Channel(time=time, value=values, hold=True)}
        return Simulator(wheel, effects=effects).run(seconds=1.0, command=command)

    delayed = run(told, ActuatorDelay(actuator="axle", T=0.02))
    # 0.02 / 0.002 is 10 to roundoff: 1e-15 steps of at most 7 N m, a thousand times over.
    assert delayed["axle.position"] == pytest.approx(run(late)["axle.position"], abs=1e-11)
    # What was sent is recorded, not what arrived.
    assert np.array_equal(delayed["axle.command"], told)


@pytest.mark.parametrize("delay", [0.0007, 0.0020, 0.0134])
def test_a_delay_of_part_of_a_step_gives_the_mean_over_each_step(delay: float) -> None:
    told = np.random.default_rng(1).normal(size=50)
    got = ActuatorDelay(actuator="axle", T=delay).command("axle", told, 0.002)
    # The held command read at 20 midpoints a step, T later: delays of whole ten-thousandths
    # of a second fall between these midpoints, so that their mean is exact.
    fine = 0.0001 * (np.arange(50 * 20) + 0.5) - delay
    held = told[np.clip(np.floor(fine / 0.002).astype(int), 0, None)]
    assert got == pytest.approx(held.reshape(50, 20).mean(axis=1), abs=1e-12)


@pytest.mark.parametrize("constant", [0.0005, 0.03, 0.4])
def test_a_lag_answers_a_step_with_one_minus_an_exponential(wheel: Robot, constant: float) -> None:
    effect = ActuatorLag(actuator="axle", T=constant)
    run = Simulator(wheel, effects=(effect,)).run(
        seconds=1.0, command={"axle": lambda times: (times > 0.001).astype(float)}
    )
    # The command rises at 0.002 s. The wheel's speed is the integral of 1 - exp(-t / T) over
    # its inertia, exactly, for the mean over every step is exact: roundoff of 500 sums.
    since = np.maximum(run.channel("axle.velocity").time - 0.002, 0.0)
    due = (since - constant * (1.0 - np.exp(-since / constant))) / INERTIA
    assert run["axle.velocity"] == pytest.approx(due, abs=1e-12)


@pytest.mark.parametrize("kind", [ActuatorDelay, ActuatorLag])
def test_an_effect_on_one_actuator_leaves_the_others_commands(
    kind: type[ActuatorDelay | ActuatorLag],
) -> None:
    told = np.random.default_rng(2).normal(size=20)
    assert np.array_equal(kind(actuator="axle", T=0.1).command("other", told, 0.002), told)


def test_torque_scale_scales_the_torque(wheel: Robot) -> None:
    effect = TorqueScale(actuator="axle", gain=0.6)
    run = Simulator(wheel, effects=(effect,)).run(seconds=1.0, command={"axle": 0.5})
    time = run.channel("axle.velocity").time
    assert run["axle.velocity"] == pytest.approx(0.6 * 0.5 * time / INERTIA, abs=1e-12)


def test_a_servo_whose_command_has_the_wrong_sign_settles_on_the_other_side(
    tmp_path: Path,
) -> None:
    path = tmp_path / "servo.xml"
    servo = '<position name="axle" joint="axle" kp="8" kv="2"/>'
    path.write_text(WHEEL.replace('<motor name="axle" joint="axle"/>', servo))
    effect = TorqueScale(actuator="axle", gain=-0.5)
    run = Simulator(load(path), effects=(effect,)).run(seconds=8.0, command={"axle": 0.5})
    # It is damped at 0.5 2 / (2 0.25) = 2 per s, so that e^-16 of 0.5 rad is left.
    assert run["axle.position"][-1] == pytest.approx(-0.5, abs=1e-6)


def test_a_bias_shows_on_its_channel_only() -> None:
    robot = load("double_pendulum")
    start = {"shoulder": 0.5, "elbow": -0.2}
    plain = Simulator(robot).run(seconds=0.5, start=start)
    bias = SensorBias(channel="elbow.position", bias=0.05)
    biased = Simulator(robot, effects=(bias,)).run(seconds=0.5, start=start)
    for name in plain.channels:
        due = plain[name] + (0.05 if name == "elbow.position" else 0.0)
        assert np.array_equal(biased[name], due)


@pytest.mark.parametrize(
    "kind", [kind for kind in EFFECTS if kind.kind != "world"], ids=lambda kind: kind.name
)
def test_an_effect_on_a_part_that_is_not_there_is_refused(
    kind: type[Effect], pendulum: Robot
) -> None:
    there = re.escape(kind.places(pendulum)[0])
    with pytest.raises(
        SimulationFailed, match=rf"{kind.name} acts on one of {there}.*'knee'"
    ) as caught:
        Simulator(pendulum, effects=(kind.at("knee"),))
    assert "pendulum" in caught.value.where
    assert caught.value.fix
