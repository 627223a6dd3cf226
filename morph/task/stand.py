"""Stand: a body on its feet stays on them."""

from __future__ import annotations

from collections.abc import Mapping

from morph.body.limbs import limbs_of
from morph.body.postures import posture_of
from morph.body.robot import Robot
from morph.errors import TaskError
from morph.physics.worlds import world
from morph.task.quantity import Direction, Point, Quantity
from morph.task.start import Start
from morph.task.task import Task
from morph.task.term import Goal, Term
from morph.task.torso import origin_of, torso
from morph.task.travel import effort_terms

FLOOR = "hard_floor"
"""What is stood and walked on."""

LEAN = 0.35
"""Farthest that any part of the torso's upright axis may be off, about the sine of 20 degrees."""

SINK = 0.1
"""Farthest that the torso may sink or rise, in heights of the torso."""

SPREAD = 0.01
"""Standard deviation of every driven joint at the start, rad, and of its velocity, rad/s."""

STEP = 0.002
"""Step of a simulation on a floor, s."""

SETTLE = 1.0
"""How long a body has to come to rest before it must be within both, s."""


def stand(robot: Robot, *, name: str = "stand", horizon: float = 5.0) -> Task:
    """Return the task to stay on one's feet; the torso may move, but not sink or lean.

    It begins in the body's own posture (`morph.body.postures`).

    Raises:
        TaskError: The body is held to the world, has no feet, or has no actuator.
    """
    link = torso(robot, name)
    limbs = limbs_of(robot)
    if limbs.lying and not limbs.feet:
        raise TaskError(
            "it has no feet to stand on: it lies on its trunk",
            where=f"task {name} of {robot.name}",
            fix="ask it to walk or swim, or give a robot with legs, such as quadruped_printed",
        )
    start = posture_of(robot)
    x, y, height = (float(each) for each in origin_of(robot, link, start))
    period = period_of(robot)
    upright = Direction(link=link)
    level = Point(link=link, axes="z")
    terms = (
        _near("lean", upright, (0.0, 0.0, 1.0), LEAN, period),
        _near("height", level, (height,), SINK * height, period),
        _near("place", Point(link=link, axes="xy"), (x, y), 0.5, 0.1 * period),
        *effort_terms(robot, weight=1e-3 * period),
    )
    last = horizon - SETTLE
    goals = (
        Goal(name="upright", quantity=upright, target=(0.0, 0.0, 1.0), within=LEAN, last=last),
        Goal(name="height", quantity=level, target=(height,), within=SINK * height, last=last),
    )
    return Task(
        name=name,
        robot=robot,
        terms=terms,
        goals=goals,
        start=start_of(robot, start),
        horizon=horizon,
        period=period,
        step=STEP,
        world=FLOOR,
        effects=world(FLOOR, robot).effects,
    )


def period_of(robot: Robot) -> float:
    """Return the control period on a floor, s: short where a policy itself must be the spring.

    Servos hold by themselves. Motors are told efforts, and a leg of a kilogram that stiff
    feedback holds at 10 ms already shakes itself off the floor.
    """
    return 0.02 if all(each.kind == "position" for each in robot.actuators) else STEP


def start_of(robot: Robot, position: Mapping[str, float]) -> Start:
    """Return a start on a floor near a posture: what is driven is shifted.

    Shifted as a whole, a body would begin with its feet in the floor, and be thrown off it. A
    closed chain would be torn joint by joint: of such a body what floats is shifted, by little.
    """
    if robot.loops:
        floating = tuple(joint.name for joint in robot.joints if joint.kind == "free")
        return Start(position=position, spread=0.2 * SPREAD, moving=floating)
    return Start(position=position, spread=SPREAD, moving=robot.driven)


def _near(
    name: str, quantity: Quantity, target: tuple[float, ...], width: float, weight: float
) -> Term:
    # Weighed by the control period, a sum over samples is an integral over time, in s.
    return Term(
        name=name, quantity=quantity, target=target, width=width, weight=weight, norm="saturating"
    )
