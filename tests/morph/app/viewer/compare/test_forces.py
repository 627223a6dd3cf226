"""Forces along a run against statics, Archimedes and Newton's second law."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from morph.app.picture.times import nearest_samples
from morph.app.viewer.compare.forces import Forces, forces
from morph.app.viewer.compare.run import SimulatedRun, ran
from morph.app.viewer.motion import RATE
from morph.body.robot import Robot
from morph.physics.fluid.added_mass import AddedMass
from morph.physics.fluid.buoyancy import Buoyancy
from morph.physics.fluid.fluid_current import FluidCurrent
from morph.physics.fluid.quadratic_drag import QuadraticDrag
from morph.policy.pattern import Swing, pattern
from morph.task.start import Start
from morph.task.task import Task

G = 9.81
FIN = """<body name="fin" pos="0 0 0.3"><joint name="fin" axis="0 1 0"/>
<geom type="box" size="0.05 0.05 0.2" pos="0 0 0.2" mass="0.5" contype="0"
conaffinity="0"/></body>"""
SERVO = '<motor name="fin" joint="fin" ctrllimited="true" ctrlrange="-1 1"/>'


def body(height: float, mass: float) -> str:
    """A box of some mass that floats at a height, with a fin on top."""
    return f"""<body name="box" pos="0 0 {height}"><freejoint/>
    <geom type="box" size="0.2 0.2 0.2" mass="{mass}"/>{FIN}</body>"""


def told(task: Task, torque: float = 0.0) -> tuple[SimulatedRun, Forces]:
    """What happens when the fin's motor is told a constant torque, N m."""
    swings = {"fin": Swing(offset=torque)}
    run = ran(task, pattern(task.robot, swings, period=task.period))
    return run, forces(run)


def total(arrows: np.ndarray) -> np.ndarray:
    """The sum of vectors in each picture, (pictures, 3)."""
    return np.asarray(np.nansum(arrows[..., 1, :], axis=1))


def test_contacts_carry_the_weight_of_a_box_at_rest_wherever_the_floor_stands_in_the_file(
    made: Callable[..., Robot], asked: Callable[..., Task]
) -> None:
    floor = '<geom name="ground" type="plane" size="5 5 1"/>'
    # Of two geoms MuJoCo takes the one of the earlier type first, the plane: hence also a floor
    # that is a box, which comes second of a sphere.
    slab = '<geom name="ground" type="box" size="5 5 1" pos="0 0 -1"/>'
    ball = body(0.2, 3.0).replace('type="box" size="0.2 0.2 0.2"', 'type="sphere" size="0.2"')
    for worldbody in (floor + body(0.2, 3.0), slab + ball):
        robot = made(worldbody, SERVO)
        run, found = told(asked(robot))
        # 3.5 kg; the contact is soft and comes to rest within the first half second.
        weight = 3.5 * G
        assert total(found.contact)[-1] == pytest.approx([0.0, 0.0, weight], abs=1e-3 * weight)
        assert found.fluid.shape[1] == found.buoyancy.shape[1] == 0
        # They press from where the body touches the ground.
        place = found.contact[-1, :, 0]
        assert np.abs(place[np.isfinite(place).all(axis=1), 2]).max() < 2e-3
        assert run.why == ""


def test_a_body_that_falls_feels_no_contact(
    made: Callable[..., Robot], asked: Callable[..., Task]
) -> None:
    _, found = told(asked(made(body(20.0, 3.0), SERVO)))
    assert found.contact.shape[1] == 0


def test_buoyancy_is_the_weight_of_the_water_and_acts_at_its_centre(
    made: Callable[..., Robot], asked: Callable[..., Task]
) -> None:
    robot = made(body(0.0, 3.0), SERVO)
    water = (Buoyancy(body="box", volume=0.002, density=1025.0, cz=0.1),)
    _, found = told(asked(robot, effects=water))
    assert found.buoyancy[0, 0] == pytest.approx(
        np.array([[0.0, 0.0, 0.1], [0.0, 0.0, 1025.0 * 0.002 * G]]), rel=1e-9
    )
    # At rest and with no added mass water does nothing else.
    assert np.abs(found.fluid[0, 0, 1]).max() < 1e-12


def test_at_its_final_speed_drag_carries_what_buoyancy_does_not(
    made: Callable[..., Robot], asked: Callable[..., Task]
) -> None:
    robot = made(body(0.0, 3.0), SERVO)
    water = (Buoyancy(body="box", volume=0.003), QuadraticDrag(body="box", x=9.0, y=9.0, z=9.0))
    # 3.5 kg - 3 kg of water sink: v = sqrt(0.5 g / 9) = 0.738 m/s, by a time of 3.5 / (9 v),
    # half a second; after 6 s rounding is left.
    start = Start(spread=0.0)
    run, found = told(asked(robot, effects=water, start=start, horizon=6.0))
    assert run.velocity[-1, 2] == pytest.approx(-np.sqrt(0.5 * G / 9.0), rel=1e-4)
    assert total(found.fluid)[-1] == pytest.approx([0.0, 0.0, 0.5 * G], abs=1e-3)


def test_all_that_is_drawn_together_accelerates_the_body(
    made: Callable[..., Robot], asked: Callable[..., Task]
) -> None:
    robot = made(body(0.0, 3.0), SERVO)
    water = (
        *(
            AddedMass(body=name, x=2.0, y=1.0, z=3.0, rx=0.1, ry=0.1, rz=0.1)
            for name in ("box", "fin")
        ),
        *(QuadraticDrag(body=name, x=9.0, y=5.0, z=7.0, ry=0.1) for name in ("box", "fin")),
        Buoyancy(body="box", volume=0.002),
        FluidCurrent(x=0.3),
    )
    task = asked(robot, effects=water, step=0.0005)
    run, found = told(task, torque=0.6)
    # Newton: the forces of the water, of gravity and nothing else change the momentum of all
    # links, which a difference of centres over two steps knows without any force.
    import mujoco

    data = mujoco.MjData(run.model)
    mass = run.model.body_mass

    def momentum(at: int) -> np.ndarray:
        data.qpos[:], data.qvel[:] = run.position[at], run.velocity[at]
        mujoco.mj_fwdPosition(run.model, data)
        mujoco.mj_comVel(run.model, data)
        mujoco.mj_subtreeVel(run.model, data)
        return np.array(mass.sum() * data.subtree_linvel[1])

    samples = nearest_samples(run.time, RATE)
    acting = total(found.fluid) + total(found.buoyancy) - [0.0, 0.0, mass.sum() * G]
    for picture in (10, 30, 50):
        at = int(samples[picture])
        rate = (momentum(at + 1) - momentum(at)) / task.step
        # Implicit steps are of first order: 0.0005 s of forces that change within 0.1 s.
        assert acting[picture] == pytest.approx(rate, abs=0.02 * mass.sum() * G)
    assert np.abs(acting[30]).max() > 0.05 * mass.sum() * G


def test_a_torque_lies_along_the_axis_where_the_joint_is(
    made: Callable[..., Robot], asked: Callable[..., Task]
) -> None:
    _, found = told(asked(made(body(20.0, 3.0), SERVO)), torque=0.4)
    (drive,) = found.drives
    assert (drive.joint, drive.unit, drive.limit) == ("fin", "N m", 1.0)
    assert found.effort[:, 0] == pytest.approx(0.4, abs=1e-12)
    assert found.torque[0, 0] == pytest.approx(np.array([[0, 0, 20.3], [0, 0.4, 0]]), abs=1e-9)


def test_a_joint_of_which_one_motor_has_no_limit_has_none(made: Callable[..., Robot]) -> None:
    from morph.app.viewer.compare.forces import drives_of
    from morph.sim.simulator import Simulator

    robot = made(body(0.0, 1.0), SERVO + '<motor name="second" joint="fin"/>')
    (drive,) = drives_of(robot, Simulator(robot).model)
    assert drive.limit is None
