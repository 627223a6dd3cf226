"""The quadruped of four-bars against the closed form, and shapes against stated inertias."""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np
import pytest

from morph.arrays import Array
from morph.body import shelf
from morph.body.linkage import FourBar
from morph.body.load import load
from morph.body.servo import servo

LEGS = ("front_left", "rear_left", "rear_right", "front_right")
WORLD = dict(zip(LEGS, (45.0, 135.0, 225.0, 315.0), strict=True))
"""Where each leg points, degrees from forward."""

# The drawing as its card states it: outward and up from the core, m.
SERVO, HIP = np.array([0.058, 0.010]), np.array([0.095, 0.0])
CRANK_PIN, LEVER_PIN = np.array([0.058, 0.030]), np.array([0.091, 0.034])
KNEE = HIP + np.array([0.085, 0.030])
KNEE_CRANK_PIN = HIP + np.array([-0.008, 0.019])
KNEE_LEVER_PIN = KNEE + np.array([-0.012, 0.033])
FOOT = KNEE + np.array([0.020, -0.120])
HIP_BAR = FourBar.of(SERVO, CRANK_PIN, LEVER_PIN, HIP)
KNEE_BAR = FourBar.of(HIP, KNEE_CRANK_PIN, KNEE_LEVER_PIN, KNEE)


def heading(vector: Array) -> float:
    return math.atan2(vector[1], vector[0])


def turned(vector: Array, angle: float) -> Array:
    cosine, sine = math.cos(angle), math.sin(angle)
    return np.array([cosine * vector[0] - sine * vector[1], sine * vector[0] + cosine * vector[1]])


def leg_angles(hip_servo: float, knee_servo: float) -> tuple[float, float]:
    """Return by how much thigh and shank have turned from home, by two four-bars."""
    ground = heading(HIP - SERVO)
    crank = heading(CRANK_PIN - SERVO) - ground + hip_servo
    thigh = float(HIP_BAR.rocker_angle(crank)) + ground - heading(LEVER_PIN - HIP)
    # The knee's ground is the thigh, which turns; its crank is driven from the core.
    ground = heading(KNEE - HIP)
    crank = heading(KNEE_CRANK_PIN - HIP) - ground + knee_servo - thigh
    knee = float(KNEE_BAR.rocker_angle(crank)) + ground - heading(KNEE_LEVER_PIN - KNEE)
    return thigh, thigh + knee


def foot(hip_servo: float, knee_servo: float) -> Array:
    """Return where a foot is, outward and up, m."""
    thigh, shank = leg_angles(hip_servo, knee_servo)
    return HIP + turned(KNEE - HIP, thigh) + turned(FOOT - KNEE, shank)


def description(name: str) -> str:
    return (shelf.builtin_shelf() / name / "robot.xml").read_text()


def held(gravity: float = 0.0) -> Any:
    """Return the quadruped with its core held in the air."""
    spec = mujoco.MjSpec.from_string(description("quadruped_four_bar"))
    spec.delete(spec.joint("root"))
    spec.option.gravity = (0.0, 0.0, -gravity)
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    return spec.compile()


def seen(model: Any, data: Any, leg: str) -> Array:
    """Return where a leg's foot is in its own plane, and how far off it, m."""
    outward = np.deg2rad(WORLD[leg])
    place = data.site(f"{leg}_foot").xpos - model.body("core").pos
    across = place[1] * np.cos(outward) - place[0] * np.sin(outward)
    return np.array([place[0] * np.cos(outward) + place[1] * np.sin(outward), place[2], across])


def test_at_home_every_loop_closes() -> None:
    model = mujoco.MjModel.from_xml_string(description("quadruped_four_bar"))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    for leg in LEGS:
        for joint in ("hip", "knee"):
            rod, lever = f"{leg}_{joint}_rod_pin", f"{leg}_{joint}_pin"
            across = data.site(rod).xpos - data.site(lever).xpos
            # Positions are written to twelve digits, so to 1e-13 m, and add up.
            assert np.linalg.norm(across) < 1e-11
    assert np.abs(data.efc_pos[data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY]).max() < 1e-9


def test_the_pins_leave_eight_freedoms_to_the_legs_and_six_to_the_core() -> None:
    model = mujoco.MjModel.from_xml_string(description("quadruped_four_bar"))
    model.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    jacobian = data.efc_J.reshape(-1, model.nv)
    # Of a pin's three rows the one across its plane says nothing: 24 rows, rank 16.
    assert len(jacobian) == 24
    assert model.nv - np.linalg.matrix_rank(jacobian, tol=1e-9) == 8 + 6


def test_the_loops_close_over_the_whole_range_of_both_servos() -> None:
    model = held()
    low, high = model.joint("front_left_hip_servo").range
    assert (low, high) == tuple(model.joint("front_left_knee_servo").range)
    worst = math.pi
    for hip_servo in np.linspace(low, high, 41):
        ground = heading(HIP - SERVO)
        crank = heading(CRANK_PIN - SERVO) - ground + hip_servo
        thigh, _ = leg_angles(hip_servo, 0.0)
        drive = heading(KNEE_CRANK_PIN - HIP) - heading(KNEE - HIP) - thigh
        worst = min(
            worst,
            float(HIP_BAR.transmission_angle(crank)),
            float(KNEE_BAR.transmission_angle(drive + np.linspace(low, high, 41)).min()),
        )
    # The card says 44 degrees and more; below 40 a four-bar is held to be a poor drive.
    assert math.degrees(worst) > 44.0


@pytest.mark.parametrize("seed", range(4))
def test_each_foot_moves_as_two_four_bars_say(seed: int) -> None:
    model, rng = held(), np.random.default_rng(seed)
    data = mujoco.MjData(model)
    targets = rng.uniform(-0.75, 0.75, size=model.nu)
    for step in range(3000):
        data.ctrl[:] = targets * min(1.0, step / 1000)
        mujoco.mj_step(model, data)
    for leg in LEGS:
        hip_servo, knee_servo = (
            float(data.joint(f"{leg}_{joint}_servo").qpos[0]) for joint in ("hip", "knee")
        )
        expected = foot(hip_servo, knee_servo)
        # Feet move by centimetres. Without load the pins rest within 1e-7 m, and a lever
        # of 0.03 m magnifies that to the foot, 0.15 m away, by 5.
        assert seen(model, data, leg) == pytest.approx([*expected, 0.0], abs=1e-6)
    assert data.qpos[model.actuator_trnid[:, 0]] == pytest.approx(targets, abs=0.01)


def test_a_load_on_a_foot_reaches_the_servos_by_virtual_work() -> None:
    model = held()
    data, load, h = mujoco.MjData(model), np.array([0.3, 2.0]), 1e-6
    outward = np.deg2rad(WORLD["front_left"])
    shank = model.body("front_left_shank").id
    for _ in range(3000):
        force = np.array([load[0] * np.cos(outward), load[0] * np.sin(outward), load[1]])
        arm = data.site("front_left_foot").xpos - data.xipos[shank]
        data.xfrc_applied[shank] = [*force, *np.cross(arm, force)]
        mujoco.mj_step(model, data)
    at = [float(data.joint(f"front_left_{joint}_servo").qpos[0]) for joint in ("hip", "knee")]
    by_hip = (foot(at[0] + h, at[1]) - foot(at[0] - h, at[1])) / (2 * h)
    by_knee = (foot(at[0], at[1] + h) - foot(at[0], at[1] - h)) / (2 * h)
    torques = [data.actuator(f"front_left_{joint}_servo").force[0] for joint in ("hip", "knee")]
    # Under 2 N the pins give way by micrometres, of levers of 0.02 m: 1e-3 of the torque.
    assert torques == pytest.approx([-load @ by_hip, -load @ by_knee], rel=2e-3)


def test_equal_commands_left_and_right_move_mirrored_feet() -> None:
    model = held(gravity=9.81)
    data = mujoco.MjData(model)
    for end, hip_servo, knee_servo in (("front", 0.4, -0.3), ("rear", -0.2, 0.5)):
        for side in ("left", "right"):
            data.ctrl[model.actuator(f"{end}_{side}_hip_servo").id] = hip_servo
            data.ctrl[model.actuator(f"{end}_{side}_knee_servo").id] = knee_servo
    for _ in range(500):
        mujoco.mj_step(model, data)
    for end in ("front", "rear"):
        left, right = (data.site(f"{end}_{side}_foot").xpos for side in ("left", "right"))
        # Mirrored sums in another order: rounding of 1e-15, grown by a second of motion.
        assert left * (1, -1, 1) == pytest.approx(right, abs=1e-9)


def test_it_stands_on_its_feet_with_the_servos_at_home() -> None:
    spec = mujoco.MjSpec.from_string(description("quadruped_four_bar"))
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[1, 1, 0.1])
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    model = spec.compile()
    data = mujoco.MjData(model)
    for _ in range(500):
        mujoco.mj_step(model, data)
    touching = {model.geom(contact.geom2).name for contact in data.contact}
    assert touching == {f"{leg}_foot" for leg in LEGS}
    # Home is 0.098 m. A leg bears 2 N; by virtual work its servos bear 0.1 N m and give way
    # by 0.1 / 11.1 = 0.01 rad, which moves the foot by 1 or 2 mm.
    assert data.body("core").xpos[2] == pytest.approx(0.098, abs=0.003)
    pins = data.efc_pos[data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY]
    assert np.abs(pins).max() < 1e-5


@pytest.mark.parametrize("name", ["humanoid", "humanoid_skateboard", "quadruped_four_bar"])
def test_stated_inertias_are_those_that_mujoco_finds_in_the_shapes(name: str) -> None:
    text = description(name)
    spelled = 'inertiafromgeom="false"'
    assert spelled in text
    stated = mujoco.MjModel.from_xml_string(text)
    found = mujoco.MjModel.from_xml_string(text.replace(spelled, 'inertiafromgeom="true"'))
    assert stated.body_mass == pytest.approx(found.body_mass, rel=1e-12)
    # Twelve digits are written: 5e-12 of centres below 0.2 m, and of the greatest moment.
    assert np.abs(stated.body_ipos - found.body_ipos).max() < 1e-11
    for body in range(1, stated.nbody):
        tensors = []
        for model in (stated, found):
            axes = np.zeros(9)
            mujoco.mju_quat2Mat(axes, model.body_iquat[body])
            axes = axes.reshape(3, 3)
            tensors.append(axes @ np.diag(model.body_inertia[body]) @ axes.T)
        assert np.abs(tensors[0] - tensors[1]).max() < 1e-10 * np.abs(tensors[1]).max()


# Stall torque, N m, no-load speed, rev/min, and gear of the e-manual, all at 12 V.
MANUAL = {
    "MX-28": (2.5, 55.0, 193.0),
    "MX-64": (6.0, 63.0, 200.0),
    "AX-12": (1.5, 59.0, 254.0),
    "AX-18": (1.8, 97.0, 254.0),
}


@pytest.mark.parametrize("name", MANUAL)
def test_a_servo_is_what_its_manual_and_its_derivation_say(name: str) -> None:
    stall, speed, gear = MANUAL[name]
    known = servo(name)
    assert known is not None
    # Written to three digits: 0.5 of the last.
    assert known.limit == stall
    assert known.kv == pytest.approx(stall / (speed * 2 * math.pi / 60), rel=5e-3)
    slope = 32 * 0.158 if name.startswith("MX") else 1 / math.radians(32 * 0.29)
    assert known.kp == pytest.approx(slope * stall, rel=5e-3)
    if name != "MX-64":  # Whose armature was identified: 0.01195 kg m2.
        assert known.armature == pytest.approx(0.868e-7 * gear**2, rel=5e-3)


@pytest.mark.parametrize("name", ["humanoid", "humanoid_skateboard", "quadruped_four_bar"])
def test_the_servos_of_a_description_are_those_that_its_card_names(name: str) -> None:
    robot = load(name)
    model = mujoco.MjModel.from_xml_string(robot.mjcf)
    assert robot.card is not None
    for motor in robot.card.motor:
        known, actuator = servo(motor.model), model.actuator(motor.actuator)
        assert known is not None
        assert motor.limit == known.limit
        gains = (actuator.gainprm[0], -actuator.biasprm[2], actuator.forcerange[1])
        assert gains == (known.kp, known.kv, known.limit)
        driven = model.joint(actuator.trnid[0])
        assert model.dof_armature[driven.dofadr[0]] == known.armature
