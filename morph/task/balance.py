"""Balance: a chain that begins nearly upright stays there."""

from __future__ import annotations

from morph.body.limbs import torso_of
from morph.body.robot import Robot
from morph.task.chain import posture, slides_of, stepping, ways
from morph.task.quantity import AngleSum, Commands, JointPositions, JointSpeeds
from morph.task.stand import stand
from morph.task.start import Start
from morph.task.task import Task
from morph.task.term import Goal, Term

LEAN = 0.17
"""Farthest that a link may lean, rad: ten degrees."""

STRAY = 0.15
"""Farthest that what carries the chain may stray, m."""

LAST = 0.5
"""For how long to the end both are asked for, s."""


def balance(robot: Robot) -> Task:
    """Return the task to keep a chain upright for 5 s; a board that nothing drives may roll.

    A body that is held by nothing but its feet balances where it stands: see `stand`.

    Raises:
        TaskError: The body has no hinges that swing in gravity, or cannot stand upright.
    """
    name = "balance"
    if torso_of(robot) is not None:
        return stand(robot, name=name)
    top = posture(robot, name, upright=True)
    hinges = tuple(top)
    slides = tuple(joint.name for joint in slides_of(robot, driven=True))
    moving = (*hinges, *slides)
    terms = [
        Term(
            name="lean",
            quantity=JointPositions(joints=hinges),
            target=tuple(top.values()),
            width=LEAN,
        ),
        Term(
            name="speed",
            quantity=JointSpeeds(joints=moving),
            target=(0.0,) * len(moving),
            width=10.0 * LEAN,
        ),
        *_effort(robot),
    ]
    if slides:
        rest = (0.0,) * len(slides)
        quantity = JointPositions(joints=slides)
        terms.append(Term(name="place", quantity=quantity, target=rest, width=STRAY))
    step, integrator = stepping(robot)
    return Task(
        name=name,
        robot=robot,
        terms=tuple(terms),
        goals=upright_goals(robot, top, last=4.5),
        step=step,
        integrator=integrator,
        start=Start(position=top, spread=0.02),
        horizon=5.0,
        period=0.02,
    )


def _effort(robot: Robot) -> list[Term]:
    """Return a small cost of effort for each motor; a servo's command is a place, and free."""
    return [
        Term(
            name=f"effort of {actuator.name}",
            quantity=Commands(actuators=(actuator.name,)),
            target=(0.0,),
            width=actuator.limit,
            weight=0.1,
        )
        for actuator in robot.actuators
        if actuator.kind == "motor" and actuator.limit
    ]


def upright_goals(robot: Robot, top: dict[str, float], *, last: float) -> tuple[Goal, ...]:
    """Return the goals of a chain that stands: every link upright, and its carrier in place.

    A link's lean is the signed sum of the angles on the way from the root to it.
    """
    goals = [
        Goal(
            name=f"upright at {hinge}",
            quantity=AngleSum(joints=way, signs=signs),
            target=(sum(sign * top[name] for sign, name in zip(signs, way, strict=True)),),
            within=LEAN,
            last=last,
        )
        for hinge, (way, signs) in ways(robot, top).items()
    ]
    goals += [
        Goal(
            name=f"{slide.name} in place",
            quantity=JointPositions(joints=(slide.name,)),
            target=(0.0,),
            within=STRAY,
            last=last,
        )
        for slide in slides_of(robot, driven=True)
    ]
    return tuple(goals)
