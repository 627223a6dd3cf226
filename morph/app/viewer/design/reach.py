"""How far a body gets from where it is held."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from morph.app.picture.shapes import PictureShape
from morph.arrays import Array, Integers
from morph.body.posture import HINGE, Posture

SWEEPS = 20
"""Most rounds over the joints from one pose: each joint in turn goes where it is best."""

STARTS = 4
"""Of the poses drawn, how many of the best are made better so."""


class Reach:
    """The farthest that any point of a body gets from its base.

    The base is where the first link is held: the anchor of its hinge, or else its own frame;
    a body that floats or rolls takes it along. Bodies of several trees have one base each.

    Args:
        posture: The poses that it can take.
        shapes: What it looks like.
    """

    def __init__(self, posture: Posture, shapes: Sequence[PictureShape]) -> None:
        """Keep the points that can be farthest."""
        self._posture, model = posture, posture.model
        drawn = {
            body: corners(
                np.concatenate([shape.vertices for shape in shapes if shape.body == body])
            )
            for body in {shape.body for shape in shapes if shape.body > 0}
        }
        # Of a link that is not drawn, its frame counts.
        every = [drawn.get(body, np.zeros((1, 3))) for body in range(1, model.nbody)]
        self._all = _Points.of(model, every)
        self._few = _Points.of(model, [_outer(points) for points in every])
        lasts = {
            int(root): int(model.body_jntadr[root] + model.body_jntnum[root]) - 1
            for root in set(model.body_rootid[1:].tolist())
            if model.body_jntnum[root]
        }
        self._hinged = {
            root: joint for root, joint in lasts.items() if model.jnt_type[joint] == HINGE
        }

    def at(self, data: Any) -> tuple[float, int]:
        """Return how far the farthest point is in the pose of a `mujoco.MjData`, m, and which."""
        return self._all.farthest(data, self._bases(data))

    def most(self, poses: Sequence[Array]) -> float:
        """Return the farthest of some poses and of what is better near the best of them, m.

        For one hinge, with the others at rest, the best angle is known in closed form: a point
        at c + k + r, k along the axis and r across, is at angle t at a distance d from the base
        with d^2 = const + 2 cos t (r . w) + 2 sin t ((a x r) . w), w = c + k - base; so
        t = atan2((a x r) . w, r . w). A slide is best at one of its ends. Bodies with closed
        loops are only looked at in the poses given.
        """
        posture, model = self._posture, self._posture.model
        data = mujoco.MjData(model)
        reached = []
        for number, pose in enumerate(poses):
            _kinematics(model, data, pose)
            reached.append((self._few.farthest(data, self._bases(data))[0], number))
        _kinematics(model, data, poses[max(reached)[1]])
        best = self.at(data)[0]
        if not len(posture.tied):
            for _, number in sorted(reached, reverse=True)[:STARTS]:
                best = max(best, self._climbed(data, poses[number]))
        return best

    def _climbed(self, data: Any, pose: Array) -> float:
        posture, model = self._posture, self._posture.model
        pose = pose.copy()
        _kinematics(model, data, pose)
        away, far = self.at(data)
        for _ in range(SWEEPS):
            for handle, place, dof in zip(
                posture.handles, posture.places, posture.dofs, strict=True
            ):
                joint = int(model.dof_jntid[dof])
                moves = _carries(model, int(model.jnt_bodyid[joint]), int(self._all.bodies[far]))
                if not moves or not handle.ranged:
                    continue
                old = float(pose[place])
                pose[place] = self._best(data, joint, far, (handle.low, old, handle.high))
                if pose[place] != old:
                    _kinematics(model, data, pose)
            before, (away, far) = away, self.at(data)
            if away <= before * (1.0 + 1e-9):
                break
        return away

    def _best(self, data: Any, joint: int, far: int, span: tuple[float, float, float]) -> float:
        low, old, high = span
        model, axis = self._posture.model, data.xaxis[joint]
        body, root = int(self._all.bodies[far]), int(self._all.roots[far])
        point = data.xpos[body] + data.xmat[body].reshape(3, 3) @ self._all.local[far]
        base = self._base(data, root)
        if model.jnt_type[joint] != HINGE:
            along = float((point - base) @ axis)
            return max((low, high), key=lambda end: abs(along + end - old))
        arm = point - data.xanchor[joint]
        w = data.xanchor[joint] + axis * (axis @ arm) - base
        r = arm - axis * (axis @ arm)
        (a, b, c), (x, y, z) = axis.tolist(), r.tolist()
        across = np.array([b * z - c * y, c * x - a * z, a * y - b * x])
        cosine, sine = float(r @ w), float(across @ w)
        if math.hypot(cosine, sine) < 1e-12:
            return old
        angle = old + math.atan2(sine, cosine)
        tried = [angle + 2.0 * math.pi * turn for turn in (-1, 0, 1)]
        tried = [each for each in tried if low <= each <= high] or [low, high]
        return max(
            tried, key=lambda each: cosine * math.cos(each - old) + sine * math.sin(each - old)
        )

    def _bases(self, data: Any) -> Array:
        """Return each body's base if it is the root of a tree, m, shape (bodies, 3)."""
        result = data.xpos.copy()
        for root in self._hinged:
            result[root] = self._base(data, root)
        return np.asarray(result)

    def _base(self, data: Any, root: int) -> Array:
        joint = self._hinged.get(root)
        return np.array(data.xpos[root] if joint is None else data.xanchor[joint])


@dataclass(frozen=True, kw_only=True, eq=False)
class _Points:
    """Points of a body's links."""

    local: Array
    """In the frames of their links, m, shape (points, 3)."""
    bodies: Integers
    """Whose they are, shape (points,)."""
    roots: Integers
    """The root of the tree that it is of, shape (points,)."""

    @classmethod
    def of(cls, model: Any, every: Sequence[Array]) -> _Points:
        """Return the points of the links 1, 2, ..."""
        bodies = np.repeat(np.arange(1, model.nbody), [len(points) for points in every])
        local = np.concatenate(every)
        return cls(local=local, bodies=bodies, roots=model.body_rootid[bodies].astype(np.int64))

    def world(self, data: Any) -> Array:
        """Return where they are, m, shape (points, 3)."""
        turn = data.xmat.reshape(-1, 3, 3)[self.bodies]
        return np.asarray(data.xpos[self.bodies] + (turn @ self.local[:, :, None])[:, :, 0])

    def farthest(self, data: Any, bases: Array) -> tuple[float, int]:
        """Return how far the farthest is from its base, m, and which it is."""
        away = np.linalg.norm(self.world(data) - bases[self.roots], axis=1)
        far = int(np.argmax(away))
        return float(away[far]), far


def _outer(points: Array) -> Array:
    """Return a few of many points, among them the outermost in each of 26 directions."""
    ways = np.array([way for way in itertools.product((-1.0, 0.0, 1.0), repeat=3) if any(way)])
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    return np.asarray(points[np.unique(np.argmax(points @ ways.T, axis=0))])


def corners(points: Array) -> Array:
    """Return the points among some that no other pose makes inner ones: their convex hull's."""
    from scipy.spatial import ConvexHull, QhullError

    if len(points) < 5:
        return points
    try:
        return np.asarray(points[ConvexHull(points).vertices])
    except QhullError:
        # All in one plane or on one line: all of them stay.
        return points


def _kinematics(model: Any, data: Any, pose: Array) -> None:
    data.qpos[:] = pose
    mujoco.mj_kinematics(model, data)


def _carries(model: Any, link: int, other: int) -> bool:
    while other > link:
        other = int(model.body_parentid[other])
    return other == link
