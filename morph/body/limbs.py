"""Limbs of a robot and which are mirror images, by its geometry alone: names play no part."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array, Integers
from morph.body.robot import FREEDOMS, Robot
from morph.body.spec import spec_of

HINGE, SLIDE = mujoco.mjtJoint.mjJNT_HINGE.value, mujoco.mjtJoint.mjJNT_SLIDE.value
NEAR = 0.03
"""Robot sizes within which two parts are as far ahead as each other."""
BESIDE = 0.06
"""Robot sizes by which a joint may lie beside the mirror image of its twin."""
PARALLEL = 0.97
"""Least cosine between an axis and the mirror image of its twin's: 14 degrees."""
LOW = 0.05
"""Robot heights above its lowest point in which the end of a limb is a foot."""
SYMMETRIC = 0.5
"""Share of the joints that have a twin, or are their own, above which a robot has sides."""
MANY = 3
"""Fewest limbs on which a robot could stand whose trunk lies as low as their ends."""
MOST_JOINTS, MOST_ROWS = 300, 24
"""Joints of a robot above which no symmetry is looked for, and limbs that propose its plane."""
ACROSS = np.array([0.0, 1.0, 0.0])
"""From right to left as descriptions usually have it (ROS REP 103); it decides where a robot is as
symmetric front to rear."""


@dataclass(frozen=True, kw_only=True)
class KinematicChain:
    """Joints in a row from where the robot branches to a link that carries no other joint."""

    joints: tuple[str, ...]
    """Hinges and slides, from the trunk outwards."""
    end: str
    """The last link."""
    tip: tuple[float, float, float]
    """Centre of mass of that link, m, in the world as the robot is described."""
    foot: bool
    """Whether a robot that moves freely could stand on it: its end is among the lowest parts, and
    the trunk is higher or there are `MANY` such limbs of two joints or more."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Limbs:
    """A robot's limbs and its plane of symmetry."""

    limbs: tuple[KinematicChain, ...]
    """Each limb, front to rear, left before right."""
    normal: Array | None
    """Of length 1, shape (3,), along y or, at right angles to it, x; from right to left of a robot
    that faces x or -y. None of a robot without sides."""
    twins: dict[str, str]
    """By joint its mirror image, its own where it lies on the plane; others have none."""
    lying: bool = False
    """Whether the trunk of a robot that moves freely is among its lowest parts."""

    @property
    def feet(self) -> tuple[KinematicChain, ...]:
        """Those that are feet."""
        return tuple(limb for limb in self.limbs if limb.foot)


def torso_of(robot: Robot) -> str | None:
    """Return the link that moves freely in space or in a plane; None if there is no such link.

    A rider on a board has two such links: its own is the last. A ball that lies beside a robot,
    from which nothing driven hangs, is not the robot's.
    """
    freedoms: dict[str, int] = {}
    for joint in robot.joints:
        freedoms[joint.link] = freedoms.get(joint.link, 0) + FREEDOMS[joint.kind]
    held = {joint.link for joint in robot.joints if joint.name in robot.driven}
    loose = [link for link, count in freedoms.items() if count >= 3 and link not in held]
    parent = {link.name: link.parent for link in robot.links}
    carrying = set()
    for link in held:
        while link in parent and link not in loose:
            link = parent[link]
        carrying.add(link)
    own = [link for link in loose if link in carrying] if held else loose
    return own[-1] if own else None


def limbs_of(robot: Robot, model: Any = None) -> Limbs:
    """Return a robot's limbs, as it is described; renaming and turning axes changes nothing.

    Args:
        robot: The robot.
        model: Its compiled `mujoco.MjModel`, where there is one already.
    """
    model = spec_of(robot).compile() if model is None else model
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    tree = JointTree(model, data)
    rows = tree.rows()
    normal, twins = _symmetry(tree, rows)
    height = max(tree.size, 1e-9)
    grounds = [min((tree.lowest(body) for body in range(1, model.nbody)), default=0.0)]
    trunk = torso_of(robot)
    lying = trunk is not None and tree.lowest(model.body(trunk).id) - grounds[0] < LOW * height
    if lying:
        # It lies on its trunk, as a snake does; an ant could stand.
        ends = [tree.lowest(int(model.jnt_bodyid[row[-1]])) for row in rows if len(row) > 1]
        many = sum(low - min(ends) < LOW * height for low in ends) >= MANY
        grounds = [min(ends)] if many else []
    found = []
    for row in rows:
        end = int(model.jnt_bodyid[row[-1]])
        x, y, z = data.xipos[end].tolist()
        found.append(
            KinematicChain(
                joints=tuple(model.joint(at).name for at in row),
                end=model.body(end).name,
                tip=(x, y, z),
                foot=trunk is not None
                and any(abs(tree.lowest(end) - ground) < LOW * height for ground in grounds),
            )
        )
    across = ACROSS if normal is None else normal
    ahead = np.cross(across, [0.0, 0.0, 1.0])
    places = np.array([limb.tip for limb in found]).reshape(-1, 3)
    # Rounded, so that a limb is not in front of its twin by a rounding error.
    fore = np.round(places @ ahead / (NEAR * height))
    order = sorted(range(len(found)), key=lambda at: (-fore[at], -float(places[at] @ across)))
    return Limbs(
        limbs=tuple(found[at] for at in order),
        normal=normal,
        lying=lying,
        twins={model.joint(one).name: model.joint(other).name for one, other in twins.items()},
    )


class JointTree:
    """The hinges and slides of a model, and which hangs from which.

    `data` holds where they are: it has gone through `mj_kinematics` and `mj_comPos`.
    """

    def __init__(self, model: Any, data: Any) -> None:
        self.model, self.data = model, data
        scalar = np.isin(model.jnt_type, (HINGE, SLIDE))
        self.joints: list[int] = np.flatnonzero(scalar).tolist()
        self.parent = {at: self._above(at) for at in self.joints}

    def _above(self, joint: int) -> int:
        """Return the joint that a joint hangs from; -1 if none."""
        body = int(self.model.jnt_bodyid[joint])
        if joint - 1 in self._of(body):
            return joint - 1
        body = int(self.model.body_parentid[body])
        while body and not self._of(body):
            body = int(self.model.body_parentid[body])
        return self._of(body)[-1] if body else -1

    def _of(self, body: int) -> list[int]:
        first = int(self.model.body_jntadr[body])
        every = range(first, first + int(self.model.body_jntnum[body]))
        return [at for at in every if self.model.jnt_type[at] in (HINGE, SLIDE)]

    def rows(self) -> list[tuple[int, ...]]:
        """Return joints in rows, from where the tree branches to where no joint follows."""
        follow: dict[int, list[int]] = {at: [] for at in (-1, *self.joints)}
        for at in self.joints:
            follow[self.parent[at]].append(at)
        rows = []
        for leaf in (at for at in self.joints if not follow[at]):
            row = [leaf]
            while self.parent[row[-1]] >= 0 and len(follow[self.parent[row[-1]]]) == 1:
                row.append(self.parent[row[-1]])
            rows.append(tuple(reversed(row)))
        return rows

    @cached_property
    def size(self) -> float:
        """Greatest distance of two joints or ends from each other, about, m."""
        points = np.concatenate([self.data.xanchor[self.joints], self.data.xipos[1:]])
        return float(np.linalg.norm(np.ptp(points, axis=0))) if len(points) else 0.0

    def lowest(self, body: int) -> float:
        """Return the height of the lowest shape of a link and what is fixed to it, m.

        It is that of the box about each shape, along the shape's own axes.
        """
        model = self.model
        whole = model.body_weldid[model.geom_bodyid] == model.body_weldid[body]
        upwards = self.data.geom_xmat[whole].reshape(-1, 3, 3)[:, 2]
        middle, half = np.split(model.geom_aabb[whole], 2, axis=1)
        heights = self.data.geom_xpos[whole, 2] + (upwards * middle - np.abs(upwards * half)).sum(1)
        return float(heights.min(initial=self.data.xipos[body, 2]))


def _symmetry(
    tree: JointTree, rows: Sequence[tuple[int, ...]]
) -> tuple[Array | None, dict[int, int]]:
    """Return the plane in which most joints have mirror images, and each one's image."""
    data, best = tree.data, (0.0, 0, 0.0)
    result: tuple[Array | None, dict[int, int]] = (None, {})
    if len(tree.joints) > MOST_JOINTS:
        return result
    longest = sorted(rows, key=lambda row: -len(row))[:MOST_ROWS]
    for at, one in enumerate(longest):
        for other in longest[at + 1 :]:
            if len(one) != len(other):
                continue
            ends = [data.xipos[int(tree.model.jnt_bodyid[row[-1]])] for row in (one, other)]
            apart = ends[0] - ends[1]
            length = float(np.linalg.norm(apart))
            if length <= NEAR * tree.size:
                continue
            normal = apart / length
            twins = _twins(tree, normal, 0.5 * (ends[0] + ends[1]))
            paired = sum(first != second for first, second in twins.items())
            rank = (len(twins) / len(tree.joints), paired, abs(float(normal @ ACROSS)))
            if paired and rank[0] > SYMMETRIC and rank > best:
                side = normal @ ACROSS or normal[0]
                best, result = rank, (normal if side > 0.0 else -normal, twins)
    return result


def _twins(tree: JointTree, normal: Array, middle: Array) -> dict[int, int]:
    """Return by joint the one that lies where its mirror image would, and turns as that."""
    joints: Integers = np.array(tree.joints)
    place, axis = tree.data.xanchor[joints], tree.data.xaxis[joints]
    kind = tree.model.jnt_type[joints]
    image = place - 2.0 * np.outer((place - middle) @ normal, normal)
    along = np.outer(axis @ normal, normal)
    # An axis of rotation is an axial vector: its part along the normal stays.
    turned = np.where((kind == HINGE)[:, None], 2.0 * along - axis, axis - 2.0 * along)
    apart = np.linalg.norm(image[:, None] - place[None], axis=2)
    alike = (np.abs(turned @ axis.T) > PARALLEL) & (kind[:, None] == kind)
    apart = np.where(alike, apart, np.inf)
    carried = np.log(np.maximum(tree.model.body_subtreemass[tree.model.jnt_bodyid[joints]], 1e-9))
    # Of two beside each other the one that carries as much; masses themselves may be wrong.
    unlike = apart + NEAR * tree.size * np.abs(carried[:, None] - carried[None])
    nearest = unlike.argmin(axis=1)
    return {
        int(joints[at]): int(joints[to])
        for at, to in enumerate(nearest.tolist())
        if apart[at, to] < BESIDE * tree.size and nearest[to] == at
    }
