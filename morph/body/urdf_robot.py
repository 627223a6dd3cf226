"""From a draft to a Robot: checked, built, and with the motors of its card."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from morph.body.build import spec_from
from morph.body.card import Card
from morph.body.check import check
from morph.body.check.collision import leave_out, self_collisions
from morph.body.check.place import WORLD, at_robot
from morph.body.draft import Draft
from morph.body.finding import DescriptionFinding
from morph.body.linkage import close_chain
from morph.body.measured import marked, weighed
from morph.body.motors import add_motors
from morph.body.normal import compiled, robot_of
from morph.body.paths import Files
from morph.body.quiet import quiet
from morph.body.refusal import refusal
from morph.body.robot import Mimic, Robot


def robot_from_draft(
    draft: Draft,
    findings: list[DescriptionFinding],
    files: Files,
    card: Card | None,
    base: str | None,
) -> Robot:
    """Return the Robot that a draft describes, with everything found on the way.

    Raises:
        DescriptionRefused: It cannot be simulated; its findings say why.
        RobotError: MuJoCo refuses it, or the card does not fit it.
    """
    draft, result = check(weighed(draft, card), files, base_moves=base in ("floating", "board"))
    findings = [*findings, *result]
    if any(finding.severity == "refused" for finding in findings):
        raise refusal(findings)
    if base is None:
        findings += _assumed(draft)
    spec, assets = spec_from(draft, base or "fixed")
    spec.assets = assets
    with quiet():
        apart = leave_out(spec, compiled(spec, draft.file))
    findings += self_collisions(draft, apart)
    add_motors(spec, card, draft)
    for closure in card.closure if card else ():
        close_chain(spec, closure, str(draft.file))
    robot = robot_of(spec, draft.file, card, assets)
    return replace(marked(_enriched(robot, draft)), findings=(*findings, *robot.findings))


def _assumed(draft: Draft) -> list[DescriptionFinding]:
    (root,) = draft.roots()
    if root == WORLD:
        return []
    return [
        DescriptionFinding(
            code="base-assumed",
            severity="info",
            where=at_robot(draft),
            what=f"nothing says whether its base {root!r} is bolted to the world or floats",
            done="it was bolted to the world, and its mass is counted",
            fix="say base = ... in card.toml, or --base fixed, floating or board",
        )
    ]


def _enriched(robot: Robot, draft: Draft) -> Robot:
    """Return a Robot with what the draft knows and MuJoCo does not hold."""
    links = {link.name: link for link in draft.links}
    joints = {joint.name: joint for joint in draft.joints}

    def joint(part: Any) -> Any:
        known = joints.get(part.name)
        if known is None:
            return part
        mimic = known.mimic and Mimic(
            joint=known.mimic.joint, ratio=known.mimic.ratio, offset=known.mimic.offset
        )
        return replace(part, velocity=known.velocity, mimic=mimic)

    return replace(
        robot,
        links=tuple(
            replace(link, inertia_from=links[link.name].inertia_from)
            if link.name in links
            else link
            for link in robot.links
        ),
        joints=tuple(joint(part) for part in robot.joints),
    )
