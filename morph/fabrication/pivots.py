"""Joints without a servo: where along its axis each is halved between its two links."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from morph.arrays import Array
from morph.fabrication.drawing import MM, Drawing
from morph.fabrication.rigid import roots
from morph.print.mesh import Mesh
from morph.print.skeleton import Pivot

AXLES = ((13.5, "608"), (7.5, "623"), (4.0, "M3"), (0.0, "M2"))
"""Least radius of the thinner of the two links at the joint, mm, and its bearing or screw."""

NEAR_MM = 15.0
"""How far from the axis a link's solids still count as being at the joint."""

Solids = Mapping[str, Sequence[Mesh]]


@dataclass(frozen=True, kw_only=True, eq=False)
class Axis:
    """A joint without a servo, in the world with all joints at zero."""

    name: str
    """The joint or the loop."""
    still: str
    """The link that stays."""
    moving: str
    """The link that moves."""
    position: Array
    """A point on it, mm, shape (3,)."""
    direction: Array
    """Unit vector, shape (3,)."""


def passive(drawing: Drawing, driven: set[str]) -> tuple[Axis, ...]:
    """Return the hinges between two links that no servo turns, and the pins of closed chains."""
    robot, model, data = drawing.robot, drawing.model, drawing.data
    parents = {link.name: link.parent for link in robot.links}
    results = [
        Axis(
            name=joint.name,
            still=parents[joint.link],
            moving=joint.link,
            position=MM * data.xanchor[model.joint(joint.name).id],
            direction=data.xaxis[model.joint(joint.name).id].copy(),
        )
        for joint in robot.joints
        if joint.kind == "hinge" and parents[joint.link] in parents and joint.name not in driven
    ]
    return (*results, *_pins(drawing))


def _pins(drawing: Drawing) -> list[Axis]:
    """Return the pins that close chains: about an axis parallel to that of the link's own hinge."""
    robot, model, data = drawing.robot, drawing.model, drawing.data
    hinges = {joint.link: joint for joint in robot.joints if joint.kind == "hinge"}
    results = []
    for at in range(model.neq):
        if model.eq_type[at] != mujoco.mjtEq.mjEQ_CONNECT:
            continue
        if model.eq_objtype[at] != mujoco.mjtObj.mjOBJ_BODY:
            continue
        first, other = (model.body(int(ids[at])).name for ids in (model.eq_obj1id, model.eq_obj2id))
        if first not in hinges or other not in drawing.shapes:
            continue
        body = model.body(first).id
        pin = data.xmat[body].reshape(3, 3) @ model.eq_data[at, :3] + data.xpos[body]
        results.append(
            Axis(
                name=model.eq(at).name or f"{first} to {other}",
                still=other,
                moving=first,
                position=MM * pin,
                direction=data.xaxis[model.joint(hinges[first].name).id].copy(),
            )
        )
    return results


def pivots(drawing: Drawing, axes: Sequence[Axis], solids: Solids) -> dict[str, list[Pivot]]:
    """Return the pivots in each link's frame, by its name.

    Args:
        drawing: The body.
        axes: Its joints without a servo.
        solids: What is printed of each link, in the world with all joints at zero.
    """
    fixed = roots(drawing.robot)
    results: dict[str, list[Pivot]] = {}
    for axis in axes:
        still = _holder(fixed, axis.still, axis, solids)
        moving = _holder(fixed, axis.moving, axis, solids)
        ends = [_along(axis, solids.get(link, ())) for link in (still, moving)]
        middle, side = _plane(axis, ends, solids, (still, moving))
        radius = min(_radius(axis, solids.get(link, ())) for link in (still, moving))
        name = next(name for least, name in AXLES if radius >= least)
        position = axis.position + middle * axis.direction
        for link, way in ((still, -side), (moving, side)):
            if link not in solids:
                continue
            to_link = np.linalg.inv(drawing.world(link))
            turned = to_link[:3, :3] @ axis.direction
            # The moving part is always on side 1: it is the axis that is turned about.
            results.setdefault(link, []).append(
                Pivot(
                    position=to_link[:3, :3] @ position + to_link[:3, 3],
                    axis=turned * side,
                    side=1 if way == side else -1,
                    bearing=name,
                )
            )
    return results


def _holder(fixed: Mapping[str, str], link: str, axis: Axis, solids: Solids) -> str:
    """Return which of the links that are one rigid body with a link is nearest to its joint."""
    group = [each for each in fixed if fixed[each] == fixed[link] and each in solids]
    if link in solids or not group:
        return link
    return min(group, key=lambda each: _distance(axis, solids[each]))


def _distance(axis: Axis, solids: Sequence[Mesh]) -> float:
    away = [np.abs(mesh.bounds - axis.position).min(axis=0).max() for mesh in solids]
    return float(min(away))


def _along(axis: Axis, solids: Sequence[Mesh]) -> tuple[float, float] | None:
    """Return from where to where a link's solids are near the joint's axis, mm; None if none are.

    Only what is connected to the place of the joint counts, or what is nearest to it.
    """
    spans = []
    for mesh in solids:
        away = mesh.vertices - axis.position
        along = away @ axis.direction
        across = np.linalg.norm(away - np.outer(along, axis.direction), axis=1)
        around = _contains(mesh, axis)
        if around or across.min() < NEAR_MM:
            near = np.ones(len(along), dtype=bool) if around else across < across.min() + NEAR_MM
            spans.append((float(along[near].min()), float(along[near].max())))
    if not spans:
        return None
    here = [span for span in spans if span[0] - 0.1 <= 0.0 <= span[1] + 0.1]
    if not here:
        left = [span for span in spans if span[1] < 0.0]
        right = [span for span in spans if span[0] > 0.0]
        # A fork holds it from both sides: its joint is in the middle.
        here = spans if left and right else [min(spans, key=lambda span: min(map(abs, span)))]
    return min(low for low, _ in here), max(high for _, high in here)


def _contains(mesh: Mesh, axis: Axis) -> bool:
    """Return whether the axis goes through a convex solid near the joint."""
    from morph.print.solid import frame, placed, rod

    pin = placed(rod(0.5, -200.0, 200.0), frame(axis.position, axis.direction))
    return bool((pin ^ mesh.manifold).volume() > 0.0)


def _plane(
    axis: Axis,
    ends: Sequence[tuple[float, float] | None],
    solids: Solids,
    links: tuple[str, str],
) -> tuple[float, int]:
    """Return where along its axis a joint is halved, mm, and on which side what moves lies."""
    still, moving = ends
    if still is None and moving is None:
        return 0.0, 1
    if still is None or moving is None:
        low, high = still or moving or (0.0, 0.0)
        middle = 0.0 if low < 0.0 < high else (low + high) / 2.0
        return middle, _freer(axis, middle, solids, links)
    if still[1] <= moving[0] or moving[1] <= still[0]:
        above = still[1] <= moving[0]
        middle = (still[1] + moving[0]) / 2.0 if above else (moving[1] + still[0]) / 2.0
        return middle, 1 if above else -1
    low, high = max(still[0], moving[0]), min(still[1], moving[1])
    middle = 0.0 if low < 0.0 < high else (low + high) / 2.0
    return middle, _freer(axis, middle, solids, links)


def _freer(axis: Axis, middle: float, solids: Solids, links: tuple[str, str]) -> int:
    """Return the side for what moves on which less is in the way; 1 if both are equal."""
    from morph.print.solid import frame, placed, rod, union

    pose = frame(axis.position + middle * axis.direction, axis.direction)
    cost = []
    for side in (1, -1):
        lost = 0.0
        for link, way in zip(links, (-side, side), strict=True):
            # Each link keeps its side and loses what it has on the other.
            room = rod(8.0, -60.0, 0.0) if way > 0 else rod(8.0, 0.0, 60.0)
            body = union([mesh.manifold for mesh in solids.get(link, ())])
            lost += float((placed(room, pose) ^ body).volume())
        cost.append(lost)
    return 1 if cost[0] <= cost[1] * 1.01 + 1.0 else -1


def _radius(axis: Axis, solids: Sequence[Mesh]) -> float:
    """Return half the width of the solid nearest to a joint: the middle one of its extents."""
    if not solids:
        return float("inf")
    near = min(solids, key=lambda mesh: float(_nearest(mesh, axis.position)))
    return float(np.sort(_extents(near))[1]) / 2.0


def _nearest(mesh: Mesh, point: Array) -> float:
    inside = np.all((mesh.bounds[0] <= point) & (point <= mesh.bounds[1]))
    return 0.0 if inside else float(np.linalg.norm(mesh.vertices - point, axis=1).min())


def _extents(mesh: Mesh) -> Array:
    """Return a solid's extents along its own axes, mm, shape (3,)."""
    points = mesh.vertices - mesh.vertices.mean(axis=0)
    _, axes = np.linalg.eigh(points.T @ points)
    return np.asarray(np.ptp(points @ axes, axis=0), dtype=np.float64)
