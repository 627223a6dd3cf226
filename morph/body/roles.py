"""Which joints do the same thing, as all knees do, by geometry alone: names only label them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.limbs import ACROSS, HINGE, NEAR, JointTree, limbs_of, torso_of
from morph.body.robot import Robot
from morph.body.spec import spec_of

ALIKE = 0.15
"""Share by which the masses that two joints of one role carry differ at most."""
EVEN = 0.25
"""Share of the middle distance between neighbours by which those of a chain differ at most."""
LONG = 4
"""Fewest joints in a row, without legs, that bend alike, as those of a snake do."""
ALONG = 0.7
"""Least cosine between two axes that are compared as they stand."""
GENERIC = {"", "servo", "motor", "joint", "actuator"}
"""Words of a name that tell no joint from another."""


@dataclass(frozen=True, kw_only=True)
class Role:
    """What a joint or an actuator does, and where, in comparison with those of the same role."""

    name: str
    """The words that the names of this role have in common, such as `hip`; a label alone."""
    order: int
    """Number of the role: from the trunk outwards, front to rear. By it roles are compared."""
    side: float | None
    """0 for left, 1 for right, None on the plane of symmetry or without one."""
    place: float | None
    """0 in front to 1 at the rear, None where all of the role stand side by side."""
    sense: float
    """1 or -1: times this, equal motions of one role are mirror images, or parallel front to
    rear; the first of a role turns to its left, ahead or up."""


def joint_roles(robot: Robot) -> dict[str, Role]:
    """Return the role of each hinge and slide, as the robot is described.

    Two joints have one role where they are mirror images, or where they hang alike from joints
    of one role (or from the trunk) and carry as much as far: hips in front and at the rear. In a
    free body without limbs, whose joints follow each other at equal distances, those with
    parallel axes have one role. Renaming, turning axes and reordering change nothing but labels.
    """
    model: Any = spec_of(robot).compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    tree = JointTree(model, data)
    found = limbs_of(robot, model)
    normal = ACROSS if found.normal is None else found.normal
    twins = {model.joint(one).id: model.joint(two).id for one, two in found.twins.items()}
    frame = np.array([normal, np.cross(normal, [0.0, 0.0, 1.0]), [0.0, 0.0, 1.0]])
    sorter = _Sorter(tree, frame, twins, free=torso_of(robot) is not None)
    roles: dict[str, Role] = {}
    groups = sorter.groups()
    labels = _labels([[model.joint(at).name for at in group] for group in groups])
    for order, (group, label) in enumerate(zip(groups, labels, strict=True)):
        for at, side, place, sense in sorter.members(group):
            roles[model.joint(at).name] = Role(
                name=label, order=order, side=side, place=place, sense=sense
            )
    return roles


def actuator_roles(robot: Robot) -> dict[str, Role]:
    """Return the role of each actuator by its name: its joint's.

    What drives no joint, such as a thruster, has a role of its own.
    """
    joints = joint_roles(robot)
    known: dict[str, Role] = {}
    order = 1 + max((role.order for role in joints.values()), default=-1)
    for actuator in robot.actuators:
        role = joints.get(actuator.joint or "")
        if role is None:
            role = Role(name=actuator.name, order=order, side=None, place=None, sense=1.0)
            order += 1
        known[actuator.name] = role
    groups = sorted({role.order for role in known.values()})
    labels = _labels(
        [[name for name, role in known.items() if role.order == order] for order in groups]
    )
    names = dict(zip(groups, labels, strict=True))
    return {name: replace(role, name=names[role.order]) for name, role in known.items()}


class _Sorter:
    """Joints by role, in lengths of the body's own size and along its own axes."""

    def __init__(self, tree: JointTree, frame: Array, twins: dict[int, int], *, free: bool) -> None:
        model, data = tree.model, tree.data
        self.tree, self.twins, self.free = tree, twins, free
        size = max(tree.size, 1e-9)
        self.place = data.xanchor @ frame.T / size
        """To the left, ahead and up."""
        self.ahead = {
            at: float(self.place[[at, twins.get(at, at)], 1].mean()) for at in tree.joints
        }
        """A joint is as far ahead as its twin, also where the two lie a little apart."""
        self.axis = data.xaxis @ frame.T
        self.hinge = model.jnt_type == HINGE
        self.mass = model.body_subtreemass[model.jnt_bodyid]
        self.centre = data.subtree_com[model.jnt_bodyid] @ frame.T / size
        self.depth = {at: 0 if tree.parent[at] < 0 else -1 for at in tree.joints}
        for at in tree.joints:
            # A joint comes after the one that it hangs from.
            self.depth[at] = 0 if tree.parent[at] < 0 else self.depth[tree.parent[at]] + 1

    def groups(self) -> list[list[int]]:
        """Return the joints of each role, the first of each and the roles in one order."""
        chain = self._chain()
        label: dict[int, int] = {}
        for at in self.tree.joints:
            known = [
                other
                for other in label
                if (at in chain and self._parallel(at, other))
                or self.twins.get(at) == other
                or self._alike(at, other, label)
            ]
            label[at] = label[known[0]] if known else at
            # A twin on the other side may join two roles that were apart.
            joined = {label[other] for other in known}
            label = {one: label[at] if each in joined else each for one, each in label.items()}
        groups: dict[int, list[int]] = {}
        for at, each in label.items():
            groups.setdefault(each, []).append(at)
        return sorted(
            (sorted(group, key=self._rank) for group in groups.values()),
            key=lambda group: self._rank(group[0]),
        )

    def _rank(self, at: int) -> tuple[float, ...]:
        """Return by what joints are in order: trunk first, then front, left and top."""
        left, _, up = np.round(self.place[at] / NEAR + 0.01234)
        ahead = np.round(self.ahead[at] / NEAR + 0.01234)
        return (self.depth[at], -ahead, -left, -up, *np.round(-np.abs(self.axis[at]), 2))

    def _chain(self) -> set[int]:
        """Return the joints of a snake; of other bodies none."""
        joints = self.tree.joints
        parents = [self.tree.parent[at] for at in joints]
        if not self.free or len(joints) < LONG or len(set(parents)) < len(parents):
            return set()
        apart = np.linalg.norm(np.diff(self.place[joints], axis=0), axis=1)
        even = np.abs(apart - np.median(apart)) <= EVEN * np.median(apart)
        return set(joints) if even.all() else set()

    def _parallel(self, one: int, two: int) -> bool:
        return bool(abs(self.axis[one] @ self.axis[two]) > ALONG)

    def _alike(self, one: int, two: int, label: dict[int, int]) -> bool:
        """Return whether two joints of different limbs hang and carry alike."""
        above, beside = self.tree.parent[one], self.tree.parent[two]
        if above in self._over(two) or beside in self._over(one):
            return False
        if (above < 0) != (beside < 0) or self.hinge[one] != self.hinge[two]:
            return False
        if above >= 0 and label[above] != label[beside]:
            return False
        masses = self.mass[[one, two]]
        if np.ptp(masses) > ALIKE * masses.max():
            return False
        # Upright and level parts stay as they are if a limb is turned about the vertical.
        if abs(abs(self.axis[one, 2]) - abs(self.axis[two, 2])) > 1.0 - ALONG:
            return False
        arms = [self.centre[at] - self.place[at] for at in (one, two)]
        if above >= 0:
            arms += [self.place[one] - self.place[above], self.place[two] - self.place[beside]]
        shapes = [(np.hypot(arm[0], arm[1]), arm[2]) for arm in arms]
        return all(
            float(np.hypot(*np.subtract(first, second))) < NEAR
            for first, second in zip(shapes[::2], shapes[1::2], strict=True)
        )

    def _over(self, at: int) -> list[int]:
        over, at = [], self.tree.parent[at]
        while at >= 0:
            over.append(at)
            at = self.tree.parent[at]
        return over

    def members(self, group: Sequence[int]) -> list[tuple[int, float | None, float | None, float]]:
        """Return each joint of a role with its side, its place and its sense."""
        ahead = np.array([self.ahead[at] for at in group])
        steps = np.concatenate([[0], np.cumsum(np.diff(np.sort(ahead)[::-1]) < -NEAR)])
        ranks = steps[np.argsort(np.argsort(-ahead, kind="stable"), kind="stable")]
        first = group[0]
        # A body's first joint of a role turns to its left, else ahead, else up.
        lead = self.axis[first][np.argmax(np.abs(self.axis[first]) * (1.0, 0.9, 0.8))]
        result = []
        for at, rank in zip(group, ranks.tolist(), strict=True):
            twin = self.twins.get(at, at)
            side = None if twin == at else float(self.place[at, 0] < self.place[twin, 0])
            place = rank / int(steps[-1]) if steps[-1] else None
            sense = float(np.sign(lead)) * self._sense(at, first)
            result.append((at, side, place, sense))
        return result

    def _sense(self, at: int, first: int) -> float:
        """Return 1 where two axes of a role turn alike, -1 where one turns against the other."""
        twin = self.twins.get(at, at)
        if twin != at and self.place[at, 0] < self.place[twin, 0]:
            mirrored = self._mirrored(twin, 0)
            return float(np.sign(mirrored @ self.axis[at])) * self._sense_beside(twin, first)
        return self._sense_beside(at, first)

    def _sense_beside(self, at: int, first: int) -> float:
        """Return the same of two on one side: as they stand, else as mirrored front to rear."""
        same = float(self.axis[at] @ self.axis[first])
        if abs(same) < ALONG:
            same = float(self.axis[at] @ self._mirrored(first, 1))
        return 1.0 if same >= 0.0 else -1.0

    def _mirrored(self, at: int, normal: int) -> Array:
        """Return the axis of a joint's mirror image in the plane of one axis of the frame."""
        image = self.axis[at].copy()
        image[normal] *= -1.0
        # An axis of rotation is an axial vector: its part along the normal stays.
        return np.asarray(-image if self.hinge[at] else image)


def _labels(groups: Sequence[Sequence[str]]) -> list[str]:
    """Return what names of each group have in common, the first name where that is nothing."""
    labels = []
    for names in groups:
        words = [re.split(r"[_\W]+", name.lower()) for name in names]
        common = [
            word
            for word in words[0]
            if word not in GENERIC and all(word in other for other in words[1:])
        ]
        labels.append("_".join(common) or names[0].lower())
    whole = [
        label if labels.count(label) == 1 else names[0].lower()
        for label, names in zip(labels, groups, strict=True)
    ]
    return [
        label if whole.count(label) == 1 else f"{label} {at + 1}" for at, label in enumerate(whole)
    ]
