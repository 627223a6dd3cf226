"""State of rest of bodies that stand by contacts or welds."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.limbs import torso_of
from morph.body.robot import Robot
from morph.errors import SearchError
from morph.policy_transfer.body import Body, body
from morph.search.regulator.rest import Rest
from morph.search.trajectory.plant import Plant
from morph.sim.start import started
from morph.task.push import Push
from morph.task.stand import SPREAD, stand
from morph.task.start import Start
from morph.task.task import Task

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

DEAR = 10.0
"""What effort costs against the usual: soles that are pushed too hard tip over their edge."""

BEARS = 0.15
"""Share of the mass that a joint carries from which it counts beside the legs: a waist, no arm."""

ACROSS = 0.9
"""Least cosine of a pitch axis with the direction across the board."""

LEVEL = 0.02
"""Heights of joints within which they are one group, m."""


def standing(
    robot: Robot,
    feet: tuple[str, ...],
    carriers: tuple[str, ...],
    *,
    push: Push | None = None,
    noise: float = 0.01,
) -> Body:
    """Return a body with the task to stay upright on what carries it, about where it settles.

    Runs begin where it is at rest, joints that bear no weight spread a little, with a push.

    Args:
        robot: A body with servos that stands as it is described.
        feet: The links that it stands on.
        carriers: The links that carry it.
        push: By which runs begin.
        noise: Standard deviation of every observation.

    Raises:
        SearchError: It does not come to rest by itself.
    """
    task = stand(robot, name="balance")
    legs = _legs(robot, feet)
    hinges = {joint.name for joint in robot.joints if joint.kind == "hinge"}
    loose = tuple(name for name in robot.driven if name in hinges - legs)
    start = Start(position=task.start.position, spread=SPREAD, moving=loose, push=push)
    task = replace(task, start=start, period=PERIOD, noise=noise)
    return sighted(body(task, carriers=carriers, still=settled(task)), feet)


def sighted(whole: Body, feet: tuple[str, ...]) -> Body:
    """Return a body that is seen and told in the plane in which its board rolls.

    Seen is how far it tilts ahead, where a driven board is, and the turn of each pitch group;
    told are these groups and the board's motor. So a policy has as many numbers as one of a
    rider in the plane. Aside, servos hold by themselves. All of it comes of the description.
    """
    half = len(whole.outcome) // 2
    ahead = [0, half - 1] if whole.upright.placed else [0]
    groups = pitch_groups(whole, feet)
    model, actuators = whole.plant.model, whole.task.robot.actuators
    turned = np.zeros((groups.shape[1], whole.size // 2))
    for at, actuator in enumerate(actuators):
        turned[:, model.joint(actuator.joint).dofadr[0]] = groups[at]
    rows = np.concatenate([whole.outcome[ahead, : whole.size // 2], turned])
    # Each number is as noisy as one reading.
    rows = rows / np.linalg.norm(rows, axis=1, keepdims=True)
    none = np.zeros_like(rows)
    motors = np.eye(len(actuators))[:, [each.kind == "motor" for each in actuators]]
    return replace(
        whole,
        sight=np.block([[rows, none], [none, rows]]),
        together=np.hstack([motors, groups]),
        dear=DEAR,
    )


def pitch_groups(whole: Body, feet: tuple[str, ...]) -> Array:
    """Return which servos turn the body in the plane it rolls in, shape (actuators, groups).

    A group are servos at one height whose axes lie across: 1 or -1 by which way round each turns.
    They are those of the legs and of what carries much of the body, from the ankles up.
    """
    model, robot = whole.plant.model, whole.task.robot
    data = mujoco.MjData(model)
    data.qpos[:] = whole.still.position
    mujoco.mj_kinematics(model, data)
    legs = _legs(robot, feet)
    across: dict[float, Array] = {}
    for at, actuator in enumerate(robot.actuators):
        joint = model.joint(actuator.joint).id
        along = float(data.xaxis[joint][1])
        moved = model.body_subtreemass[model.jnt_bodyid[joint]] / robot.mass
        bears = actuator.joint in legs or moved > BEARS
        if actuator.kind != "position" or abs(along) < ACROSS or not bears:
            continue
        height = float(data.xanchor[joint][2])
        near = next((each for each in across if abs(each - height) < LEVEL), height)
        across.setdefault(near, np.zeros(len(robot.actuators)))[at] = np.sign(along)
    return np.array([across[each] for each in sorted(across)]).T


def _legs(robot: Robot, feet: tuple[str, ...]) -> set[str]:
    """Return the joints between what floats over the board and the feet."""
    parents = {link.name: link.parent for link in robot.links}
    links: set[str] = set()
    for foot in feet:
        link = robot.link(foot).name
        while link in parents and link != torso_of(robot):
            links.add(link)
            link = parents[link]
    return {joint.name for joint in robot.joints if joint.link in links}


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
    wanted, command = q[where], np.zeros(plant.model.nu)
    command[which] = wanted
    periods = round(LONGEST / task.period)
    for at in range(periods):
        after, v = (each[0] for each in plant.advance(q[None], BRAKE * v[None], command[None]))
        still = np.abs(after[where] - q[where]).max() < CALM * task.period
        q = after
        if at < periods // 2:
            command[which] += CORRECTS * (wanted - q[where])
            command = np.clip(command, plant.low, plant.high)
        elif not np.isfinite(q).all() or (still and np.abs(v).max() < CALM):
            break
    if not np.isfinite(q).all() or np.abs(v).max() > 10.0 * CALM:
        raise SearchError(
            f"it does not come to rest within {LONGEST:g} s: its greatest speed is "
            f"{np.abs(v).max():.3g}",
            where=f"task {task.name} of {task.robot.name}",
            fix="give a body that stands by itself as it is described",
        )
    return Rest(position=q, velocity=np.zeros(plant.model.nv), command=command)
