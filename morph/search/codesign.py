"""Body and policy of one task, sought together: the numbers of both are one point."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array, Mask
from morph.body.card import CardParameter
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.body.vary import with_parameters
from morph.errors import MorphError, SearchError
from morph.search.cmaes import Adapting
from morph.search.evaluate import attempt
from morph.search.family.family import Family
from morph.sim.start import started
from morph.task.task import Task
from morph.task.torso import torso

FALLEN = 0.5
"""Cosine of the lean from which a body has fallen, and goes no farther: 60 degrees."""

POPULATION = 12
"""Points in a generation."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Design:
    """A described body, which of its card's parameters are free, and what it is to do.

    A point of the unit cube has the policy's numbers first and then one for each group of
    parameters, from their low to their high: legs of a group grow alike.
    """

    robot: Robot
    """The body as it is described."""
    groups: tuple[tuple[str, ...], ...]
    """Parameters of the card that have one value."""
    pose: Callable[[Robot], Task]
    """From a body to its task."""
    family: Callable[[Task], Family]
    """Which policies such a task has; their numbers do not depend on the body's lengths."""

    def __post_init__(self) -> None:
        """Check that the card has each parameter."""
        missing = [n for group in self.groups for n in group if n not in self._parameters]
        if missing or not self.groups:
            raise SearchError(
                f"its card has no parameter {', '.join(missing) or 'that is free'}",
                where=f"a design of {self.robot.name}",
                fix=f"name groups of {', '.join(self._parameters)}",
            )

    @cached_property
    def _parameters(self) -> Mapping[str, CardParameter]:
        card = self.robot.card
        return {each.name: each for each in card.parameter} if card else {}

    @cached_property
    def policies(self) -> Family:
        """The policies of the body as it is described."""
        return self.family(self.pose(self.robot))

    @cached_property
    def start(self) -> Array:
        """The policy with which a search begins, and the body as it is described."""
        described = [self._share(group[0], 1.0) for group in self.groups]
        return np.concatenate([self.policies.start, np.clip(described, 0.0, 1.0)])

    def _share(self, name: str, value: float) -> float:
        known = self._parameters[name]
        return (value - known.low) / (known.high - known.low)

    @property
    def of_policy(self) -> Mask:
        """Which numbers of a point are the policy's, shape (numbers,)."""
        return np.arange(len(self.start)) < len(self.policies.numbers)

    def values(self, point: Array) -> dict[str, float]:
        """Return the parameters of a point's body, by name."""
        shares = np.clip(point[~self.of_policy], 0.0, 1.0).tolist()
        return {
            name: self._parameters[name].low
            + share * (self._parameters[name].high - self._parameters[name].low)
            for group, share in zip(self.groups, shares, strict=True)
            for name in group
        }

    def body(self, point: Array) -> Robot:
        """Return the body of a point.

        Raises:
            RobotError: A parameter cannot be set so.
        """
        return with_parameters(self.robot, self.values(point))

    def far(self, point: Array, *, rng: np.random.Generator, rows: int = 1) -> float:
        """Return how far ahead a point's body comes before it falls, less how far aside, m.

        A body that cannot be made, or whose simulation fails, comes nowhere: 0.
        """
        try:
            task = standing(self.pose(self.body(point)))
            policy = self.family(task).policy(point[self.of_policy])
            moved = attempt(task, policy, task.simulator(), rows=rows, rng=rng)
        except MorphError:
            return 0.0
        model = moved.model
        trunk = model.body(torso(task.robot, task.name)).id
        at = int(model.jnt_qposadr[model.body_jntadr[trunk]])
        place, (_, x, y, _) = moved.position[..., at : at + 3], _parts(moved.position, at + 3)
        stands = 1.0 - 2.0 * (x**2 + y**2) > FALLEN
        last = np.maximum(np.logical_and.accumulate(stands, axis=-1).sum(axis=-1) - 1, 0)
        each = np.arange(len(last))
        gone = place[each, last] - place[:, 0]
        fine = np.ones(len(last), bool) if moved.stable is None else moved.stable
        far = np.where(fine, gone[:, 0] - np.abs(gone[:, 1]), 0.0)
        return float(np.nan_to_num(far).mean())


def _parts(position: Array, at: int) -> tuple[Array, Array, Array, Array]:
    w, x, y, z = np.moveaxis(position[..., at : at + 4], -1, 0)
    return w, x, y, z


def standing(task: Task) -> Task:
    """Return a task begun with the body as high over the floor as its lowest shape needs.

    A floating body whose legs have become longer would begin in the floor.
    """
    link = torso(task.robot, task.name)
    model: Any = spec_of(task.robot).compile()
    data = mujoco.MjData(model)
    data.qpos = started(task.robot, model, task.start.position, {})[0]
    mujoco.mj_kinematics(model, data)
    height = float(data.xpos[model.body(link).id, 2]) - lowest(model, data)
    place = {**task.start.position, f"{link}.position.z": height}
    return replace(task, start=replace(task.start, position=place))


def lowest(model: Any, data: Any) -> float:
    """Return the height of the lowest corner of a box about any shape of a body, m."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    result = np.inf
    for geom in range(model.ngeom):
        if model.geom_bodyid[geom] == 0 or not model.geom_contype[geom]:
            continue
        box = model.geom_aabb[geom]
        local = box[:3] + corners * box[3:]
        rotation = data.geom_xmat[geom].reshape(3, 3)
        result = min(result, float((data.geom_xpos[geom] + local @ rotation.T)[:, 2].min()))
    return result if np.isfinite(result) else 0.0


@dataclass(frozen=True, kw_only=True, eq=False)
class Designed:
    """What a search found."""

    point: Array
    """The middle of its last generation, shape (numbers,)."""
    curve: tuple[float, ...]
    """The greatest distance of any point up to each generation, m."""
    runs: int
    """How many runs it cost."""


def sought(
    design: Design,
    phases: Sequence[tuple[Mask, int]],
    *,
    seed: int,
    sigma: float = 0.2,
    population: int = POPULATION,
) -> Designed:
    """Return what CMA-ES finds by turning some numbers after others.

    Source: Hansen 2016, The CMA evolution strategy: a tutorial, arXiv 1604.00772.

    Args:
        design: The body and its task.
        phases: Which numbers are free, shape (numbers,), and for how many generations; one phase
            with all of them seeks body and policy together. Each goes on where the last ended.
        seed: Of chance.
        sigma: How far the first generation of a phase reaches, in sides of the cube.
        population: Points in a generation.
    """
    point, curve, best, number = design.start.copy(), [], -np.inf, 0
    for free, generations in phases:
        search = Adapting(np.clip(point[free], 0.02, 0.98), sigma, population, None)
        for _ in range(generations):
            number += 1
            rng = np.random.default_rng((seed, number))
            requested = np.clip(search.ask(population, rng), 0.0, 1.0)
            if number == 1:
                requested[0] = point[free]
            chance = int(rng.integers(2**31))
            tried = np.tile(point, (population, 1))
            tried[:, free] = requested
            # All begin alike: they are compared by what they are.
            far = np.array([design.far(each, rng=np.random.default_rng(chance)) for each in tried])
            search.tell(requested, -far)
            best = max(best, float(far.max()))
            curve.append(best)
        point[free] = np.clip(search.mean, 0.0, 1.0)
    return Designed(point=point, curve=tuple(curve), runs=population * number)
