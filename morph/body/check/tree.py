"""Whether links and joints make one tree."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

from morph.body.check.place import WORLD, at_joint, at_link
from morph.body.draft import Draft, DraftJoint, DraftLink
from morph.body.finding import DescriptionFinding

DEEPEST = 150
"""Longest chain of links; MuJoCo's reader and ours nest no deeper than some 200 elements."""


def check_tree(draft: Draft) -> tuple[Draft, list[DescriptionFinding]]:
    """Return the draft as one tree, or findings that refuse it.

    Joints that share a name get names of their own. Links that share a name, a
    joint without its links, a circle and several bases have no safe repair.
    """
    draft, findings = _joint_names(draft)
    draft, result = _world(draft)
    findings += result
    # Each of these misleads the ones after it.
    refusals: list[DescriptionFinding] = []
    for look in (_link_names, _dangling, _circles, _bases, _depth):
        refusals = refusals or look(draft)
    return draft, [*findings, *refusals]


def _joint_names(draft: Draft) -> tuple[Draft, list[DescriptionFinding]]:
    seen: Counter[str] = Counter()
    taken = {joint.name for joint in draft.joints}
    joints, findings = [], []
    for joint in draft.joints:
        seen[joint.name] += 1
        if seen[joint.name] > 1:
            number = seen[joint.name]
            while f"{joint.name}_{number}" in taken:
                number += 1
            name = f"{joint.name}_{number}"
            taken.add(name)
            findings.append(
                DescriptionFinding(
                    code="duplicate-name",
                    severity="repaired",
                    where=at_joint(draft, joint),
                    what=f"it is the joint number {seen[joint.name]} of this name",
                    done=f"it was called {name!r}",
                    fix="give each joint a name of its own",
                )
            )
            joint = replace(joint, name=name)
        joints.append(joint)
    return replace(draft, joints=tuple(joints)), findings


def _link_names(draft: Draft) -> list[DescriptionFinding]:
    seen: set[str] = set()
    findings = []
    for link in draft.links:
        if link.name in seen:
            findings.append(
                DescriptionFinding(
                    code="duplicate-name",
                    severity="refused",
                    where=at_link(draft, link),
                    what="it is the second link of this name, so joints may mean either",
                    fix="give each link a name of its own",
                )
            )
        seen.add(link.name)
    return findings


def _world(draft: Draft) -> tuple[Draft, list[DescriptionFinding]]:
    """Return the draft with the link `world`, if joints hang from it and it is not there."""
    world = next((link for link in draft.links if link.name == WORLD), None)
    if world is not None:
        moved = any(joint.child == WORLD for joint in draft.joints)
        return _renamed(draft, world) if moved or world.mass else (draft, [])
    hanging = [joint for joint in draft.joints if joint.parent == WORLD]
    findings = [
        DescriptionFinding(
            code="dangling-joint",
            severity="repaired",
            where=at_joint(draft, joint),
            what=f"its parent {WORLD!r} is no link of the description",
            done="it was tied to the world",
            fix=f'add <link name="{WORLD}"/>',
        )
        for joint in hanging
    ]
    if hanging:
        draft = replace(draft, links=(DraftLink(name=WORLD), *draft.links))
    return draft, findings


def _renamed(draft: Draft, world: DraftLink) -> tuple[Draft, list[DescriptionFinding]]:
    """Return the draft with another name for a link `world` that is not the world."""
    taken, number = {link.name for link in draft.links}, 2
    while f"{WORLD}_{number}" in taken:
        number += 1
    name = f"{WORLD}_{number}"
    finding = DescriptionFinding(
        code="duplicate-name",
        severity="repaired",
        where=at_link(draft, world),
        what=f"{WORLD!r} is what does not move and weighs nothing, and this link moves or weighs",
        done=f"it was called {name!r}",
        fix="give the link another name",
    )
    links = tuple(replace(link, name=name) if link is world else link for link in draft.links)
    joints = tuple(
        replace(
            joint,
            parent=name if joint.parent == WORLD else joint.parent,
            child=name if joint.child == WORLD else joint.child,
        )
        for joint in draft.joints
    )
    return replace(draft, links=links, joints=joints), [finding]


def _dangling(draft: Draft) -> list[DescriptionFinding]:
    known = {link.name for link in draft.links}
    findings = []
    for joint in draft.joints:
        for end, name in (("parent", joint.parent), ("child", joint.child)):
            if name not in known:
                what = f"its {end} {name!r} is no link" if name else f"it names no {end}"
                findings.append(
                    DescriptionFinding(
                        code="dangling-joint",
                        severity="refused",
                        where=at_joint(draft, joint),
                        what=what,
                        fix=f"name a link that is there as its {end}, or remove the joint",
                    )
                )
    return findings


def _circles(draft: Draft) -> list[DescriptionFinding]:
    findings = []
    above: dict[str, DraftJoint] = {}
    for joint in draft.joints:
        if joint.child in above and joint.child:
            other = above[joint.child]
            findings.append(_circle(draft, joint, f"{joint.child!r} hangs from {other.name!r} too"))
        else:
            above[joint.child] = joint
    state: dict[str, bool] = {}
    for link in draft.links:
        walk = []
        name = link.name
        while name in above and name not in state:
            state[name] = False
            walk.append(name)
            name = above[name].parent
        if state.get(name) is False:
            loop = " -> ".join([*reversed(walk[walk.index(name) :]), name])
            findings.append(_circle(draft, above[name], f"links hang in a circle: {loop[:300]}"))
        for name in walk:
            state[name] = True
    return findings


def _circle(draft: Draft, joint: DraftJoint, what: str) -> DescriptionFinding:
    return DescriptionFinding(
        code="cyclic-tree",
        severity="refused",
        where=at_joint(draft, joint),
        what=what,
        fix="cut the circle at one joint; close it by a [[closure]] in card.toml",
    )


def _bases(draft: Draft) -> list[DescriptionFinding]:
    roots = draft.roots()
    if len(roots) == 1:
        return []
    poses = dict.fromkeys(roots, 0)
    above = draft.joint_above()
    for link in draft.links:
        name = link.name
        while name in above:
            name = above[name].parent
        poses[name] += 1
    main = max(poses, key=lambda root: poses[root])
    return [
        DescriptionFinding(
            code="lost-base",
            severity="refused",
            where=at_link(draft, draft.link(root)),
            what=f"no joint ties it to {main!r}; it is the base of {poses[root]} links of its own",
            fix=f"join it to {main!r} or to a link below, or describe it in a file of its own",
        )
        for root in roots
        if root != main
    ]


def _depth(draft: Draft) -> list[DescriptionFinding]:
    depth = dict.fromkeys(draft.roots(), 1)
    above = draft.joint_above()
    for link in draft.links:
        walk, name = [], link.name
        while name not in depth:
            walk.append(name)
            name = above[name].parent
        for each in reversed(walk):
            depth[each] = depth[above[each].parent] + 1
    deepest = max(depth, key=lambda name: depth[name])
    if depth[deepest] <= DEEPEST:
        return []
    return [
        DescriptionFinding(
            code="unsupported",
            severity="refused",
            where=at_link(draft, draft.link(deepest)),
            what=f"it hangs {depth[deepest]} links deep; {DEEPEST} are allowed",
            fix="describe a rope or a cable by fewer links",
        )
    ]
