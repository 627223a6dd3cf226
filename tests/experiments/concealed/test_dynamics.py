"""The benchmark's own dynamics against closed forms and two other libraries."""

from __future__ import annotations

import ast
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from scipy.special import ellipk

from experiments.concealed import fields
from experiments.concealed.mechanism import STANDARD_GRAVITY, Mechanism
from experiments.concealed.mechanisms import FAMILIES, draw_mechanism
from experiments.concealed.mjcf import describe
from experiments.concealed.plant import Array, Plant
from experiments.concealed.simulate import GRID, Motion, Run, simulate

EVERY = pytest.mark.parametrize("family", FAMILIES)


def drawn(family: str) -> Mechanism:
    mechanism = draw_mechanism(family, np.random.default_rng(5))
    return replace(mechanism, plant=mechanism.plant.with_joint(slice(None), most=50.0))


def let_go(plant: Plant, start: Array, seconds: float, *, finer: int = 1) -> Motion:
    """Return the motion from rest without drives."""
    n, grids = plant.count, round(seconds / GRID)
    none = np.zeros((1, n))
    run = Run(
        ticks=np.array([0]), feed=none, reference=none, noise=none, start=np.array(start),
        grids=grids,
    )  # fmt: skip
    loose = plant.with_joint(slice(None), drive=0.0, track_p=0.0, track_d=0.0)
    return simulate(loose, run, finer=finer)


def test_the_generator_knows_nothing_of_the_physics_that_it_judges() -> None:
    # Errors, files and where a compiler is: nothing of these says how a robot moves.
    allowed = {"morph.errors", "morph.files", "morph.native.compilers"}
    for path in Path(fields.__file__).parent.glob("*.py"):
        if path.stem in ("solvers", "baselines", "predict", "__main__"):
            continue
        for node in ast.walk(ast.parse(path.read_text())):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            for name in names:
                foreign = name.split(".")[0] in ("morph", "mujoco", "pinocchio")
                assert name in allowed or not foreign, (path, name)


@EVERY
def test_mass_matrix_and_bias_agree_with_mujoco_on_the_description(family: str) -> None:
    mechanism, rng = drawn(family), np.random.default_rng(1)
    model = mujoco.MjModel.from_xml_string(describe(mechanism, family))
    data = mujoco.MjData(model)
    q = rng.uniform(-2, 2, (5, model.nq))
    v = rng.uniform(-3, 3, (5, model.nv))
    mass, bias = mechanism.plant.mass_and_bias(q, v)
    for i in range(5):
        data.qpos[:], data.qvel[:] = q[i], v[i]
        mujoco.mj_forward(model, data)
        columns = np.zeros((model.nv, model.nv))
        for j in range(model.nv):
            mujoco.mj_mulM(model, data, columns[j], np.eye(model.nv)[j])
        rotor = np.diag(mechanism.plant.of_joint("rotor"))
        # The description holds ten digits of figures up to 10.
        np.testing.assert_allclose(mass[i] + rotor, columns, atol=1e-7)
        np.testing.assert_allclose(bias[i], data.qfrc_bias, atol=1e-6)


@EVERY
def test_mass_matrix_and_bias_agree_with_pinocchio(family: str) -> None:
    pin = pytest.importorskip("pinocchio")
    plant, rng = drawn(family).plant, np.random.default_rng(2)
    model, parent = pin.Model(), 0
    model.gravity.linear = plant.gravity
    for i in range(plant.count):
        kind = pin.JointModelPrismaticUnaligned if plant.slide[i] else None
        joint = (kind or pin.JointModelRevoluteUnaligned)(plant.axis[i])
        placed = pin.SE3(plant.rotation[i], plant.origin[i])
        parent = model.addJoint(parent, joint, placed, f"joint_{i}")
        body = pin.Inertia(float(plant.of_body("mass")[i]), plant.com[i], plant.inertia[i])
        model.appendBodyToJoint(parent, body, pin.SE3.Identity())
    data = model.createData()
    q, v = rng.uniform(-2, 2, plant.count), rng.uniform(-3, 3, plant.count)
    mass, bias = plant.mass_and_bias(q[None], v[None])
    full = pin.crba(model, data, q)
    full = np.triu(full) + np.triu(full, 1).T
    np.testing.assert_allclose(mass[0], full, atol=1e-10)
    np.testing.assert_allclose(bias[0], pin.nle(model, data, q, v), atol=1e-9)


def test_a_pendulum_swings_with_the_period_of_the_elliptic_integral() -> None:
    plant = drawn("pendulum").plant
    mass, arm = float(plant.of_body("mass")[0]), plant.com[0]
    across = arm - (arm @ plant.axis[0]) * plant.axis[0]
    moment = mass * STANDARD_GRAVITY * float(np.linalg.norm(across))
    inertia = float(plant.mass_and_bias(np.zeros((1, 1)), np.zeros((1, 1)))[0][0, 0, 0])
    down = _rest(plant)
    motion = let_go(plant, np.array([down + 1.2]), 4.0)
    swing = motion.q[:, 0] - down
    crossing = np.flatnonzero((swing[:-1] > 0) & (swing[1:] <= 0))[:2]
    when = [(i + swing[i] / (swing[i] - swing[i + 1])) * GRID for i in crossing]
    period = 4 * np.sqrt(inertia / moment) * ellipk(np.sin(0.6) ** 2)
    # Second order: (rate * step)^2 / 24 = (5 * 2.5e-4)^2 / 24 = 7e-8 of the period; the linear
    # interpolation adds less than that.
    assert when[1] - when[0] == pytest.approx(period, rel=1e-6)


def _rest(plant: Plant) -> float:
    """Return the angle at which a pendulum hangs, by bisection on the force of gravity."""
    low, high = -0.8, 0.8
    for _ in range(60):
        middle = 0.5 * (low + high)
        force = plant.mass_and_bias(np.array([[middle]]), np.zeros((1, 1)))[1][0, 0]
        low, high = (low, middle) if force > 0 else (middle, high)
    return 0.5 * (low + high)


def _energy(plant: Plant, motion: Motion, at: int) -> float:
    """Return kinetic and potential energy; the latter by the work of gravity's force."""
    q, v = motion.q[at : at + 1], motion.v[at : at + 1]
    mass, _ = plant.mass_and_bias(q, v)
    model_height = 0.0
    R, p = {-1: np.eye(3)}, {-1: np.zeros(3)}
    for i in range(plant.count):
        up, a = int(plant.parent[i]), plant.axis[i]
        turn = np.eye(3)
        slide = np.zeros(3)
        if plant.slide[i]:
            slide = a * q[0, i]
        else:
            K = np.cross(np.eye(3), a)
            turn = np.eye(3) + np.sin(q[0, i]) * K + (1 - np.cos(q[0, i])) * K @ K
        R[i] = R[up] @ plant.rotation[i] @ turn
        p[i] = p[up] + R[up] @ plant.origin[i] + R[up] @ plant.rotation[i] @ slide
        model_height += float(plant.of_body("mass")[i] * (p[i] + R[i] @ plant.com[i])[2])
    rotor = plant.of_joint("rotor")
    kinetic = 0.5 * (v[0] @ mass[0] @ v[0] + (rotor * v[0] ** 2).sum())
    return float(kinetic + STANDARD_GRAVITY * model_height)


@EVERY
def test_energy_is_conserved_without_drives_and_damping(family: str) -> None:
    mechanism = drawn(family)
    plant = mechanism.plant.with_joint(slice(None), viscous=0.0)
    motion = let_go(plant, mechanism.home + 0.7 * (plant.slide == 0), 1.0)
    energies = [_energy(plant, motion, at) for at in range(0, len(motion.q), 400)]
    kinetic = max(
        0.5 * float(v @ plant.mass_and_bias(q[None], v[None])[0][0] @ v)
        for q, v in zip(motion.q[::400], motion.v[::400], strict=True)
    )
    # Second order with rates up to 40 rad/s: (40 * 2.5e-4)^2 = 1e-4 of the energy that moves.
    assert np.ptp(energies) < 1e-4 * kinetic


def test_a_falling_leg_moves_as_mujoco_s_fourth_order_integrator_says() -> None:
    mechanism = drawn("leg")
    model = mujoco.MjModel.from_xml_string(describe(mechanism, "leg"))
    model.opt.integrator, model.opt.timestep = mujoco.mjtIntegrator.mjINT_RK4, 5e-4
    data = mujoco.MjData(model)
    data.qpos[:] = mechanism.home + 0.5
    for _ in range(1000):
        mujoco.mj_step(model, data)
    ours = let_go(mechanism.plant, mechanism.home + 0.5, 0.5)
    np.testing.assert_allclose(ours.q[-1], data.qpos, atol=2e-5)


def test_halving_the_step_quarters_the_error_of_a_smooth_motion() -> None:
    mechanism = drawn("double_pendulum")
    ends = [let_go(mechanism.plant, np.array([1.0, 0.5]), 1.0, finer=f).q[-1] for f in (1, 2, 8)]
    coarse, fine = (np.abs(end - ends[2]).max() for end in ends[:2])
    assert 3.0 < coarse / fine < 5.5
