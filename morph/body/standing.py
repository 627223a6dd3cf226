"""How a robot stands on its feet: a posture with the soles on the floor that its motors hold."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array, Integers
from morph.body.limbs import JointTree, limbs_of, torso_of
from morph.body.robot import Robot
from morph.body.roles import joint_roles
from morph.body.soles import sole_of
from morph.body.spec import spec_of
from morph.body.support import beyond_limits, holding_efforts
from morph.body.surface import UPRIGHT, height_of, lowest_of
from morph.body.told import told
from morph.body.within_limits import within_limits

BENT = 0.3
"""How far from its limits a joint of a leg is kept, rad, where there is room."""
STRAIGHT = 0.95
"""Greatest length of a leg, from its first joint to its sole, in lengths of the straight leg."""
CLEAR = 0.3
"""Least height of the trunk's shapes above the soles, in lengths of the straight legs."""
LEVEL = 0.005
"""Share of its size by which a robot may be above or in the floor as it is described."""
BENDS = (0.4, 0.8)
"""How far joints of legs are bent where the search for a posture begins, rad."""
MOST_BENT = 4
"""Most roles of joints that are bent one way or the other at first."""
GOOD, FAIR, SAME = 3e-3, 0.06, 0.05
"""Half the sum of squared faults below which no other beginning is tried; below which none is
either if two led to one posture; and the share by which the faults of such two differ."""
INNER = 0.6
"""Farthest that the centre of mass of a robot that stands as described is from the middle of its
support, in lengths from there to the edge: nearer to it servos that give way a little fall."""
LEAST = 0.003
"""Least change of a joint from its description, rad or m."""
WHEEL = (-0.7, 0.0, 0.7)
"""How far a foot is turned to see whether it is a wheel, rad."""
TURNS = 50
"""Most poses from which one search goes on."""


@dataclass(frozen=True, kw_only=True)
class StandingPosture:
    """A posture on all feet, and what it asks of the motors."""

    position: Mapping[str, float]
    """Where a simulation starts: joints by name, rad or m, and the base's height, m."""
    effort: Mapping[str, float]
    """By actuator the effort at its joint, N m or N, with the least share of limits."""
    lacking: Mapping[str, float]
    """By actuator that is too weak, what it would have to give, N m or N."""
    balanced: bool
    """Whether forces at the soles can hold the base at all; on two points they cannot."""
    computed: bool
    """Whether legs were bent; else the robot stands as it is described, on the floor."""

    def as_json(self) -> dict[str, Any]:
        """Return it as JSON holds it, by the schema `morph.inspection/1`, but for the posture."""
        return {
            "computed": self.computed,
            "balanced": self.balanced,
            "efforts": dict(self.effort),
            "lacking": dict(self.lacking),
        }


def standing(robot: Robot, model: Any = None) -> StandingPosture | None:
    """Return how a robot stands on its feet, upright on a level floor at height 0.

    A robot that stands as it is described, on level soles and held up by its motors, keeps its
    posture; motors alone need legs that are bent, away from the ends of their ranges. Of others
    the joints of the legs are chosen: soles level, centre of mass above their middle, feet where
    they were, trunk clear of the floor, legs shorter than `STRAIGHT`, joints `BENT` from limits.

    Args:
        robot: The robot.
        model: Its compiled `mujoco.MjModel`, where there is one already.

    Returns:
        The posture; None of a robot that is held to the world or has no feet.
    """
    link = torso_of(robot)
    if link is None:
        return None
    model = spec_of(robot).compile() if model is None else model
    legs = _Legs(robot, model, link)
    if not legs.soles:
        return None
    described = legs.settled(within_limits(model, model.qpos0))
    computed = not robot.loops and not legs.rolls() and not legs.stands(described)
    chosen = legs.settled(legs.bent()) if computed else described
    effort = legs.held(chosen)
    return StandingPosture(
        position=told(robot, model, chosen),
        effort=effort or {},
        lacking=beyond_limits(robot, effort or {}),
        balanced=effort is not None,
        computed=computed,
    )


class _Legs:
    """The legs of a robot, and poses in which it stands on them."""

    def __init__(self, robot: Robot, model: Any, link: str) -> None:
        self.robot, self.link = robot, link
        self.model, self.data = model, mujoco.MjData(model)
        driven, trunk = set(robot.driven), model.body(link).id
        # The wheels of a board on which a robot rides are no feet of its own.
        limbs = [
            limb
            for limb in limbs_of(robot, model).feet
            if trunk in _above(model, model.body(limb.end).id)
        ]
        self.legs = [
            [model.joint(name).id for name in limb.joints if name in driven] for limb in limbs
        ]
        self.joints = sorted({at for leg in self.legs for at in leg})
        self.places: Integers = model.jnt_qposadr[self.joints].astype(np.int64)
        limited = model.jnt_limited.astype(bool)[self.joints]
        reach = model.jnt_range[self.joints]
        self.low = np.where(limited, reach[:, 0], -math.pi)
        self.high = np.where(limited, reach[:, 1], math.pi)
        self.room = np.minimum(BENT, 0.25 * (self.high - self.low))
        data = self._at(model.qpos0)
        self.soles = [
            sole_of(model, data, model.body(limb.end).id, leg)
            for limb, leg in zip(limbs, self.legs, strict=True)
        ]
        self.trunk = sole_of(model, data, model.body(link).id)
        self.turn = data.xmat[[sole.body for sole in self.soles]].copy()
        self.place = self._touch()[:, :2] if self.soles else np.zeros((0, 2))
        self.size = max(JointTree(model, data).size, 1e-6)
        rows = [self._row(at) for at in range(len(self.legs))]
        self.straight = np.array([_length(row) for row in rows])

    def _at(self, pose: Array) -> Any:
        """Return the data of a pose."""
        self.data.qpos[:] = pose
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        return self.data

    def _touch(self) -> Array:
        return np.array([sole.touch(self.data) for sole in self.soles])

    def _row(self, at: int) -> Array:
        """Return the joints of a leg and its sole in the pose that was set last, shape (n, 3)."""
        return np.vstack([self.data.xanchor[self.legs[at]], self.soles[at].touch(self.data)])

    def _lengths(self) -> Array:
        """Return how long legs are, in lengths of the straight leg, shape (legs,)."""
        rows = [self._row(at) for at in range(len(self.legs))]
        return np.asarray(np.array([_length(row[[0, -1]]) for row in rows]) / self.straight)

    def settled(self, pose: Array) -> Array:
        """Return a pose with the base as high as its lowest point asks, a floor at 0."""
        trunk = int(self.model.body(self.link).id)
        lowest = lowest_of(self.model, self._at(pose), trunk)
        low = float(self._touch()[:, 2].min()) if lowest is None else lowest
        if abs(low) > LEVEL * self.size:
            found = height_of(self.model, self.data, trunk)
            if found is not None:
                place, upwards = found
                pose[place] -= low / upwards
        return pose

    def rolls(self) -> bool:
        """Return whether a foot is a wheel: it touches as low however its last joint is turned."""
        for leg, sole in zip(self.legs, self.soles, strict=True):
            lows = []
            for turned in WHEEL if leg else ():
                pose = self.model.qpos0.copy()
                pose[self.model.jnt_qposadr[leg[-1]]] += turned
                lows.append(lowest_of(self.model, self._at(pose), sole.body))
            level = leg and abs(float(self.data.xaxis[leg[-1], 2])) < UPRIGHT
            known = [low for low in lows if low is not None]
            if level and known and np.ptp(known) < LEVEL * self.size:
                return True
        return False

    def stands(self, pose: Array) -> bool:
        """Return whether a robot stands in a pose: all soles down, and held up by its motors."""
        self._at(pose)
        if np.ptp(self._touch()[:, 2]) > LEVEL * self.size or self._off() > INNER:
            return False
        if all(each.kind != "position" for each in self.robot.actuators):
            value = pose[self.places]
            if (np.minimum(value - self.low, self.high - value) < self.room).any():
                return False
            if (self._lengths() > STRAIGHT).all():
                return False
        effort = self.held(pose)
        return effort is not None and not beyond_limits(self.robot, effort)

    def _off(self) -> float:
        """Return how far the centre of mass is from the middle of the support, 1 at its edge."""
        points = np.vstack([sole.corners(self.data) for sole in self.soles])[:, :2]
        middle, angle = points.mean(axis=0), np.linspace(0.0, 2.0 * math.pi, 64, endpoint=False)
        way = np.stack([np.cos(angle), np.sin(angle)])
        edge = ((points - middle) @ way).max(axis=0)
        mass = (self.data.subtree_com[0, :2] - middle) @ way
        return float((mass / np.maximum(edge, 1e-3 * self.size)).max())

    def held(self, pose: Array) -> dict[str, float] | None:
        """Return the efforts that hold a pose; see `holding_efforts`."""
        return holding_efforts(self.robot, self.model, self._at(pose), self.link, self.soles)

    def bent(self) -> Array:
        """Return the pose on bent legs that is best, of several beginnings."""
        from scipy.optimize import least_squares

        roles = joint_roles(self.robot)
        own = [roles[self.model.joint(at).name] for at in self.joints]
        orders = sorted({role.order for role in own})[-MOST_BENT:]
        base = within_limits(self.model, self.model.qpos0)
        best: tuple[float, Array] = (math.inf, base[self.places])
        for size, signs in product(BENDS, product((1.0, -1.0), repeat=len(orders))):
            way = dict(zip(orders, signs, strict=True))
            bend = np.array([role.sense * size * way.get(role.order, 0.0) for role in own])
            result = least_squares(
                self._faults,
                np.clip(base[self.places] + bend, self.low, self.high),
                bounds=(self.low - 1e-9, self.high + 1e-9),
                args=(base,),
                ftol=1e-4,
                max_nfev=TURNS,
            )
            same = abs(result.cost - best[0]) < SAME * best[0] < SAME * FAIR
            best = min(best, (float(result.cost), result.x), key=lambda each: each[0])
            if best[0] < GOOD or same:
                break
        # To a milliradian, which reads better and stands as well.
        value = np.round(best[1], 3)
        moved = np.abs(value - base[self.places]) > LEAST
        base[self.places] = np.where(moved, value, base[self.places])
        return base

    def _faults(self, value: Array, base: Array) -> Array:
        """Return by how much a pose fails to stand, in sizes of the robot and rad, weighted."""
        pose = base.copy()
        pose[self.places] = value
        data = self._at(pose)
        touch = self._touch()
        middle, mass = touch[:, :2].mean(axis=0), data.subtree_com[0, :2]
        level = touch[:, 2] - touch[:, 2].mean()
        moved = touch[:, :2] - middle - (self.place - self.place.mean(axis=0))
        beyond = np.maximum(0.0, self.room - np.minimum(value - self.low, self.high - value))
        clear = self.trunk.touch(data)[2] - touch[:, 2].mean()
        turned = [
            data.xmat[sole.body] - turn
            for sole, turn in zip(self.soles, self.turn, strict=True)
            if sole.flat
        ]
        return np.concatenate(
            [
                10.0 * level / self.size,
                10.0 * (mass - middle) / self.size,
                moved.ravel() / self.size,
                *(10.0 * each for each in turned),
                beyond,
                10.0 * np.maximum(0.0, self._lengths() - STRAIGHT),
                [10.0 * max(0.0, CLEAR * float(self.straight.min()) - clear) / self.size],
                0.01 * (value - base[self.places]),
            ]
        )


def _above(model: Any, body: int) -> set[int]:
    """Return a link and the links that it hangs from."""
    found = {body}
    while body:
        body = int(model.body_parentid[body])
        found.add(body)
    return found


def _length(row: Array) -> float:
    """Return the length of a line through points, m; not 0."""
    return max(float(np.linalg.norm(np.diff(row, axis=0), axis=1).sum()), 1e-9)
