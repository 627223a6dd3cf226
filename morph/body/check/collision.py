"""Which links would push each other as they are described, as MuJoCo sees their shapes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco

from morph.body.check.place import at_link
from morph.body.draft import Draft
from morph.body.finding import DescriptionFinding
from morph.body.within_limits import within_limits

DEPTH = 0.03
"""How deep shapes overlap, by the radius of the smaller one's bounding sphere; what only touches
does not count."""


@dataclass(frozen=True, kw_only=True)
class Overlap:
    """Two links whose collision shapes overlap at home."""

    one: str
    """The one that stands first in the description."""
    other: str
    """The other."""
    hulls: bool
    """Whether a mesh is one of the shapes: MuJoCo collides its convex hull."""


def overlaps(model: Any, *, world: bool = False) -> list[Overlap]:
    """Return the links between which MuJoCo has contacts that push, at home within limits.

    Args:
        model: The `mujoco.MjModel`.
        world: Whether shapes of the world are parts of the robot, as those of a URDF's root are;
            in an MJCF they are what surrounds it.
    """
    data = mujoco.MjData(model)
    data.qpos[:] = within_limits(model, model.qpos0)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_collision(model, data)
    results: dict[tuple[int, int], bool] = {}
    for contact in data.contact[: data.ncon]:
        if min(contact.geom) < 0:
            # What bends has no bounding sphere.
            continue
        size = min(float(each) for each in model.geom_rbound[contact.geom] if each > 0.0)
        one, other = sorted(int(each) for each in model.geom_bodyid[contact.geom])
        if contact.dist < -DEPTH * size and (one or world):
            mesh = mujoco.mjtGeom.mjGEOM_MESH.value in model.geom_type[contact.geom]
            results[one, other] = results.get((one, other), False) or mesh
    return [
        Overlap(one=model.body(one).name, other=model.body(other).name, hulls=mesh)
        for (one, other), mesh in sorted(results.items())
    ]


def leave_out(spec: Any, model: Any) -> list[Overlap]:
    """Leave contacts out of a spec that a URDF cannot mean; return those of links that overlap.

    A link never collides with the one that a joint hangs it on: so MuJoCo has it, but not where
    that one is bolted to the world.

    Args:
        spec: The `mujoco.MjSpec`, which is changed.
        model: The same, compiled.
    """
    solid = {int(body) for body in model.geom_bodyid[model.geom_contype > 0]}
    fixed = [body for body in solid if not model.body_weldid[body]]
    hung = [
        body
        for body in solid
        if (top := model.body_weldid[body]) and not model.body_weldid[model.body_parentid[top]]
    ]
    joined = {(model.body(one).name, model.body(other).name) for one in fixed for other in hung}
    pairs = [
        pair
        for pair in overlaps(model, world=True)
        if not {(pair.one, pair.other), (pair.other, pair.one)} & joined
    ]
    for one, other in (*sorted(joined), *((pair.one, pair.other) for pair in pairs)):
        spec.add_exclude(bodyname1=one, bodyname2=other)
    return pairs


def self_collisions(draft: Draft, pairs: list[Overlap]) -> list[DescriptionFinding]:
    """Return a finding for each overlap, of which contacts are left out."""
    return [
        DescriptionFinding(
            code="self-collision",
            severity="repaired",
            where=at_link(draft, draft.link(pair.one)),
            what=f"it overlaps {pair.other!r} in the home pose, where contacts would push them"
            + ("; MuJoCo takes convex hulls of meshes" if pair.hulls else ""),
            done="contacts between the two are left out",
            fix="make the collision shapes smaller, or move the home pose",
        )
        for pair in pairs
    ]
