"""Shapes of a description that no part of the printed body stands for."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from morph.body.finding import DescriptionFinding
from morph.body.robot import Robot
from morph.fabrication.names import safe
from morph.print.part import Check

LEFT_OUT = "left out"
"""How the importer says that a shape is not there."""

COARSER = "mesh-too-large"
"""Its word for a mesh that was kept with fewer faces, or not at all."""


def lost(robot: Robot, drawn: Mapping[str, Sequence[object]]) -> tuple[Check, ...]:
    """Return a check for each shape that could not be read, or not as it is.

    A link of which nothing else is drawn is refused. Of a link that draws more, it may have
    been a shape for collisions: somebody should look.

    Args:
        robot: The body, with what its importer found.
        drawn: What is drawn of each link.
    """
    lines = (_check(finding, drawn) for finding in robot.findings if _shape(finding))
    # Visual and collision shape may be one file, told twice.
    return tuple(dict.fromkeys(lines))


def lost_links(robot: Robot) -> frozenset[str]:
    """Return the links of which a shape was left out: not all that they weigh is a part."""
    return frozenset(_of(robot.findings))


def _of(findings: Iterable[DescriptionFinding]) -> Iterable[str]:
    return (each.where.name for each in findings if _shape(each) and LEFT_OUT in each.done)


def _shape(finding: DescriptionFinding) -> bool:
    of_shape = finding.code.startswith("mesh-") or finding.code == "shape-size"
    return of_shape and (LEFT_OUT in finding.done or finding.code == COARSER)


def _check(finding: DescriptionFinding, drawn: Mapping[str, Sequence[object]]) -> Check:
    gone = LEFT_OUT in finding.done
    return Check(
        part=safe(finding.where.name),
        name="readable",
        verdict="refused" if gone and not drawn.get(finding.where.name) else "noted",
        what=f"{finding.what}; {finding.done}",
        fix=finding.fix,
    )
