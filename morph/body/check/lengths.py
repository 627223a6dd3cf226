"""Whether a link stands, or has its mass, a thousand times too far away."""

from __future__ import annotations

import numpy as np

from morph.body.check.place import at_joint, at_link
from morph.body.draft import Draft
from morph.body.finding import DescriptionFinding
from morph.body.solids import bounds, diagonal

FAR_TOO_FAR = 60.0
"""How many times further than its robot's parts are wide an offset in millimetres is."""

FARTHEST = 2.0
"""Offset that no part has by mistake, m: below it nothing is told."""


def check_lengths(draft: Draft) -> list[DescriptionFinding]:
    """Return the joints and centres of mass that stand as far away as millimetres would."""
    offsets = [float(np.linalg.norm(joint.pose.position)) for joint in draft.joints]
    sizes = [length for length in offsets if length > 1e-3]
    for link in draft.links:
        box = bounds(link.shapes)
        if box is not None and diagonal(box) > 0:
            sizes.append(diagonal(box))
    if len(sizes) < 3:
        return []
    typical = float(np.median(sizes))
    least = max(FARTHEST, FAR_TOO_FAR * typical)
    findings = []
    for joint, offset in zip(draft.joints, offsets, strict=True):
        if offset > least:
            findings.append(
                DescriptionFinding(
                    code="length-units",
                    severity="info",
                    where=at_joint(draft, joint),
                    what=f"it stands {offset:.3g} m from its parent, in a robot of parts "
                    f"of {typical:.2g} m",
                    fix="write its <origin> in metres, not in millimetres",
                )
            )
    for link in draft.links:
        offset = float(np.linalg.norm(link.com))
        if (link.mass or 0.0) > 0 and offset > least:
            findings.append(
                DescriptionFinding(
                    code="length-units",
                    severity="info",
                    where=at_link(draft, link),
                    what=f"its centre of mass lies {offset:.3g} m from it, in a robot of parts "
                    f"of {typical:.2g} m",
                    fix="write the <origin> of its inertia in metres, not in millimetres",
                )
            )
    return findings
