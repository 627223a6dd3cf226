"""Whether meshes and other shapes are of the right size, closed, and where their links are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from morph.arrays import Array
from morph.body.check.place import at_link
from morph.body.draft import Draft, DraftLink, Shape
from morph.body.finding import DescriptionFinding, Severity
from morph.body.solids import away, bounds, diagonal

THOUSAND = 1000.0
"""Millimetres in a metre: the only mistake of units that is mended."""

FAR_TOO_LARGE = 60.0
"""How many times larger than its robot's parts a mesh in the wrong unit is, at least."""

AWAY = 0.4
"""Distance between a mesh and its link's mass, in diagonals of the link's shapes."""

CONCAVE = 1.5
"""Ratio of a hull's volume to its mesh's that is told."""

FROM_MESH = ("mesh x density", "measured")
"""Inertias of an assembly's links, which come from their one mesh; URDF's are its own."""

LEAST = 0.005
"""Distance below which nothing is away, m."""


def check_meshes(draft: Draft) -> tuple[Draft, list[DescriptionFinding]]:
    """Return the draft with meshes in metres, and what is wrong with shapes."""
    draft, findings = _units(draft)
    for link in draft.links:
        for shape in link.shapes:
            findings.extend(_sizes(draft, link, shape))
        findings.extend(_surfaces(draft, link))
        findings.extend(_concave(draft, link))
        findings.extend(_moved(draft, link))
    return draft, findings


def _say(
    draft: Draft,
    link: DraftLink,
    shape: Shape,
    code: str,
    severity: Severity,
    what: str,
    done: str,
    fix: str,
) -> DescriptionFinding:
    where = at_link(draft, link, shape.line)
    return DescriptionFinding(
        code=code, severity=severity, where=where, what=what, done=done, fix=fix
    )


def _sizes(draft: Draft, link: DraftLink, shape: Shape) -> list[DescriptionFinding]:
    if shape.kind == "mesh":
        if 0.0 not in shape.scale:
            return []
        what = f"the scale of {shape.file!r} is {' '.join(f'{s:g}' for s in shape.scale)}"
    else:
        if min(shape.size) > 0:
            return []
        what = f"a {shape.kind} has the size {' '.join(f'{s:g}' for s in shape.size)}"
    fix = "give it a size in metres, or remove it"
    return [_say(draft, link, shape, "shape-size", "repaired", what, "it was left out", fix)]


def _surfaces(draft: Draft, link: DraftLink) -> list[DescriptionFinding]:
    findings = []
    seen = set()
    for shape in link.shapes:
        mesh = shape.mesh
        if mesh is None or id(mesh) in seen:
            continue
        seen.add(id(mesh))
        if mesh.watertight and mesh.volume < 0 and not mesh.hollow:
            findings.append(
                _say(
                    draft,
                    link,
                    shape,
                    "mesh-inside-out",
                    "info",
                    f"the faces of {shape.file!r} look inward: its volume is {mesh.volume:.3g}",
                    "it was taken as it is meant, as no mass comes from it",
                    "turn its faces over: flip normals in a mesh editor",
                )
            )
        elif not mesh.watertight:
            findings.append(
                _say(
                    draft,
                    link,
                    shape,
                    "mesh-open",
                    "info",
                    f"{shape.file!r} is not closed, so that its volume is a guess",
                    "where a volume is due its convex hull is taken",
                    "close its holes in a mesh editor",
                )
            )
    return findings


def _concave(draft: Draft, link: DraftLink) -> list[DescriptionFinding]:
    findings = []
    for shape in link.shapes:
        mesh = shape.mesh
        if shape.role != "collision" or mesh is None or not mesh.consistent or mesh.hollow:
            continue
        ratio = mesh.hull.volume / abs(mesh.volume)
        if ratio > CONCAVE:
            findings.append(
                _say(
                    draft,
                    link,
                    shape,
                    "mesh-concave",
                    "info",
                    f"the hull of {shape.file!r} has {ratio:.3g} times its volume",
                    "it touches as its hull",
                    "morph convert --pieces cuts it into convex pieces",
                )
            )
    return findings


def _units(draft: Draft) -> tuple[Draft, list[DescriptionFinding]]:
    sizes = {
        (link.name, index): diagonal(box)
        for link in draft.links
        for index, shape in enumerate(link.shapes)
        if shape.mesh is not None and (box := bounds([shape])) is not None and diagonal(box) > 0
    }
    findings, changed = [], {}
    for link in draft.links:
        shapes = list(link.shapes)
        for index, shape in enumerate(shapes):
            size = sizes.get((link.name, index))
            if size is None:
                continue
            factor = _factor(size, _typical(draft, link.name, index, sizes))
            if factor == 1.0:
                continue
            x, y, z = shape.scale
            shapes[index] = replace(shape, scale=(x * factor, y * factor, z * factor))
            what = f"{shape.file!r} is {size:.3g} m across, in a robot of parts "
            what += f"of {_typical(draft, link.name, index, sizes):.2g} m"
            findings.append(
                _say(
                    draft,
                    link,
                    shape,
                    "mesh-units",
                    "repaired",
                    what,
                    f"it was scaled by {factor:g}",
                    f'write scale="{" ".join(f"{s:g}" for s in shapes[index].scale)}"',
                )
            )
        mended = replace(link, shapes=tuple(shapes))
        # Only an assembly takes the form of its inertia from its mesh.
        assembled = draft.file.suffix.lower() == ".toml"
        changed[link.name] = _weighed(mended, link) if assembled else mended
    return draft.with_links(changed), findings


def _weighed(after: DraftLink, before: DraftLink) -> DraftLink:
    """Return a link whose mass came from its mesh, weighed as its mended size asks."""
    if before.inertia_from not in FROM_MESH or before.inertia is None or before.mass is None:
        return after
    if not before.shapes or not before.shapes[0].scale[0]:
        return after
    shape = before.shapes[0]
    factor = after.shapes[0].scale[0] / shape.scale[0]
    # At one density mass grows with the cube of length; what was weighed on a scale stays.
    growth = factor**3 if before.inertia_from == "mesh x density" else 1.0
    return replace(
        after,
        mass=before.mass * growth,
        com=shape.pose.position + factor * (before.com - shape.pose.position),
        inertia=before.inertia * growth * factor**2,
    )


def _factor(size: float, typical: float | None) -> float:
    """Return by how much to scale a mesh; 1 unless a thousand makes it fit."""
    if typical is None:
        return 1.0
    if size > FAR_TOO_LARGE * typical and size > 3.0:
        return 1 / THOUSAND
    if size < typical / FAR_TOO_LARGE and size < 1e-3:
        return THOUSAND
    return 1.0


def _typical(
    draft: Draft, link: str, index: int, sizes: dict[tuple[str, int], float]
) -> float | None:
    """Return the size of the other parts: of the joints' offsets if there are any, else of meshes.

    Offsets state no unit of their own, so one mesh, or all, can be held against them.
    """
    offsets = [float(np.linalg.norm(joint.pose.position)) for joint in draft.joints]
    offsets = [length for length in offsets if length > 1e-3]
    others = [size for key, size in sizes.items() if key != (link, index)]
    if len(offsets) >= 2:
        return float(np.median(offsets))
    if len(others) >= 3:
        return float(np.median(others))
    return None


def _moved(draft: Draft, link: DraftLink) -> list[DescriptionFinding]:
    parts = {role: [s for s in link.shapes if s.role == role] for role in ("visual", "collision")}
    boxes = {role: box for role, shapes in parts.items() if (box := bounds(shapes)) is not None}
    for role, box in boxes.items():
        # Plain collision shapes stand for any part of a link.
        if role == "collision" and any(shape.kind != "mesh" for shape in parts[role]):
            continue
        size = diagonal(box)
        if not (link.mass or 0.0) > 0 or size == 0 or link.inertia_from != "description":
            continue
        gap = away(link.com, box)
        if gap > max(AWAY * size, LEAST):
            return [_apart(draft, link, parts[role][0], role, gap, "its centre of mass")]
    if len(boxes) == 2:
        visual, collision = boxes["visual"], boxes["collision"]
        gap = _gap(visual, collision)
        if gap > max(AWAY * min(diagonal(visual), diagonal(collision)), LEAST):
            shape = parts["visual"][0]
            return [_apart(draft, link, shape, "visual", gap, "its collision shape")]
    return []


def _apart(
    draft: Draft, link: DraftLink, shape: Shape, role: str, gap: float, other: str
) -> DescriptionFinding:
    return _say(
        draft,
        link,
        shape,
        "mesh-moved",
        "info",
        f"its {role} shape lies {gap:.3g} m away from {other}",
        "nothing",
        "correct the <origin> of the shape, or that of the inertia",
    )


def _gap(one: Array, other: Array) -> float:
    apart = np.maximum(np.maximum(one[0] - other[1], other[0] - one[1]), 0.0)
    return float(np.linalg.norm(apart))
