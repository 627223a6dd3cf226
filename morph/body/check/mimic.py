"""Whether joints that follow another follow one that is there."""

from __future__ import annotations

from dataclasses import replace

from morph.body.check.place import at_joint
from morph.body.draft import Draft, DraftJoint, DraftMimic
from morph.body.finding import DescriptionFinding

FOLLOWING = ("revolute", "continuous", "prismatic")
"""Kinds of joints that can follow and be followed."""


def check_mimic(draft: Draft) -> tuple[Draft, list[DescriptionFinding]]:
    """Return the draft without followers that follow nothing, and what was wrong."""
    known = {joint.name: joint for joint in draft.joints}
    changed: dict[str, DraftJoint] = {}
    findings = []
    for joint in draft.joints:
        if joint.mimic is None:
            continue
        wrong = _wrong(joint, joint.mimic, known)
        if wrong:
            changed[joint.name] = replace(joint, mimic=None)
            still = joint.kind == "fixed"
            findings.append(
                DescriptionFinding(
                    code="mimic",
                    severity="info" if still else "repaired",
                    where=at_joint(draft, joint),
                    what=wrong,
                    done="it stays fixed" if still else "it moves by itself",
                    fix="name, in <mimic>, a joint that moves by itself",
                )
            )
    return draft.with_joints(changed), findings


def _wrong(joint: DraftJoint, mimic: DraftMimic, known: dict[str, DraftJoint]) -> str:
    if joint.kind not in FOLLOWING:
        return f"it is {joint.kind} and is to follow {mimic.joint!r}"
    followed = mimic.joint
    for _ in range(len(known) + 1):
        if followed == joint.name:
            return "it follows itself"
        if followed not in known or known[followed].kind not in FOLLOWING:
            return f"it follows {followed!r}, which does not move or is not there"
        further = known[followed].mimic
        if further is None:
            return ""
        followed = further.joint
    return "it follows itself"
