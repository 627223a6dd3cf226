"""One seed of figure 1: the biped stands and walks, and the humanoid walks by what it found."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import JSON, Array
from morph.body.load import load
from morph.policy_transfer.gait_family import (
    Response,
    Told,
    TransferredGaits,
    carried,
    joint_map,
    tried,
)
from morph.search.cmaes import Adapting
from morph.search.evaluate import evaluate
from morph.search.family.family import Family
from morph.search.family.gait import Gait
from morph.search.family.paces import paces
from morph.search.family.stride import Stride, stride
from morph.search.generations.population import tried as population
from morph.sim.threads import one_thread
from morph.task.crouch import crouch
from morph.task.stand import stand
from morph.task.task import Task
from morph.task.walk import walk

DISTANCE, HORIZON = 0.5, 5.0
"""How far both are to walk, m, and how long they have, s."""

TRANSITIONS = 60
"""Transitions of each body from which the map of joints is learned."""

BEND = 0.6
"""How far the humanoid's knees are bent between its steps, rad."""

ROLES = ("hip_x", "hip_y", "knee_y", "ankle_y")
"""What swings in the humanoid's own gaits."""

POPULATION = 12
"""Runs of a generation, one of each point."""

ROWS = 8
"""Runs by which a search is checked and judged."""

NARROW, WIDE = 0.08, 0.2
"""First spreads of searches, in sides of the cube; from nothing both are tried."""

SOLVED = 7 / 8
"""Share of the runs of a check at which a task is solved."""

STANDING = ("hip offset", "knee offset", "ankle offset", "stiffness", "damping")
"""The numbers of a stride that standing tells."""

WAYS = ("carried", "map alone", "from nothing", "from nothing, wide", "flipped", "shuffled")
"""Every way to make the humanoid walk by a search."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """One seed, and how far its searches go."""

    seed: int
    """Of all its chance."""
    standing: int = 6
    """Generations to stand."""
    walking: int = 25
    """Generations to walk, of each way on each body."""
    ways: tuple[str, ...] = WAYS[:-1]
    """What is tried on the humanoid."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Sought:
    """What a search found."""

    point: Array
    """The best point, or the first that walked, shape (numbers,)."""
    runs: float
    """Runs after which it had solved its task; infinite if it had not."""
    share: float
    """Share of runs that reached every goal."""
    loss: float
    """Their mean loss."""
    first: float
    """Share of runs that reached every goal where the search began."""
    walked: float
    """Mean distance of those runs at the end, m; 0 for one that fell."""

    def row(self) -> JSON:
        """Return it without the point."""
        return {key: value for key, value in vars(self).items() if key != "point"}


def sought(
    task: Task,
    family: Family,
    seed: tuple[int, ...],
    *,
    start: Array,
    free: Array | None = None,
    generations: int,
) -> Sought:
    """Return what CMA-ES finds of a family within so many generations.

    Args:
        task: What is to be done.
        family: The policies.
        seed: Of chance.
        start: Where in the cube it begins, shape (numbers,).
        free: Which numbers it turns; None for all.
        generations: The most.
    """
    simulator = task.simulator()
    free = np.ones(len(start), bool) if free is None else free
    search = Adapting(np.clip(start[free], 0.02, 0.98), family.sigma, POPULATION, None)

    def judged(point: Array, number: int) -> tuple[float, float, float]:
        rng = np.random.default_rng((*seed, number, 1))
        score = evaluate(task, family.policy(point), simulator, rng=rng, rows=ROWS)
        return score.share, score.mean, _walked(score.loss)

    first, loss, walked = judged(start, 0)
    if first >= SOLVED:
        return Sought(point=start, runs=0.0, share=first, loss=loss, first=first, walked=walked)
    best, least, runs = start, np.inf, np.inf
    for number in range(1, generations + 1):
        rng = np.random.default_rng((*seed, number))
        points = np.tile(start, (POPULATION, 1))
        points[:, free] = np.clip(search.ask(POPULATION, rng), 0.0, 1.0)
        if number == 1:
            points[0] = start
        policies = [family.policy(point) for point in points]
        score = population(task, policies, simulator, runs=1, rng=rng)
        losses = score.loss[:, 0]
        search.tell(points[:, free], losses)
        at = int(losses.argmin())
        if losses[at] < least:
            best, least = points[at], float(losses[at])
        # Twice: of 30 checks that a middling policy is given, one succeeds by luck.
        good = score.success[at, 0] and judged(points[at], number)[0] >= SOLVED
        if good and judged(points[at], number + 1000)[0] >= SOLVED:
            best, runs = points[at], float(POPULATION * number)
            break
    share, loss, walked = judged(best, 10**6)
    return Sought(point=best, runs=runs, share=share, loss=loss, first=first, walked=walked)


def _walked(loss: Array) -> float:
    """Return the mean distance, m, that runs of `walk` came: its loss tells no less.

    The loss is ((1.5 D - x) / (D / 2))^2 / 2 and what falling and straying cost, so that a loss L
    is a distance of 1.5 D - D / 2 sqrt(2 L) or more, and of one that fell (L > 4.5) nothing.
    """
    far = 1.5 * DISTANCE - 0.5 * DISTANCE * np.sqrt(2.0 * np.minimum(loss, 4.5))
    return float(np.clip(far, 0.0, None).mean())


def measured(case: Case) -> JSON:
    """Return what each step of the figure showed."""
    with one_thread():
        return _measured(case)


def _measured(case: Case) -> JSON:
    biped = walk(load("biped"), distance=DISTANCE, horizon=HORIZON)
    strides = stride(biped.robot, biped.start.position, seconds=HORIZON, period=biped.period)
    standing = stand(biped.robot, horizon=2.0)
    free = np.array([number.name in STANDING for number in strides.numbers])
    still = strides.start.copy()
    still[[number.name.endswith("amplitude") for number in strides.numbers]] = 0.0
    found: JSON = {"seed": case.seed, "biped": {}, "humanoid": {}}
    stood = sought(
        standing, strides, (case.seed, 0), start=still, free=free, generations=case.standing
    )
    found["biped"]["stand"] = stood.row()
    begun = np.where(free, stood.point, strides.start)
    # Who has not stood knows of what standing tells only within which bounds it is.
    unknown = np.where(free, 0.5, strides.start)
    walks = {
        way: sought(biped, strides, (case.seed, 1), start=start, generations=case.walking)
        for way, start in (("carried", begun), ("from nothing", unknown))
    }
    found["biped"] |= {way: each.row() for way, each in walks.items()}
    values = strides.values(walks["carried"].point)
    task, families = _humanoid(case, biped, strides, values)
    for number, way in enumerate(case.ways):
        family = families[way]
        seed = (case.seed, 2 + number)
        each = sought(task, family, seed, start=family.start, generations=case.walking)
        found["humanoid"][way] = each.row()
    found["map"] = _parts_of(families["carried"], biped, task)
    return found


def _humanoid(
    case: Case, biped: Task, strides: Stride, values: Array
) -> tuple[Task, dict[str, Family]]:
    """Return the humanoid's task, and the policies of every way."""
    robot = load("humanoid")
    task = walk(robot, distance=DISTANCE, horizon=HORIZON)
    posture = crouch(robot, {"l_knee_y": BEND, "r_knee_y": BEND})
    task = replace(task, start=replace(task.start, position=posture))
    rng = np.random.default_rng((case.seed, 99))
    responses = (
        tried(biped, _springs(biped, strides, values), TRANSITIONS, rng),
        tried(task, _servos(task), TRANSITIONS, rng),
    )
    gait = strides.gait
    known = values[: len(gait.numbers)]
    right = joint_map(*responses)
    mixed = right[rng.permutation(len(right))]
    own = paces(robot, posture, roles=ROLES, period=task.period)
    # As motors of a robot whose right side is built as the mirror of its left.
    other = np.array([-1.0 if each.name.startswith("r_") else 1.0 for each in robot.actuators])
    families: dict[str, Family] = {
        "carried": _carried(gait, known, responses, task, right),
        "map alone": _carried(gait, None, responses, task, right),
        "from nothing": replace(own, sigma=NARROW),
        "from nothing, wide": replace(own, sigma=WIDE),
        "flipped": _carried(gait, known, responses, task, other[:, None] * right),
        "shuffled": _carried(gait, known, responses, task, mixed),
    }
    return task, families


def _carried(
    gait: Gait, values: Array | None, responses: tuple[Response, Response], task: Task, map: Array
) -> TransferredGaits:
    return replace(carried(gait, values, responses, task, map=map), sigma=NARROW)


def _springs(task: Task, strides: Stride, values: Array) -> Told:
    """Return how set points of a biped's stride become efforts, as its policy makes them."""
    model = task.simulator().model
    joints = [model.joint(each.joint) for each in task.robot.actuators]
    q = [int(each.qposadr[0]) for each in joints]
    v = [int(each.dofadr[0]) for each in joints]
    limit = np.array([each.high for each in strides.action])
    k = 10.0 ** values[-2] * strides.strength
    d = 10.0 ** values[-1] * k

    def told(position: Array, velocity: Array, point: Array) -> Array:
        effort = k * (strides.posture + point - position[:, q]) - d * velocity[:, v]
        return np.asarray(np.clip(effort, -limit, limit))

    return told


def _servos(task: Task) -> Told:
    posture = np.array(
        [task.start.position.get(each.joint or "", 0.0) for each in task.robot.actuators]
    )
    return lambda position, velocity, point: posture + point


def _parts_of(family: Family, biped: Task, task: Task) -> JSON:
    """Return, for each joint of the biped, which of the humanoid's does most of its work."""
    if not isinstance(family, TransferredGaits):
        return {}
    names = [each.name for each in task.robot.actuators]
    best = np.abs(family.map).argmax(axis=0)
    return {
        each.name: {"joint": names[at], "gain": float(family.map[at, column])}
        for column, (each, at) in enumerate(zip(biped.robot.actuators, best, strict=True))
    }
