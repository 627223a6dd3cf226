"""What a G-code leaves on the bed: mass, centre and inertia, by type of line."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from morph.print.arrays import Array, Mask
from morph.print.gcode import ExtrusionLines
from morph.print.printer import Profile
from morph.print.weight import MM, Weight

AWAY = (
    "Skirt",
    "Skirt/Brim",
    "Brim",
    "Support material",
    "Support material interface",
    "Wipe tower",
    "Custom",
)
"""Types of lines that are taken off and thrown away, by PrusaSlicer's names."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Deposit:
    """What lies on the bed when a print is done."""

    weight: Weight
    """What stays, in the frame of the bed."""
    away: float
    """Mass of what is taken off, kg."""
    by_feature: Mapping[str, float]
    """Mass of each type of line, kg."""


def deposit(lines: ExtrusionLines, profile: Profile) -> Deposit:
    """Return what is left on the bed.

    Each line is a box of its length, width and height, of the mass of the filament that was
    pushed. The nozzle runs along the top of the line, so its middle is half a height lower.

    Args:
        lines: What was laid.
        profile: The filament's diameter and the plastic's density; the width and height of
            lines of which the G-code says nothing.
    """
    bore = profile.printer.filament_mm * MM
    mass = lines.filament * MM * (np.pi / 4.0 * bore**2) * profile.material.density
    names = lines.features
    sums = np.bincount(lines.feature, weights=mass, minlength=len(names))
    thrown = np.array([name in AWAY for name in names])
    return Deposit(
        weight=_weight(lines, mass, ~thrown[lines.feature], profile),
        away=float(sums[thrown].sum()),
        by_feature={name: float(each) for name, each in zip(names, sums, strict=True) if each > 0},
    )


def _weight(lines: ExtrusionLines, mass: Array, stays: Mask, profile: Profile) -> Weight:
    """Return the lines that stay as one body.

    With the second moments S = sum m (c c' + (l2 u u' + w2 n n' + h2 z z') / 12), where u is
    along the line, n across it and z up, the inertia is tr(S) 1 - S: boxes about a point.
    """
    along = (lines.end - lines.start)[stays] * MM
    width = np.where(np.isnan(lines.width), profile.line_mm, lines.width)[stays] * MM
    height = np.where(np.isnan(lines.height), profile.layer_mm, lines.height)[stays] * MM
    middle = (lines.end + lines.start)[stays] * (MM / 2.0)
    middle[:, 2] -= height / 2.0
    mass = mass[stays]
    total = float(mass.sum())
    if total == 0.0:
        return Weight(mass=0.0, com=np.zeros(3), inertia=np.zeros((3, 3)))
    com = mass @ middle / total
    away = middle - com
    level = np.hypot(along[:, 0], along[:, 1])
    across = np.column_stack([-along[:, 1], along[:, 0]]) / np.maximum(level, 1e-12)[:, None]
    moments: Array = (away.T * mass) @ away + (along.T * (mass / 12.0)) @ along
    moments[:2, :2] += (across.T * (mass * width**2 / 12.0)) @ across
    moments[2, 2] += float(mass @ height**2) / 12.0
    return Weight(mass=total, com=com, inertia=np.trace(moments) * np.eye(3) - moments)
