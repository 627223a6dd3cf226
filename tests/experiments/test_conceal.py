"""Concealed cases: the mechanics against closed forms and a second library."""

from __future__ import annotations

import ast
from pathlib import Path

import numpy as np
import pytest

from experiments.conceal import excite
from experiments.conceal.cartpole import Cartpole
from experiments.conceal.double_pendulum import DoublePendulum
from experiments.conceal.equations import Array, Equations, Parameters
from experiments.conceal.laws import Laws, neutral
from experiments.conceal.march import STEP, Drive, Motion, march
from experiments.conceal.mechanisms import MECHANISMS
from experiments.conceal.pendulum import Pendulum
from morph.body.load import load
from morph.body.twin import twin_of

EVERY = pytest.mark.parametrize("equations", MECHANISMS.values(), ids=list(MECHANISMS))


def one_row(equations: Equations, **changed: float) -> Parameters:
    """Return nominal parameters with some changed, for one row."""
    return {k: np.array([x]) for k, x in (equations.nominal() | changed).items()}


def moved(
    equations: Equations,
    laws: Laws,
    q: list[float],
    v: list[float],
    *,
    seconds: float = 1.0,
    torque: float = 0.0,
    **changed: float,
) -> Motion:
    """Return one row's motion under a constant torque at the first joint."""
    tau = np.zeros((round(seconds / STEP), len(q), 1))
    tau[:, 0] = torque
    start, speed = np.array(q)[:, None], np.array(v)[:, None]
    return march(equations, one_row(equations, **changed), laws, tau, start, speed)


def rotor(law: str, **parameters: float) -> Laws:
    """Return laws with one effect at the only joint of a pendulum."""
    return neutral(1, 1).put(law, 0, 0, parameters)


def test_the_mechanics_come_from_nowhere_else() -> None:
    allowed = {"morph.errors", "morph.files"}
    for path in Path(excite.__file__).parent.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            for name in names:
                assert name in allowed or name.split(".")[0] not in ("morph", "mujoco"), path


@EVERY
def test_mass_matrix_and_bias_agree_with_pinocchio(equations: Equations) -> None:
    pin = pytest.importorskip("pinocchio")
    model = twin_of(load(equations.name))
    data = model.createData()
    rng, p = np.random.default_rng(3), one_row(equations)
    for _ in range(20):
        q, v = rng.uniform(-2, 2, model.nq), rng.uniform(-3, 3, model.nv)
        # The twin's rotors count in crba; damping is the description's and stays out of rnea.
        expected = np.array(pin.crba(model, data, q))
        packed = equations.mass(q[:, None], p)
        upper = expected[np.triu_indices(model.nv)]
        np.testing.assert_allclose([float(m[0]) for m in packed], upper, atol=1e-9)
        damping = np.array([p[f"d_{joint}"][0] for joint in equations.joints])
        found = equations.bias(q[:, None], v[:, None], p)[:, 0] - damping * v
        np.testing.assert_allclose(found, pin.nle(model, data, q, v), atol=1e-9)


@EVERY
def test_nominal_values_agree_with_the_description(equations: Equations) -> None:
    robot, nominal = load(equations.name), equations.nominal()
    keys = [k for k in ("M", "m", "m1", "m2") if k in nominal]
    assert [nominal[k] for k in keys] == pytest.approx([link.mass for link in robot.links])
    swinging = robot.links[-len([k for k in nominal if k.startswith("r")]) :]
    depth = [nominal[k] for k in ("r", "r1", "r2") if k in nominal]
    assert depth == pytest.approx([-link.com[2] for link in swinging])
    inertia = [nominal[k] for k in ("I", "I1", "I2") if k in nominal]
    assert inertia == pytest.approx([link.inertia[1] for link in swinging], rel=1e-9)
    assert equations.joints == tuple(joint.name for joint in robot.joints)
    assert equations.actuators == tuple(actuator.name for actuator in robot.actuators)
    twin = twin_of(robot)
    assert [nominal[f"J_{j}"] for j in equations.joints] == pytest.approx(list(twin.armature))
    assert [nominal[f"d_{j}"] for j in equations.joints] == pytest.approx(list(twin.damping))
    assert nominal["g"] == pytest.approx(-float(twin.gravity.linear[2]))


@EVERY
def test_energy_is_conserved_without_friction_and_commands(equations: Equations) -> None:
    n = len(equations.joints)
    p = one_row(equations, **{f"d_{joint}": 0.0 for joint in equations.joints})
    start = np.full((n, 1), 1.2) * (np.array(equations.kinds) == "hinge")[:, None]
    motion = march(equations, p, neutral(n, 1), np.zeros((30_000, n, 1)), start, 0 * start)
    energy = [
        float(equations.energy(q, v, p)[0])
        for q, v in zip(motion.q[::100], motion.v[::100], strict=True)
    ]
    # The marching is of second order: the energy ripples by about (rate * step)^2, with
    # rates up to 22 rad/s in the double pendulum (22e-4)^2 = 5e-6, and does not drift.
    assert np.ptp(energy) < 5e-6 * energy[0]


@pytest.mark.parametrize("share", [1.01, 5.0])
def test_a_pendulum_whose_friction_outweighs_gravity_stays_exactly_put(share: float) -> None:
    # m g r sin q = 1 * 9.81 * 0.5 * sin 0.3
    laws = rotor("coulomb_friction", c=share * 9.81 * 0.5 * np.sin(0.3))
    motion = moved(Pendulum(), laws, [0.3], [0.0])
    assert (motion.q == 0.3).all()
    assert (motion.v == 0.0).all()


def test_a_pendulum_that_outweighs_its_friction_falls() -> None:
    laws = rotor("coulomb_friction", c=0.99 * 9.81 * 0.5 * np.sin(0.3))
    assert moved(Pendulum(), laws, [0.3], [0.0]).q[-1, 0, 0] < 0.299


def test_two_rubbing_joints_stick_together_below_both_levels() -> None:
    p = one_row(DoublePendulum())
    q = np.array([[0.4], [0.2]])
    weight = np.abs(DoublePendulum().bias(q, 0 * q, p))[:, 0]
    laws = neutral(2, 1)
    for joint in range(2):
        laws = laws.put("coulomb_friction", joint, 0, {"c": 1.05 * float(weight[joint])})
    motion = moved(DoublePendulum(), laws, [0.4, 0.2], [0.0, 0.0], seconds=0.04)
    assert (motion.q == q).all()


def test_a_stuck_cart_leaves_its_pole_a_fixed_pendulum() -> None:
    laws = neutral(2, 1).put("coulomb_friction", 0, 0, {"c": 50.0})
    motion = moved(Cartpole(), laws, [0.0, 0.05], [0.0, 0.0], seconds=2.0)
    assert (motion.q[:, 0] == 0.0).all()
    # A rod's small swings have the rate sqrt(3 g / 2 l) = sqrt(3 * 9.82 / 1.0); the
    # period at 0.05 rad is longer by 0.05^2 / 16 = 1.6e-4, a phase of 1.7e-3 in 2 s.
    expected = 0.05 * np.cos(np.sqrt(3 * 9.82) * np.arange(2001) * 1e-3)
    np.testing.assert_allclose(motion.q[:, 1, 0], expected, atol=0.05 * 2e-3)


def decay(law: str, start: float, **parameters: float) -> tuple[Array, float]:
    """Return a rotor's speeds every ms for a second without gravity, and its inertia."""
    motion = moved(Pendulum(), rotor(law, **parameters), [0.0], [start], g=0.0)
    return motion.v[:, 0, 0], 0.001 + 0.25


TIMES = np.arange(1001) * 1e-3


def test_viscous_friction_decays_exponentially() -> None:
    v, inertia = decay("viscous_friction", 3.0, b=0.5)
    # Second-order local error (b/J step)^2 = 4e-8 per unit time.
    np.testing.assert_allclose(v, 3.0 * np.exp(-0.5 / inertia * TIMES), rtol=1e-4)


def test_coulomb_friction_stops_a_rotor_in_a_straight_line() -> None:
    v, inertia = decay("coulomb_friction", 1.0, c=0.5)
    # It stops at v J / c = 0.502 s; the step of 0.1 ms allows 2e-4 rad/s.
    np.testing.assert_allclose(v, np.maximum(1.0 - 0.5 / inertia * TIMES, 0.0), atol=2e-4)
    assert v[-1] == 0.0


def test_stribeck_friction_at_high_speed_is_coulomb_friction() -> None:
    fast, _ = decay("stribeck_friction", 5.0, c=0.3, s=0.6, vs=0.1)
    plain, _ = decay("coulomb_friction", 5.0, c=0.3)
    np.testing.assert_array_equal(fast, plain)


@pytest.mark.parametrize(("torque", "moves"), [(0.59, False), (0.61, True)])
def test_stribeck_friction_at_rest_holds_up_to_s(torque: float, moves: bool) -> None:
    laws = rotor("stribeck_friction", c=0.3, s=0.6, vs=0.1)
    motion = moved(Pendulum(), laws, [0.0], [0.0], torque=torque, g=0.0)
    assert bool((motion.q != 0.0).any()) == moves


def test_quadratic_damping_decays_as_a_hyperbola() -> None:
    v, inertia = decay("quadratic_damping", -3.0, b2=0.2)
    np.testing.assert_allclose(v, -3.0 / (1 + 0.2 * 3.0 / inertia * TIMES), rtol=1e-4)


def test_joint_stiffness_swings_about_its_rest() -> None:
    laws = rotor("joint_stiffness", k=2.0, q0=0.2)
    motion = moved(Pendulum(), laws, [0.5], [0.0], g=0.0)
    expected = 0.2 + 0.3 * np.cos(np.sqrt(2.0 / 0.251) * TIMES)
    np.testing.assert_allclose(motion.q[:, 0, 0], expected, atol=1e-6)


def test_armature_adds_to_inertia() -> None:
    motion = moved(Pendulum(), rotor("armature", J=0.251), [0.0], [0.0], torque=1.0, g=0.0)
    assert motion.q[-1, 0, 0] == pytest.approx(0.5 / 0.502, rel=1e-9)


def step_command(law: str, **parameters: float) -> Array:
    """Return the torque, every 0.1 ms, that a unit step at 0.1 s produces."""
    drive = Drive(ticks=(np.array([0.0, 0.1]),), commands=(np.array([[0.0, 1.0]]),))
    return drive.produced(rotor(law, **parameters), np.zeros(1), 3000, STEP)[:, 0, 0]


def test_delay_shifts_a_command() -> None:
    torque = step_command("actuator_delay", T=0.03)
    np.testing.assert_allclose(torque, np.arange(3000) >= 1300, atol=1e-9)


def test_lag_is_first_order() -> None:
    torque = step_command("actuator_lag", T=0.02)
    after = (np.arange(1000, 3000) - 1000 + 1) * STEP
    np.testing.assert_allclose(torque[1000:], 1 - np.exp(-after / 0.02), atol=1e-9)


def test_torque_scale_multiplies() -> None:
    assert step_command("torque_scale", gain=0.6)[-1] == pytest.approx(0.6)
