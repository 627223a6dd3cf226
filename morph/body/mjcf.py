"""Reading MJCF: files resolved inside its folder, parts mended that MuJoCo would refuse."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from morph.body.card import Card
from morph.body.check import LOOKS
from morph.body.check.collision import overlaps, self_collisions
from morph.body.check.meshes import check_meshes
from morph.body.finding import DescriptionFinding
from morph.body.inertia import is_physical, mended
from morph.body.measured import marked, weigh
from morph.body.mjcf_draft import ElementLines, draft_of
from morph.body.mjcf_files import gather
from morph.body.normal import refused, robot_of
from morph.body.paths import Files
from morph.body.quiet import quiet
from morph.body.refusal import about_file, refusal
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.body.within_limits import within_limits
from morph.body.xml import Element
from morph.errors import RobotError

ROUNDED = 1e-6
"""Farthest that a keyframe may be from a range that is written with as many digits, rad or m."""


def robot_from_mjcf(tree: Element, path: Path, files: Files, card: Card | None) -> Robot:
    """Return the robot that an MJCF file describes, with everything found in it.

    Raises:
        DescriptionRefused: It holds something that no description may, or that
            cannot be simulated.
    """
    lines = ElementLines(tree, path)
    if card and card.closure:
        raise RobotError(
            "its card closes chains, which an MJCF does itself",
            where=str(path.parent / "card.toml"),
            fix="write a <connect> into <equality>, and remove [[closure]]",
        )
    tree, assets, findings = gather(tree, path, files, lines)
    try:
        text = ElementTree.tostring(tree, encoding="unicode")
        with quiet():
            spec = mujoco.MjSpec.from_string(text, assets=assets)
        findings += _mend(spec, lines)
        if len(spec.bodies) < 2:
            fix = "describe at least one <body> in <worldbody>"
            raise RobotError("holds no body", where=str(path), fix=fix)
        robot = robot_of(spec, path, card, assets)
        if card and card.measured:
            weigh(spec, card, str(path.parent / "card.toml"))
            robot = marked(robot_of(spec, path, card, assets))
        with quiet():
            model = spec_of(robot).compile()
    # What MuJoCo throws in its readers arrives as a RuntimeError without words.
    except (ValueError, RuntimeError, MemoryError, RobotError) as error:
        failure = error if isinstance(error, RobotError) else refused(error, path)
        code = "duplicate-name" if "repeated name" in str(failure) else "engine-refused"
        raise refusal([*findings, about_file(failure, path, code=code)]) from error
    draft = draft_of(robot, model, path, lines)
    looked = check_meshes(draft)[1]
    for look in LOOKS:
        looked += look(draft)
    with quiet():
        looked += self_collisions(draft, overlaps(model))
    findings += [_unchanged(finding) for finding in looked]
    findings += [] if robot.loops else _beyond(model, lines)
    return replace(robot, findings=(*findings, *robot.findings))


def _unchanged(finding: DescriptionFinding) -> DescriptionFinding:
    # MJCF says itself what touches what and how large meshes are: it is only told.
    if finding.severity == "info":
        return finding
    return replace(finding, severity="info", done="nothing")


def _beyond(model: Any, lines: ElementLines) -> list[DescriptionFinding]:
    """Return which joints keyframes put beyond their ranges."""
    findings = []
    for at, pose in enumerate(model.key_qpos):
        off = np.abs(within_limits(model, pose) - pose)
        for joint in np.flatnonzero(off[model.jnt_qposadr] > ROUNDED):
            name, (low, high) = model.joint(joint).name, model.jnt_range[joint]
            findings.append(
                DescriptionFinding(
                    code="keyframe-range",
                    severity="info",
                    where=lines.place("joint", name),
                    what=f"keyframe {model.key(at).name or at + 1} puts it at "
                    f"{pose[model.jnt_qposadr[joint]]:.4g}, and its range is "
                    f"{low:.4g} to {high:.4g}",
                    done="simulations and tasks start it at the end of its range",
                    fix="correct the keyframe, or the range",
                )
            )
    return findings


def _mend(spec: Any, lines: ElementLines) -> list[DescriptionFinding]:
    """Mend inertias that no body has; return what was found."""
    findings = []
    for body in spec.bodies[1:]:
        if not body.explicitinertial or spec.compiler.balanceinertia:
            continue
        given = _inertia(body)
        if given is None or not np.any(given) or is_physical(given):
            continue
        nearest = mended(given)
        severity = "refused" if nearest is None else "repaired"
        moments = ", ".join(f"{value:.4g}" for value in np.linalg.eigvalsh(given))
        findings.append(
            DescriptionFinding(
                code="inertia-broken",
                severity="refused" if nearest is None else "repaired",
                where=lines.place("body", body.name),
                what=f"no body has the principal moments {moments} kg m2",
                done="nothing" if severity == "refused" else "the nearest possible was taken",
                fix="recompute it in CAD; the sum of any two principal moments exceeds the third",
            )
        )
        if nearest is not None:
            body.fullinertia = nearest[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
            body.inertia = np.zeros(3)
            body.iquat = (1.0, 0.0, 0.0, 0.0)
            body.ialt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT
    return findings


def _inertia(body: Any) -> Any:
    full = np.array(body.fullinertia)
    if np.isfinite(full[0]):
        xx, yy, zz, xy, xz, yz = full
        return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    # A turned frame turns the axes and leaves the principal moments: enough to tell.
    if body.ialt.type != mujoco.mjtOrientation.mjORIENTATION_QUAT:
        return None
    turn = np.zeros(9)
    quat = np.array(body.iquat, dtype=float)
    mujoco.mju_normalize4(quat)
    mujoco.mju_quat2Mat(turn, quat)
    axes = turn.reshape(3, 3)
    return axes @ np.diag(body.inertia) @ axes.T
