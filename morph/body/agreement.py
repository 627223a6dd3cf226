"""Whether MuJoCo simulates what Pinocchio reads in the same description."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.finding import DescriptionFinding, Where
from morph.body.quiet import quiet
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.errors import RobotError
from morph.extras import install_command

TOLERANCE = 1e-9
"""Greatest relative difference of mass, centre of mass and inertia."""

EXPLAIN = frozenset(
    ["mass-missing", "inertia-missing", "inertia-broken", "limit-range", "joint-axis", "mimic"]
)
"""Repairs that change mass, inertia or joints, and so explain a difference."""

MOST_DOF = 150
"""Most degrees of freedom of a body that Pinocchio is asked about: its data grow with the cube."""

READ = "it read what morph made of it, and agrees with MuJoCo"
"""What is done where Pinocchio cannot read the file itself."""

FIX = "look at what Pinocchio names or leaves out; tell morph if the file is right"
"""What a reader may do about a disagreement."""

UNREAD = "Pinocchio cannot read it: "
"""How `morph.body.twin` begins."""


@dataclass(frozen=True, kw_only=True)
class EngineReading:
    """What an engine makes of a body at home, a free base at the origin."""

    mass: float
    """kg, of all links."""
    com: Array
    """m, shape (3,)."""
    eigenvalues: Array
    """Of the joint-space inertia without rotors, ascending, shape (dof,)."""


def disagreement(robot: Robot) -> list[DescriptionFinding]:
    """Return a finding if the two disagree and no repair explains it.

    Pinocchio reads the robot's own file. Where that cannot be, or where a repair or
    a scale explains the difference, it reads what MuJoCo is given instead, repairs and all.
    Where it is not installed the finding says so.
    """
    if find_spec("pinocchio") is None:
        missing = "Pinocchio, which would check MuJoCo's reading, is not installed"
        return [_finding(robot, missing, fix=install_command("check"))]
    ours, findings = read_by_mujoco(robot), []
    if len(ours.eigenvalues) > MOST_DOF:
        many = f"it has {len(ours.eigenvalues)} degrees of freedom, above {MOST_DOF}"
        return [_finding(robot, many, "Pinocchio was not asked")]
    try:
        worst = difference(ours, read_by_pinocchio(robot))
        repaired = {finding.code for finding in robot.findings if finding.severity == "repaired"}
        weighed = any(link.inertia_from == "measured" for link in robot.links)
        checked = worst <= TOLERANCE or not (repaired & EXPLAIN or weighed)
    except RobotError as error:
        worst, checked = float("inf"), False
        findings = [_finding(robot, f"Pinocchio cannot read the file: {_short(error.what)}", READ)]
    try:
        if not checked:
            worst = difference(ours, read_by_pinocchio(robot, repaired=True))
    except RobotError as error:
        return [_finding(robot, f"Pinocchio cannot read the robot: {_short(error.what)}")]
    if worst <= TOLERANCE:
        return findings
    what = f"mass, centre of mass or inertia differ by {worst:.2g} of their size"
    if not np.isfinite(worst):
        what = "they find different numbers of degrees of freedom"
    return [_finding(robot, what)]


def _finding(robot: Robot, what: str, done: str = "nothing", fix: str = FIX) -> DescriptionFinding:
    return DescriptionFinding(
        code="agreement",
        severity="info",
        where=Where(kind="robot", name=robot.name, file=str(robot.source or "")),
        what=what,
        done=done,
        fix=fix,
    )


def _short(words: str) -> str:
    """Return the message in Pinocchio's words, without where in its own source it stands."""
    return " ".join(words.rpartition("message:")[2].split()).removeprefix(UNREAD)[:200]


def difference(one: EngineReading, other: EngineReading) -> float:
    """Return the greatest relative difference of two readings; infinite if dof differ."""
    if len(one.eigenvalues) != len(other.eigenvalues):
        return float("inf")
    pairs = [(np.array([one.mass]), np.array([other.mass])), (one.eigenvalues, other.eigenvalues)]
    worst = [float(np.abs(a - b).max() / np.abs(b).max()) for a, b in pairs if len(b) and np.any(b)]
    # A centre of mass has no size of its own; a metre stands for it.
    worst.append(float(np.abs(one.com - other.com).max()))
    return max(worst)


def read_by_mujoco(robot: Robot) -> EngineReading:
    """Return what MuJoCo simulates."""
    spec = spec_of(robot)
    # Shapes weigh nothing here, but sensors, tendons and contact pairs name them: they stay,
    # without their meshes, which would take the time.
    for geom in spec.geoms:
        if geom.meshname:
            geom.meshname, geom.type = "", mujoco.mjtGeom.mjGEOM_SPHERE
            geom.size = [0.01, 0.0, 0.0]
    for mesh in list(spec.meshes):
        spec.delete(mesh)
    with quiet():
        model = spec.compile()
        data = mujoco.MjData(model)
        # Where a free base stands is no part of the robot: both put it at the origin.
        for joint in np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_FREE):
            address = model.jnt_qposadr[joint]
            data.qpos[address : address + 7] = (0, 0, 0, 1, 0, 0, 0)
        mujoco.mj_forward(model, data)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    full -= np.diag(model.dof_armature)
    masses = model.body_mass[1:]
    return EngineReading(
        mass=float(masses.sum()),
        com=_centre(masses, data.xipos[1:]),
        eigenvalues=np.linalg.eigvalsh(full) if model.nv else np.zeros(0),
    )


def read_by_pinocchio(robot: Robot, *, repaired: bool = False) -> EngineReading:
    """Return what Pinocchio reads in the robot's own file, or in what MuJoCo is given.

    Raises:
        RobotError: It cannot read that.
    """
    import pinocchio

    from morph.body.twin import twin_of, twin_of_source

    model = twin_of(robot) if repaired else twin_of_source(robot)
    data = model.createData()
    home = pinocchio.neutral(model)
    floats = any(joint.kind == "free" for joint in robot.joints)
    for joint, place, parent in zip(
        model.joints, model.jointPlacements, model.parents, strict=True
    ):
        # A root that floats is put where MuJoCo's does; one further down keeps its place.
        if floats and joint.shortname() == "JointModelFreeFlyer" and parent == 0:
            home[joint.idx_q : joint.idx_q + 7] = pinocchio.SE3ToXYZQUAT(place.inverse())
    pinocchio.forwardKinematics(model, data, home)
    masses = np.array([inertia.mass for inertia in model.inertias])
    centres = [data.oMi[k].act(model.inertias[k].lever) for k in range(model.njoints)]
    upper = np.triu(pinocchio.crba(model, data, home)) if model.nv else np.zeros((0, 0))
    full = upper + np.triu(upper, 1).T - np.diag(model.armature)
    return EngineReading(
        mass=float(masses.sum()),
        com=_centre(masses, np.array(centres)),
        eigenvalues=np.linalg.eigvalsh(full) if model.nv else np.zeros(0),
    )


def _centre(masses: Any, centres: Array) -> Array:
    total = float(np.sum(masses))
    centre: Array = masses @ centres / total if total > 0 else np.zeros(3)
    return centre
