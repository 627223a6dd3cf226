"""`morph inspect`: what a robot is, and what is wrong with its description."""

from __future__ import annotations

import json
import sys
from collections import defaultdict
from typing import TYPE_CHECKING, Any

from morph.app.cli.arguments import Inspect

if TYPE_CHECKING:
    from rich.console import Console

    from morph.body.finding import Finding
    from morph.body.inspect import Inspection
    from morph.body.robot import Robot

OK, UNUSABLE = 0, 2

PLACES = 8
"""Places of one code that are named before the rest is counted."""


def run_inspect(asked: Inspect) -> int:
    """Print what was found and return the exit status."""
    from morph.body.inspect import inspect_robot

    found = inspect_robot(asked.robot, base=asked.base, folder=asked.folder)
    if asked.json:
        sys.stdout.write(json.dumps(found.as_json(), indent=2, allow_nan=False) + "\n")
    else:
        _show(found)
    bad = found.verdict == "refused" or (asked.strict and found.verdict != "ok")
    return UNUSABLE if bad else OK


def _show(found: Inspection) -> None:
    from rich.console import Console

    console = Console(soft_wrap=True, highlight=False)
    if found.robot is not None:
        _show_robot(console, found, found.robot)
    for finding_group in _grouped(found.findings):
        _show_group(console, finding_group)
    console.print(_closing(found), markup=False)


def _closing(found: Inspection) -> str:
    counts = [
        f"{number} {severity}"
        for severity in ("refused", "repaired", "info")
        if (number := sum(f.severity == severity for f in found.findings))
    ]
    return f"{found.name}: {found.verdict}" + (f" ({', '.join(counts)})" if counts else "")


def _show_robot(console: Console, found: Inspection, robot: Robot) -> None:
    com = ", ".join(f"{value:.4g}" for value in found.com or ())
    console.print(
        f"{found.name}: {robot.mass:.6g} kg, {found.dof} degrees of freedom, "
        f"centre of mass at ({com}) m, reach {found.reach:.3g} m",
        markup=False,
    )
    rows = [
        (link.name, link.parent, f"{link.mass:.4g}", link.inertia_from, _tally(link.shapes))
        for link in robot.links
    ]
    _table(console, ("link", "hangs from", "kg", "inertia from", "shapes"), rows)
    limits = {actuator.joint: actuator for actuator in robot.actuators}
    rows = [
        (
            joint.name,
            joint.kind,
            joint.link,
            "free" if joint.limits is None else "{:.3g} to {:.3g}".format(*joint.limits),
            _strength(joint, limits.get(joint.name)),
            "" if joint.velocity is None else f"{joint.velocity:.3g} {joint.unit}/s",
        )
        for joint in robot.joints
    ]
    _table(console, ("joint", "kind", "moves", "range", "driven by", "speed"), rows)


def _strength(joint: Any, actuator: Any) -> str:
    if joint.mimic is not None:
        return f"follows {joint.mimic.joint}"
    if actuator is None:
        return "nothing"
    if actuator.limit is None:
        return str(actuator.kind)
    return f"{actuator.kind}, {actuator.limit:.3g} {joint.effort_unit}"


def _tally(shapes: tuple[str, ...]) -> str:
    counted = {shape: shapes.count(shape) for shape in shapes}
    return ", ".join(f"{n} {shape}" if n > 1 else shape for shape, n in counted.items())


def _table(console: Console, head: tuple[str, ...], rows: list[tuple[str, ...]]) -> None:
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False, header_style="bold")
    for name in head:
        table.add_column(name, overflow="fold")
    for row in rows:
        table.add_row(*(Text(cell) for cell in row))
    console.print(table, soft_wrap=False)
    console.print()


def _place(finding: Finding) -> str:
    where = finding.where
    if where.kind == "file":
        return f"{where.file}:{where.line}" if where.line else where.file
    return f"{where.kind} {where.name}" + (f" (line {where.line})" if where.line else "")


def _grouped(findings: tuple[Finding, ...]) -> list[list[Finding]]:
    groups: dict[tuple[str, str, str, str], list[Finding]] = defaultdict(list)
    for finding in findings:
        groups[finding.severity, finding.code, finding.done, finding.fix].append(finding)
    order = ("refused", "repaired", "info")
    return sorted(groups.values(), key=lambda group: order.index(group[0].severity))


def _show_group(console: Console, group: list[Finding]) -> None:
    from morph.body.finding import CODES

    first = group[0]
    lines = [f"{first.severity}  {first.code}: {CODES[first.code]}"]
    for finding in group[:PLACES]:
        lines.append(f"    {_place(finding)}: {finding.what}")
    if len(group) > PLACES:
        lines.append(f"    ... and {len(group) - PLACES} more; --json lists all")
    if first.done != "nothing":
        lines.append(f"    done: {first.done}")
    lines.append(f"    fix: {first.fix}")
    console.print("\n".join(lines) + "\n", markup=False)
