"""What a body is and what is wrong with its description, without an exception."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import mujoco
import numpy as np

from morph.body.finding import DescriptionFinding
from morph.body.limbs import Limbs, limbs_of
from morph.body.load import load
from morph.body.postures import REST, STANDING, keyframes_of
from morph.body.quiet import quiet
from morph.body.refusal import about_file
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.body.standing import StandingPosture, standing
from morph.errors import DescriptionRefused, RobotError

SCHEMA = "morph.inspection/1"
"""Name and version of what `as_json` gives back."""


@dataclass(frozen=True, kw_only=True)
class Inspection:
    """A body as it was found."""

    name: str
    """The robot's name, or the file's if there is no robot."""
    findings: tuple[DescriptionFinding, ...]
    """Everything found, in the order of the checks."""
    robot: Robot | None
    """The robot; None if it was refused."""
    com: tuple[float, float, float] | None = None
    """Centre of mass at home, in the world, m."""
    dof: int = 0
    """Degrees of freedom."""
    reach: float = 0.0
    """Furthest that any part is from the base at home, m."""
    limbs: Limbs | None = None
    """Its limbs and their mirror images; None if there is no robot."""
    keyframes: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    """The postures that its description names."""
    standing: StandingPosture | None = None
    """How it stands on its feet; None if it has none."""

    @property
    def verdict(self) -> Literal["ok", "repaired", "refused"]:
        """`ok`, `repaired` (the robot differs from its description) or `refused`."""
        severities = {finding.severity for finding in self.findings}
        if self.robot is None or "refused" in severities:
            return "refused"
        return "repaired" if "repaired" in severities else "ok"

    def as_json(self) -> dict[str, Any]:
        """Return it as JSON holds it, by the schema `morph.inspection/1`."""
        robot = self.robot
        return {
            "schema": SCHEMA,
            "name": self.name,
            "mass_kg": None if robot is None else robot.mass,
            "com_m": None if self.com is None else list(self.com),
            "dof": self.dof,
            "reach_m": self.reach,
            "links": [] if robot is None else [_link(link) for link in robot.links],
            "joints": [] if robot is None else [_joint(joint) for joint in robot.joints],
            "actuators": [] if robot is None else [asdict(part) for part in robot.actuators],
            "sensors": [] if robot is None else [asdict(part) for part in robot.sensors],
            "closures": [] if robot is None else [asdict(part) for part in robot.loops],
            "limbs": [] if self.limbs is None else [asdict(limb) for limb in self.limbs.limbs],
            "twins": {} if self.limbs is None else self.limbs.twins,
            "postures": self._postures(),
            "standing": None if self.standing is None else self.standing.as_json(),
            "findings": [finding.as_json() for finding in self.findings],
            "verdict": self.verdict,
        }

    def _postures(self) -> dict[str, dict[str, float]]:
        if self.robot is None:
            return {}
        on_feet = {} if self.standing is None else {STANDING: dict(self.standing.position)}
        return {REST: {}, **on_feet, **{name: dict(each) for name, each in self.keyframes.items()}}


def inspect_robot(
    robot: str | Path,
    *,
    base: str | None = None,
    folder: str | Path | None = None,
    second_opinion: bool = True,
) -> Inspection:
    """Return what a body is and what was found in its description.

    Args:
        robot: As `morph.load` takes it.
        base: As `morph.load` takes it.
        folder: As `morph.load` takes it.
        second_opinion: Whether Pinocchio reads the description too, and a
            disagreement that no repair explains is a finding.
    """
    try:
        result = load(robot, base=base, folder=folder)
    except RobotError as error:
        return _refused(robot, error)
    findings = list(result.findings)
    if second_opinion:
        from morph.body.agreement import disagreement

        findings += disagreement(result)
    spec = spec_of(result)
    touching = [(geom, geom.contype, geom.conaffinity) for geom in spec.geoms]
    for geom in spec.geoms:
        geom.contype = geom.conaffinity = 0  # So that MuJoCo computes no hulls.
    with quiet():
        model = spec.compile()
        for geom, kind, others in touching:
            model.geom_contype[geom.id], model.geom_conaffinity[geom.id] = kind, others
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
    x, y, z = data.subtree_com[0].tolist()
    return Inspection(
        name=result.name,
        findings=tuple(findings),
        robot=replace(result, findings=tuple(findings)),
        com=(x, y, z),
        dof=int(model.nv),
        reach=_reach(model, data),
        limbs=limbs_of(result, model),
        keyframes=keyframes_of(result, model),
        standing=standing(result, model),
    )


def _refused(robot: str | Path, error: RobotError) -> Inspection:
    path = Path(robot)
    if isinstance(error, DescriptionRefused):
        return Inspection(name=_named(path), findings=error.findings, robot=None)
    return Inspection(name=_named(path), findings=(about_file(error, path),), robot=None)


def _named(path: Path) -> str:
    """Return the name of a file without its ending; of `.` and the like, of what they mean."""
    if path.stem.strip("."):
        return path.stem
    try:
        real = path.resolve()
    except (OSError, RuntimeError, ValueError):
        return str(path)
    return real.name or str(real)


def _reach(model: Any, data: Any) -> float:
    """Return how far the furthest corner of a geom's box, or origin of a link, is from the base.

    What stands in the world, ground and walls, is no part of the robot.
    """
    if model.nbody < 2:
        return 0.0
    base = data.xpos[1]
    points = [data.xpos[1:]]
    corners = np.array(np.meshgrid((-1, 1), (-1, 1), (-1, 1))).reshape(3, -1).T
    for geom in range(model.ngeom):
        kind = mujoco.mjtGeom(model.geom_type[geom])
        ground = kind in (mujoco.mjtGeom.mjGEOM_PLANE, mujoco.mjtGeom.mjGEOM_HFIELD)
        if ground or model.geom_bodyid[geom] == 0:
            continue
        centre, half = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
        turn = data.geom_xmat[geom].reshape(3, 3)
        points.append((centre + corners * half) @ turn.T + data.geom_xpos[geom])
    return float(np.linalg.norm(np.concatenate(points) - base, axis=1).max())


def _link(link: Any) -> dict[str, Any]:
    return {
        "name": link.name,
        "parent": link.parent,
        "mass_kg": link.mass,
        "com_m": list(link.com),
        "inertia_kg_m2": list(link.inertia),
        "inertia_from": link.inertia_from,
        "shapes": list(link.shapes),
    }


def _joint(joint: Any) -> dict[str, Any]:
    return {
        "name": joint.name,
        "kind": joint.kind,
        "link": joint.link,
        "axis": list(joint.axis),
        "limits": None if joint.limits is None else list(joint.limits),
        "effort": joint.effort,
        "velocity": joint.velocity,
        "damping": joint.damping,
        "friction": joint.friction,
        "unit": joint.unit,
        "mimic": None if joint.mimic is None else asdict(joint.mimic),
    }
