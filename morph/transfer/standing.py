"""Bodies that stand on something by contacts or welds: where they come to rest."""

from __future__ import annotations

from dataclasses import replace
import numpy as np

from morph.body.robot import Robot
from morph.errors import SearchError
from morph.search.regulator.rest import Rest
from morph.search.trajectory.plant import Plant
from morph.sim.start import started
from morph.task.push import Push
from morph.task.stand import SPREAD, stand
from morph.task.start import Start
from morph.task.task import Task
from morph.task.torso import legs_of
from morph.transfer.body import Body, body

PERIOD = 0.02
"""How long a command is held, s: that of the chains."""

LONGEST = 10.0
"""Time within which a body must come to rest by itself, s."""

CALM = 2e-3
"""Greatest speed of a body at rest, m/s or rad/s; contacts creep."""

BRAKE = 0.5
"""What is left of every speed after a control period while it settles."""

CORRECTS = 0.01
"""Share of a joint's error by which its servo is told more, each period while it settles."""


def standing(
    robot: Robot, carriers: tuple[str, ...], *, push: Push | None = None, noise: float = 0.01
) -> Body:
    """Return a body with the task to stay upright on what carries it, about where it settles.

    Runs begin where it is at rest, joints that bear no weight spread a little, with a push.

    Args:
        robot: A body with servos that stands as it is described.
        carriers: The links that carry it.
        push: By which runs begin.
        noise: Standard deviation of every observation.

    Raises:
        SearchError: It does not come to rest by itself.
    """
    task = stand(robot, name="balance")
    legs = legs_of(robot)
    hinges = {joint.name for joint in robot.joints if joint.kind == "hinge"}
    loose = tuple(each.joint for each in robot.actuators if each.joint in hinges - legs)
    start = Start(position=task.start.position, spread=SPREAD, moving=loose, push=push)
    task = replace(task, start=start, period=PERIOD, noise=noise)
    return sighted(body(task, carriers=carriers, still=settled(task)))


def sighted(whole: Body) -> Body:
    """Return a body of which only what its task looks at is seen: tilts, places and their rates.

    Each is a sum of what joints and board are read at, scaled to the noise of one reading.
    """
    half = len(whole.outcome) // 2
    rows = whole.outcome[:half, : whole.size // 2]
    rows = rows / np.linalg.norm(rows, axis=1, keepdims=True)
    none = np.zeros_like(rows)
    return replace(whole, sight=np.block([[rows, none], [none, rows]]))


def settled(task: Task) -> Rest:
    """Return where a body comes to rest by itself, told what holds it as it is described.

    It is let go, and its speed is taken away again and again, so that it does not swing; servos
    are told more than their place until their joints stand where they are described.

    Raises:
        SearchError: It falls, or creeps on.
    """
    plant = Plant(task.simulator(), task.period)
    q, v = started(task.robot, plant.model, task.start.position, {})
    servos = [
        (at, int(plant.model.joint(each.joint).qposadr[0]))
        for at, each in enumerate(task.robot.actuators)
        if each.kind == "position"
    ]
    which, where = (list(each) for each in zip(*servos, strict=True))
    wanted, told = q[where], np.zeros(plant.model.nu)
    told[which] = wanted
    periods = round(LONGEST / task.period)
    for at in range(periods):
        after, v = (each[0] for each in plant.advance(q[None], BRAKE * v[None], told[None]))
        still = np.abs(after[where] - q[where]).max() < CALM * task.period
        q = after
        if at < periods // 2:
            told[which] += CORRECTS * (wanted - q[where])
            told = np.clip(told, plant.low, plant.high)
        elif not np.isfinite(q).all() or (still and np.abs(v).max() < CALM):
            break
    if not np.isfinite(q).all() or np.abs(v).max() > 10.0 * CALM:
        raise SearchError(
            f"it does not come to rest within {LONGEST:g} s: its greatest speed is "
            f"{np.abs(v).max():.3g}",
            where=f"task {task.name} of {task.robot.name}",
            fix="give a body that stands by itself as it is described",
        )
    return Rest(position=q, velocity=np.zeros(plant.model.nv), command=told)

