"""What an experiment is expected to tell, against least squares and random draws."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from morph.body.load import load
from morph.experiment_design.excitation import FREE_LINK, MARGIN, excitations
from morph.experiment_design.plan import separations_of
from morph.experiment_design.separation import power
from morph.physics.effect import Effect
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.physics.joint.stribeck_friction import StribeckFriction
from morph.physics.joint.viscous_friction import ViscousFriction

READINGS = 60


def test_nats_are_half_the_square_that_no_shape_of_the_rival_explains() -> None:
    rng = np.random.default_rng(4)
    grids: list[tuple[Effect, ...]] = [
        (ViscousFriction(joint="a", b=0.7),),
        (CoulombFriction(joint="a"), CoulombFriction(joint="a")),
        (StribeckFriction(joint="a", c=0.2, s=0.5),),
    ]
    # One column for each strength: 1, then 1 and 1, then 2 of level and static friction.
    widths = [len(effect.strengths) for grid in grids for effect in grid]
    columns = rng.normal(size=(READINGS, 1 + sum(widths)))
    columns[:, 2] += 2.0 * columns[:, 1]
    found = separations_of(columns.T @ columns, grids, [(0, 1), (0, None), (2, 0)])

    def unexplained(change: np.ndarray, by: np.ndarray) -> float:
        left = change - by @ np.linalg.lstsq(by, change, rcond=None)[0]
        return float(left @ left)

    viscous = 0.7 * columns[:, 1]
    law = grids[2][0]
    stribeck = columns[:, 4 : 4 + len(law.strengths)] @ law.coefficients
    due = [
        0.5 * min(unexplained(viscous, columns[:, [at]]) for at in (2, 3)),
        0.5 * float(viscous @ viscous),
        0.5 * unexplained(stribeck, columns[:, [1]]),
    ]
    # Sums of 60 products: 1e-14 of their size.
    assert [each.nats for each in found] == pytest.approx(due, rel=1e-10)
    assert [each.rival for each in found] == [
        "coulomb_friction@a", "none", "viscous_friction@a",
    ]  # fmt: skip


@pytest.mark.parametrize("nats", [5.0, 10.0, 20.0])
def test_the_power_is_how_often_refits_decide(nats: float) -> None:
    rng = np.random.default_rng(1)
    law, rival = rng.normal(size=(2, READINGS))
    rival += 0.8 * law
    left = law - rival * (rival @ law) / (rival @ rival)
    size = np.sqrt(2.0 * nats / float(left @ left))
    drawn = size * law + rng.normal(size=(20_000, READINGS))

    def square(columns: np.ndarray) -> np.ndarray:
        return np.asarray((drawn @ columns) ** 2 / (columns @ columns))

    decided = np.mean(0.5 * (square(law) - square(rival)) > 10.0)
    # What each refit takes of the noise, about half a nat, adds to sqrt(2 d) of 3 to 6 nats, and
    # 20000 draws are known to 0.0035.
    assert decided == pytest.approx(power(nats), abs=0.03)


def test_nothing_to_tell_has_no_power() -> None:
    assert power(0.0) == 0.0


def test_motions_keep_within_the_limits_of_joints_and_actuators() -> None:
    robot = load("so101")
    made = excitations(robot, 4.0, 0.002, 3)
    assert {each.kind for each in made} >= {"quick", "slow", "steps", "one: Elbow"}
    for each in made:
        for joint in robot.joints:
            low, high = joint.limits or (-np.inf, np.inf)
            assert low < each.recording[f"{joint.name}.position"].min()
            assert each.recording[f"{joint.name}.position"].max() < high
    again = excitations(robot, 4.0, 0.002, 3)
    for one, other in zip(made, again, strict=True):
        assert np.array_equal(one.recording["Elbow.command"], other.recording["Elbow.command"])


GRIPPER = """
<mujoco model="gripper"><compiler angle="radian"/><worldbody><body>
 <joint name="finger" axis="0 1 0" range="0 {most}" damping="0.05"/>
 <inertial pos="0 0 -0.05" mass="0.1" diaginertia="1e-4 1e-4 1e-4"/></body></worldbody>
 <actuator><position name="servo" joint="finger" kp="2" ctrlrange="0 {most}"/></actuator></mujoco>
"""


def test_a_servo_at_the_end_of_its_range_moves_about_a_place_inside(tmp_path: Path) -> None:
    path, most = tmp_path / "gripper.xml", 1.2
    path.write_text(GRIPPER.format(most=most))
    planned = excitations(load(path), 8.0, 0.005, 0)
    assert {each.kind for each in planned} == {"quick", "slow", "steps"}
    for each in planned:
        place, told = (each.recording[name] for name in ("finger.position", "servo.command"))
        time = each.recording.channels["servo.command"].time
        assert place[0] == 0.0
        assert told.min() >= 0.0
        assert told.max() <= most
        # About a quarter of the range from its end, and off that end once it is there.
        there = time > 3.0
        assert told[there].min() < 0.25 * most < told[there].max()
        assert place[1:][there].min() > MARGIN * most


def test_a_vehicle_that_floats_stays_near(tmp_path: Path) -> None:
    path = tmp_path / "vehicle.xml"
    path.write_text(
        "<mujoco><worldbody><body name='hull' gravcomp='1'><freejoint name='float'/>"
        "<inertial pos='0 0 0' mass='2' diaginertia='.1 .1 .1'/><site name='bow' pos='.1 .1 0'/>"
        "</body></worldbody><actuator>"
        "<motor name='jet' site='bow' gear='1 0 0 0 0 0' ctrlrange='-5 5'/></actuator></mujoco>"
    )
    made = excitations(load(path), 4.0, 0.004, 0)
    assert {each.kind for each in made} == {"quick", "slow", "steps", "coast"}
    for each in made:
        place = np.stack([each.recording[f"hull.position.{axis}"] for axis in "xyz"], axis=1)
        # Turned by less than half a turn, the real part of its quaternion stays positive.
        assert np.abs(place - place[0]).max() <= FREE_LINK
        assert each.recording["hull.orientation.w"].min() > 0.0
    assert max(np.ptp(each.recording["hull.position.x"]) for each in made) > 0.01
