"""Whether joints have ranges and limits that joints can have."""

from __future__ import annotations

import math
from dataclasses import replace

from morph.body.check.place import at_joint
from morph.body.draft import MOVING, Draft, DraftJoint
from morph.body.finding import DescriptionFinding, Severity
from morph.body.numbers import SMALLEST

LARGEST = {"revolute": 4 * math.pi, "prismatic": 50.0}
"""Furthest that a limit may reach: two turns, rad; 50 m."""

STRONGEST, FASTEST = 1e5, 1e3
"""Greatest effort, N m or N, and speed, rad/s or m/s, that a limit may state."""


def check_limits(draft: Draft) -> tuple[Draft, list[DescriptionFinding]]:
    """Return the draft with ranges that can be simulated, and what was wrong with them."""
    ranged = [joint for joint in draft.joints if joint.kind in LARGEST]
    # An exporter that knows no limits writes the same number twice, everywhere.
    left_out = len(ranged) > 1 and all(joint.lower == joint.upper for joint in ranged)
    findings: list[DescriptionFinding] = []
    changed = {}
    for joint in draft.joints:
        after = joint
        if joint.kind in LARGEST:
            after, result = _range(draft, joint, left_out)
            findings.extend(result)
        if joint.kind in MOVING:
            after, result = _strength(draft, after)
            findings.extend(result)
        changed[joint.name] = after
    return draft.with_joints(changed), findings


def _say(
    draft: Draft, joint: DraftJoint, code: str, severity: Severity, what: str, done: str, fix: str
) -> DescriptionFinding:
    where = at_joint(draft, joint)
    return DescriptionFinding(
        code=code, severity=severity, where=where, what=what, done=done, fix=fix
    )


def _range(
    draft: Draft, joint: DraftJoint, left_out: bool
) -> tuple[DraftJoint, list[DescriptionFinding]]:
    unit = "m" if joint.kind == "prismatic" else "rad"
    free = replace(joint, lower=None, upper=None)
    if joint.lower is None and joint.upper is None:
        return joint, []
    lower, upper = joint.lower or 0.0, joint.upper or 0.0
    shown = f"its range is {lower:g} to {upper:g} {unit}"
    if not (math.isfinite(lower) and math.isfinite(upper)):
        done = "it was taken as free to move"
        fix = "write the range, or make it continuous"
        return free, [_say(draft, joint, "limit-absurd", "repaired", shown, done, fix)]
    if abs(upper - lower) <= SMALLEST * max(1.0, abs(lower)):
        return _empty(draft, joint, lower, left_out, shown)
    findings = []
    if lower > upper:
        lower, upper = upper, lower
        done = f"it was taken as {lower:g} to {upper:g} {unit}"
        fix = "write the smaller number as lower"
        findings.append(_say(draft, joint, "limit-range", "repaired", shown, done, fix))
    if max(abs(lower), abs(upper)) > LARGEST[joint.kind]:
        degrees = joint.kind == "revolute" and max(abs(lower), abs(upper)) <= 720
        fix = "write it in radians" if degrees else "write the range that the joint has"
        what = shown + (", which looks like degrees" if degrees else "")
        findings.append(_say(draft, joint, "limit-absurd", "info", what, "nothing", fix))
    return replace(joint, lower=lower, upper=upper), findings


def _empty(
    draft: Draft, joint: DraftJoint, at: float, left_out: bool, shown: str
) -> tuple[DraftJoint, list[DescriptionFinding]]:
    if at == 0 and not left_out:
        after = replace(joint, kind="fixed", lower=None, upper=None, mimic=None)
        done, fix = "it was welded, as it cannot move", "make it a fixed joint"
    else:
        after = replace(joint, lower=None, upper=None)
        done, fix = "it was taken as free to move", "write the range, lower below upper"
    return after, [_say(draft, joint, "limit-range", "repaired", shown, done, fix)]


def _strength(draft: Draft, joint: DraftJoint) -> tuple[DraftJoint, list[DescriptionFinding]]:
    findings = []
    units = {"effort": "N" if joint.kind == "prismatic" else "N m"}
    units["velocity"] = "m/s" if joint.kind == "prismatic" else "rad/s"
    for key, largest in (("effort", STRONGEST), ("velocity", FASTEST)):
        value = joint.effort if key == "effort" else joint.velocity
        if value is None:
            continue
        shown = f"its {key} limit is {value:g} {units[key]}"
        if value == 0:
            done, fix = "it was taken as not given", f"write its {key} limit, or leave it out"
            findings.append(_say(draft, joint, "limit-zero", "info", shown, done, fix))
        elif not 0 < value <= largest:
            done, fix = "it was taken as not given", f"write the {key} limit that the motor has"
            findings.append(_say(draft, joint, "limit-absurd", "info", shown, done, fix))
        if not 0 < value <= largest:
            joint = (
                replace(joint, effort=None) if key == "effort" else replace(joint, velocity=None)
            )
    for key, value in (("damping", joint.damping), ("friction", joint.friction)):
        if value < 0:
            shown, done = f"its {key} is {value:g}, which would feed it energy", "it was left out"
            fix = f"write its {key} as zero or more"
            findings.append(_say(draft, joint, "limit-absurd", "repaired", shown, done, fix))
            joint = replace(joint, damping=max(joint.damping, 0), friction=max(joint.friction, 0))
    return joint, findings
