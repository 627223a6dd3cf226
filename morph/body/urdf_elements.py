"""Elements of a URDF that its reader leaves out, told one by one."""

from __future__ import annotations

import difflib

from morph.body.finding import DescriptionFinding, Where
from morph.body.numbers import float_or
from morph.body.xml import Element

MOST_STRANGERS, MOST_KINDS, LONGEST_TAG = 100, 1000, 40
"""Most foreign elements that are told; most kinds looked at, and the longest name of one."""

KNOWN = {
    "robot": ("link", "joint", "material", "transmission", "gazebo", "mujoco", "sensor"),
    "link": ("inertial", "visual", "collision", "self_collision_checking", "contact", "gazebo"),
    "joint": (
        *("origin", "parent", "child", "axis", "limit", "dynamics", "mimic", "calibration"),
        *("safety_controller", "gazebo", "hardwareInterface"),
    ),
    "inertial": ("origin", "mass", "inertia"),
}
"""The children that URDF gives each element; a prefix such as `drake:` marks another's."""

SINGLE = {
    "link": ("inertial",),
    "joint": ("origin", "parent", "child", "axis", "limit", "dynamics", "mimic"),
}
"""The children of which each element has one at most; the reader takes the first."""

ENDS = ("lower", "upper")
"""The ends of a joint's range."""

GEOMETRIES = ("mesh", "box", "sphere", "cylinder", "capsule")
"""The shapes that a `<geometry>` may hold."""


def strangers(tree: Element) -> list[DescriptionFinding]:
    """Return what is told of elements that are misspelt, doubled, blank or no shape."""
    result = _doubles(tree) + _shapeless(tree) + _blank_limits(tree) + _reductions(tree)
    return [*result[:MOST_STRANGERS], *_misspelt(tree)]


def _misspelt(tree: Element) -> list[DescriptionFinding]:
    results: list[DescriptionFinding] = []
    harmless: set[tuple[str, str]] = set()
    parts = list(tree.children("link", "joint"))
    inertials = [inertial for part in parts for inertial in part.children("inertial")]
    for parent in (tree, *parts, *inertials):
        allowed = KNOWN[parent.tag]
        for child in parent.children():
            kind = (parent.tag, child.tag)
            if child.tag in allowed or kind in harmless or len(child.tag) > LONGEST_TAG:
                continue
            near = difflib.get_close_matches(child.tag, allowed, n=1, cutoff=0.75)
            if near and ":" not in child.tag:
                fix = f"write <{near[0]}>, or remove it"
                results.append(_stranger(parent, child, f"no element of URDF; <{near[0]}> is", fix))
            elif child.tag.startswith("xacro:") and child.tag != "xacro:property":
                fix = "expand the file with xacro, or give the .xacro file"
                results.append(_stranger(parent, child, "a macro that was not expanded", fix))
            else:
                harmless.add(kind)
            if len(results) >= MOST_STRANGERS or len(harmless) > MOST_KINDS:
                return results
    return results


def _stranger(parent: Element, child: Element, what: str, fix: str) -> DescriptionFinding:
    kind = parent.tag if parent.tag in ("link", "joint") else "robot"
    name = parent.get("name", parent.tag)
    return DescriptionFinding(
        code="unknown-element",
        severity="info",
        where=Where(kind=kind, name=name, file=child.file, line=child.line),
        what=f"<{child.tag}> is {what}",
        done="it was left out",
        fix=fix,
    )


def _doubles(tree: Element) -> list[DescriptionFinding]:
    return [
        _left_out(
            part, second, f"it is the second <{tag}>", "the first was taken", f"keep one <{tag}>"
        )
        for part in tree.children("link", "joint")
        for tag in SINGLE[part.tag]
        for second in list(part.children(tag))[1:2]
    ]


def _shapeless(tree: Element) -> list[DescriptionFinding]:
    results = []
    for link in tree.children("link"):
        for shape in link.children("visual", "collision"):
            geometry = shape.child("geometry")
            if geometry is not None and next(geometry.children(*GEOMETRIES), None) is not None:
                continue
            other = None if geometry is None else next(geometry.children(), None)
            held = "nothing" if other is None else f"<{other.tag[:LONGEST_TAG]}>"
            what = f"a <{shape.tag}> holds {held} for a shape"
            fix = f"write one of {', '.join(f'<{tag}>' for tag in GEOMETRIES)} into its <geometry>"
            results.append(_left_out(link, shape, what, "the shape was left out", fix))
    return results


def _blank_limits(tree: Element) -> list[DescriptionFinding]:
    results = []
    for joint in tree.children("joint"):
        limit = joint.child("limit")
        if limit is None or joint.get("type") not in ("revolute", "prismatic"):
            continue
        blank = [key for key in ENDS if key in limit.attrib and not limit.get(key, "").strip()]
        if not blank:
            continue
        free = all(not limit.get(key, "").strip() for key in ENDS)
        results.append(
            DescriptionFinding(
                code="limit-range",
                severity="info",
                where=_where(joint, limit),
                what=f"{' and '.join(blank)} of its <limit> {'are' if blank[1:] else 'is'} blank",
                done="it was taken as free to move" if free else f"{blank[0]} was taken as 0",
                fix="write the range as numbers, or make it continuous",
            )
        )
    return results


def _reductions(tree: Element) -> list[DescriptionFinding]:
    """Return a finding for each transmission that reduces: URDF's limits are those of joints."""
    results = []
    for transmission in tree.children("transmission"):
        parts = list(transmission.children("joint", "actuator"))
        joint = next((part.get("name", "") for part in parts if part.tag == "joint"), "")
        for part in (transmission, *parts):
            reduction = part.child("mechanicalReduction")
            if reduction is None or float_or((reduction.text or "").strip(), 1.0) == 1.0:
                continue
            ratio = (reduction.text or "").strip()[:LONGEST_TAG]
            results.append(
                DescriptionFinding(
                    code="reduction",
                    severity="info",
                    where=Where(kind="joint", name=joint, file=reduction.file, line=reduction.line),
                    what=f"its transmission reduces by {ratio}, and efforts, limits and commands "
                    "are those of the joint, after the gear",
                    done="the reduction was left out",
                    fix="give them at the joint, as URDF has limits; of logged motor torques write "
                    f"scale = {ratio} in recording.toml",
                )
            )
    return results


def _where(part: Element, child: Element) -> Where:
    return Where(kind=part.tag, name=part.get("name", ""), file=child.file, line=child.line)


def _left_out(part: Element, child: Element, what: str, done: str, fix: str) -> DescriptionFinding:
    return DescriptionFinding(
        code="unknown-element",
        severity="repaired",
        where=_where(part, child),
        what=what,
        done=done,
        fix=fix,
    )
