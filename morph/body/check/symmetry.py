"""Whether left and right twins mirror each other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.body.check.place import at_joint, at_link
from morph.body.check.sides import normal_between, slide, turn, twins
from morph.body.draft import Draft, DraftJoint
from morph.body.finding import DescriptionFinding

PARALLEL = 0.9
"""Cosine above which two axes are taken for parallel."""

SIDEWAYS, SAME = 0.05, 0.03
"""Part of an offset that leads sideways and so tells sides apart; and what counts as equal."""

EQUAL = 0.05
"""Difference of two limits, as a part of the range, that counts as none."""

UNEQUAL = 1.5
"""Ratio of twins' masses, or of their principal moments, that is told."""


@dataclass(frozen=True, kw_only=True)
class Pair:
    """A joint and its twin, at home in the world."""

    left: DraftJoint
    right: DraftJoint
    offsets: tuple[Array, Array]
    """From their parents' origins, in the world's axes, m."""
    axes: tuple[Array, Array]
    """Their axes."""


def check_symmetry(draft: Draft) -> list[DescriptionFinding]:
    """Return the joints and links that break the mirror symmetry the others have."""
    pairs = _pairs(draft)
    findings = _coincident(draft, pairs)
    if pairs:
        normal = normal_between(
            np.array([pair.offsets[0] for pair in pairs]),
            np.array([pair.offsets[1] for pair in pairs]),
        )
        if normal is not None:
            named = {finding.where.name for finding in findings}
            findings += [f for f in _copies(draft, pairs, normal) if f.where.name not in named]
            findings += _turns(draft, pairs, normal)
    return findings + _masses(draft)


def _pairs(draft: Draft) -> list[Pair]:
    home = draft.home()
    joints = {joint.name: joint for joint in draft.joints}
    links = dict(twins(link.name for link in draft.links))
    sided = {*links, *links.values()}
    pairs = []
    for one, other in twins(joints):
        left, right = joints[one], joints[other]
        if left.kind != right.kind or links.get(left.parent, left.parent) != right.parent:
            continue
        # The fingers of a left hand mirror each other at another plane.
        if left.parent == right.parent and left.parent in sided:
            continue
        poses = home[left.child], home[right.child]
        pairs.append(
            Pair(
                left=left,
                right=right,
                offsets=(
                    home[left.parent].rotation @ left.pose.position,
                    home[right.parent].rotation @ right.pose.position,
                ),
                axes=(poses[0].rotation @ left.axis, poses[1].rotation @ right.axis),
            )
        )
    return pairs


def _coincident(draft: Draft, pairs: list[Pair]) -> list[DescriptionFinding]:
    """Return twins of one parent that stand in one place, off the middle."""
    findings = []
    for pair in pairs:
        offset = pair.left.pose.position
        apart = float(np.linalg.norm(pair.offsets[0] - pair.offsets[1]))
        if pair.left.parent != pair.right.parent or apart > 1e-4:
            continue
        # ROS, REP 103: y points to the left.
        side = float(offset[1])
        if abs(side) < 1e-2 * max(float(np.linalg.norm(offset)), 1e-6):
            continue
        wrong = pair.left if side < 0 else pair.right
        twin = pair.right if side < 0 else pair.left
        findings.append(_mirrored(draft, wrong, twin, "stands in one place with it"))
    return findings


def _mirrored(draft: Draft, joint: DraftJoint, twin: DraftJoint, how: str) -> DescriptionFinding:
    return DescriptionFinding(
        code="limb-mirrored",
        severity="info",
        where=at_joint(draft, joint),
        what=f"its twin is {twin.name!r}, and it {how}",
        fix="check the sign of its <origin> across the robot",
    )


def _copies(draft: Draft, pairs: list[Pair], normal: Array) -> list[DescriptionFinding]:
    """Return the joints that copy their twin's offset where the others mirror it."""
    mirrored, copied = 0, []
    limbs = _limbs(draft)
    for pair in pairs:
        if pair.left.child not in limbs:
            continue
        left, right = pair.offsets
        size = float(np.linalg.norm(right))
        if abs(right @ normal) < max(SIDEWAYS * size, 1e-3):
            continue
        if np.linalg.norm(left - slide(normal, right)) < SAME * size:
            mirrored += 1
        elif np.linalg.norm(left - right) < SAME * size:
            copied.append(pair)
    if 2 * len(copied) > mirrored:
        return []
    findings = []
    for pair in copied:
        # The normal points from right to left, so the one that steps back is wrong
        # where the pair starts; further down, the one unlike what hangs above it.
        swap = float(pair.offsets[0] @ normal) > 0
        wrong, twin = (pair.right, pair.left) if swap else (pair.left, pair.right)
        how = "steps to the same side, where the others mirror each other"
        findings.append(_mirrored(draft, wrong, twin, how))
    return findings


def _limbs(draft: Draft) -> set[str]:
    """Return the links that a joint moves, or that carry one: not mounts of sensors."""
    above = draft.joint_above()
    limbs: set[str] = set()
    for joint in draft.joints:
        name = joint.child if joint.kind != "fixed" else ""
        while name in above and name not in limbs:
            limbs.add(name)
            name = above[name].parent
    return limbs


def _turns(draft: Draft, pairs: list[Pair], normal: Array) -> list[DescriptionFinding]:
    findings = []
    groups: dict[tuple[bool, bool], list[tuple[Pair, int]]] = {}
    for pair in pairs:
        if pair.left.kind not in ("revolute", "continuous", "prismatic") or _is_copy(pair):
            continue
        slides = pair.left.kind == "prismatic"
        image = (slide if slides else turn)(normal, pair.axes[1])
        same = float(image @ pair.axes[0])
        if abs(same) <= PARALLEL:
            continue
        sign = 1 if same > 0 else -1
        meant = _by_limits(pair)
        if meant == -sign:
            findings.append(_flipped(draft, pair, pairs, "but their ranges say the other"))
        # Axes that the ranges bear out break no convention.
        elif meant == 0:
            across = abs(float(pair.axes[0] @ normal)) > 0.7
            groups.setdefault((slides, across), []).append((pair, sign))
    for (slides, across), group in groups.items():
        for pair in _odd(group, pitch=across and not slides):
            findings.append(_flipped(draft, pair, pairs, "unlike the other left and right joints"))
    return findings


def _is_copy(pair: Pair) -> bool:
    """Return whether both are one joint described twice, as of two arms of one maker."""
    left, right = pair.left, pair.right
    return bool(
        (left.lower, left.upper) == (right.lower, right.upper)
        and np.allclose(left.axis, right.axis, atol=1e-6)
        and np.allclose(left.pose.position, right.pose.position, atol=1e-6)
        and np.allclose(left.pose.rotation, right.pose.rotation, atol=1e-6)
    )


def _by_limits(pair: Pair) -> int:
    """Return 1 if the ranges say that equal positions mirror each other, -1 if opposite ones do.

    0 if they do not say: there are none, both fit, or neither.
    """
    ranges = [(joint.lower, joint.upper) for joint in (pair.left, pair.right)]
    if None in ranges[0] or None in ranges[1] or pair.left.kind == "continuous":
        return 0
    (low, high), other = np.array(ranges, dtype=float)
    width = max(high - low, 1e-9)
    equal = np.abs(other - (low, high)).max() < EQUAL * width
    opposite = np.abs(other - (-high, -low)).max() < EQUAL * width
    return int(equal) - int(opposite)


def _odd(group: list[tuple[Pair, int]], *, pitch: bool) -> list[Pair]:
    """Return the pairs that break a convention: three keep it for each that does not.

    Where only one other joint keeps it, pitch joints of twins are expected to turn
    the same way.
    """
    total = sum(sign for _, sign in group)
    odd = [pair for pair, sign in group if sign * total < 0]
    if len(group) == 2 and total == 0 and pitch:
        return [pair for pair, sign in group if sign < 0]
    return odd if len(group) >= 3 and 3 * len(odd) <= len(group) - len(odd) + 1 else []


def _flipped(draft: Draft, pair: Pair, pairs: list[Pair], why: str) -> DescriptionFinding:
    wrong, twin = (pair.left, pair.right)
    if _lonely(pair, pairs, 1) > _lonely(pair, pairs, 0):
        wrong, twin = twin, wrong
    return DescriptionFinding(
        code="axis-flipped",
        severity="info",
        where=at_joint(draft, wrong),
        what=f"its axis and that of {twin.name!r} are turned one way, {why}",
        fix="turn the axis of one of the two over, or its motor's sign and range",
    )


def _lonely(pair: Pair, pairs: list[Pair], side: int) -> float:
    """Return by how much the other parallel joints of a side point the other way."""
    others = [p.axes[side] @ pair.axes[side] for p in pairs if p is not pair]
    return -float(sum(np.sign(dot) for dot in others if abs(dot) > PARALLEL))


def _masses(draft: Draft) -> list[DescriptionFinding]:
    links = {link.name: link for link in draft.links}
    findings = []
    for one, other in twins(links):
        left, right = links[one], links[other]
        if left.inertia_from != "description" or right.inertia_from != "description":
            continue
        if left.inertia is None or right.inertia is None:
            continue
        if not left.mass or not right.mass or min(left.mass, right.mass) < 0:
            continue
        moments = np.linalg.eigvalsh(left.inertia), np.linalg.eigvalsh(right.inertia)
        if moments[0][0] <= 0 or moments[1][0] <= 0:
            continue
        with np.errstate(over="ignore"):
            ratios = np.append(moments[0], left.mass) / np.append(moments[1], right.mass)
            worst = float(np.exp(np.abs(np.log(ratios)).max()))
        if worst > UNEQUAL:
            findings.append(
                DescriptionFinding(
                    code="mass-asymmetric",
                    severity="info",
                    where=at_link(draft, left),
                    what=f"its mass or inertia differs {worst:.3g} times from that of {other!r}: "
                    f"{left.mass:.4g} and {right.mass:.4g} kg",
                    fix="check which of the two is right",
                )
            )
    return findings
