"""`morph inspect`: what a robot is, and what is wrong with its description."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from morph.app.cli.arguments import Inspect
from morph.app.cli.console import TIE, harmless, paragraph, say, table, width
from morph.app.cli.limbs_text import limbs_text, many, shown
from morph.app.cli.output_file import check_output_file
from morph.app.picture.endings import PICTURES
from morph.errors import OutputError
from morph.extras import require

if TYPE_CHECKING:
    from morph.body.finding import DescriptionFinding
    from morph.body.inspect import Inspection
    from morph.body.robot import Actuator, Joint, Robot

OK, UNUSABLE = 0, 2

PLACES = 8
"""Places of one finding that are named before the rest is counted."""

MEANS = {
    "ok": "nothing was changed",
    "repaired": "it is simulated with the repairs above",
    "refused": "there is no robot to simulate",
}
"""What each verdict means."""

SOURCES = {
    "measured": "as weighed",
    "description": "from the description",
    "mesh x density": "from shapes and their density",
    "none": "made up",
}
"""Where inertias come from, if all come from there."""

COLOURS = {"refused": "bold red", "repaired": "yellow", "info": "cyan"}
"""Of a severity, where the terminal shows colours."""

ORDER = tuple(COLOURS)

Lines = list[tuple[str, str]]
"""Lines with the style of each."""


def run_inspect(options: Inspect) -> int:
    """Print what was found and return the exit status.

    Raises:
        MorphError: It cannot be drawn, or has no such posture.
    """
    from morph.body.inspect import inspect_robot

    if options.picture is not None:
        check_output_file("--picture", options.picture, tuple(PICTURES))
        require("view", "morph inspect --picture")
    elif options.posture is not None:
        raise OutputError(
            "there is no picture to draw in it", where="--posture", fix="give --picture too"
        )
    result = inspect_robot(options.robot, base=options.base, folder=options.folder)
    if options.json:
        sys.stdout.write(json.dumps(result.as_json(), indent=2, allow_nan=False) + "\n")
    else:
        _show(result)
    if options.picture is not None and result.robot is not None:
        _draw(result.robot, options.posture, Path(options.picture))
    bad = result.verdict == "refused" or (options.strict and result.verdict != "ok")
    return UNUSABLE if bad else OK


def _draw(robot: Robot, posture: str | None, path: Path) -> None:
    """Draw a robot on the floor, in a posture or that in which tasks start."""
    from morph.app.picture.video import picture
    from morph.body.postures import posture_of, postured
    from morph.body.spec import spec_of
    from morph.sim.start import started

    start = posture_of(postured(robot, posture))
    position, _ = started(robot, spec_of(robot).compile(), start)
    picture(robot, (), position, path)


def _show(result: Inspection) -> None:
    columns = width()
    lines: Lines = []
    if result.robot is not None:
        for line in _head(result, result.robot):
            lines += _plain(paragraph(line, 2, columns))
        for part in (_links, _joints, _others, _chains):
            head, *rows = part(result.robot, columns) or [""]
            lines += [(head, "bold"), *_plain(rows), ("", "")] if head else []
        rest = [line for said in limbs_text(result) for line in paragraph(said, 2, columns)]
        rest += _sensors(result.robot, columns)
        lines += _plain([*rest, ""]) if rest else []
    for group in _grouped(result.findings):
        lines += _group(group, columns)
    say([*lines, *_plain(paragraph(_closing(result), 2, columns))])


def _closing(result: Inspection) -> str:
    counts = [
        f"{number} {severity}"
        for severity in ORDER
        if (number := sum(each.severity == severity for each in result.findings))
    ]
    given = f" ({', '.join(counts)})" if counts else ""
    return f"{shown(result.name)}: {result.verdict}, {MEANS[result.verdict]}{given}"


def _plain(lines: Iterable[str]) -> Lines:
    return [(line, "") for line in lines]


def _head(result: Inspection, robot: Robot) -> list[str]:
    x, y, z = (_rounded(value) for value in result.com or ())
    counted = (
        many(len(robot.links), "link", "links"),
        many(len(robot.joints), "joint", "joints"),
        many(result.dof, "degree of freedom", "degrees of freedom"),
    )
    lines = [f"{shown(result.name)}: {robot.mass:.6g} kg, " + ", ".join(counted)]
    if robot.loops:
        lines[0] += f" before {many(len(robot.loops), 'closed chain', 'closed chains')}"
    if robot.source is not None:
        lines.append(f"  read from {harmless(str(robot.source))}")
    lines.append(f"  centre of mass at home ({x}, {y}, {z}) m, reach {result.reach:.3g} m")
    sources = {link.inertia_from for link in robot.links if link.mass}
    if len(sources) == 1:
        lines.append(f"  inertias {SOURCES[sources.pop()]}")
    return [*filter(None, lines), ""]


def _rounded(value: float) -> str:
    """Return a length to four digits; what is below a nanometre is rounding, and zero."""
    return f"{0.0 if abs(value) < 1e-9 else value:.4g}"


def _links(robot: Robot, columns: int | None) -> list[str]:
    sources = {link.inertia_from for link in robot.links if link.mass}
    rows = [
        (
            shown(link.name),
            shown(link.parent),
            f"{link.mass:.4g}",
            link.inertia_from if len(sources) > 1 else "",
            _tally(link.shapes, "visual"),
            _tally(link.shapes, "collision"),
        )
        for link in robot.links
    ]
    head = ("link", "hangs from", "kg", "inertia from", "visual", "collision")
    return table(head, _aligned(rows, 2), columns=columns)


def _joints(robot: Robot, columns: int | None) -> list[str]:
    drives = {actuator.joint: actuator for actuator in robot.actuators}
    rows = [
        (
            shown(joint.name),
            joint.kind,
            shown(joint.link),
            _range(joint),
            _drive(joint, drives.get(joint.name)),
            "" if joint.velocity is None else f"{joint.velocity:.4g} {joint.unit}/s",
            f"{joint.damping:.4g} {joint.effort_unit} s/{joint.unit}" if joint.damping else "",
            f"{joint.friction:.4g} {joint.effort_unit}" if joint.friction else "",
        )
        for joint in robot.joints
    ]
    head = ("joint", "kind", "moves", "range", "driven by", "speed", "damping", "dry friction")
    return table(head, rows, columns=columns) if rows else []


def _others(robot: Robot, columns: int | None) -> list[str]:
    rows = [
        (
            shown(each.name),
            shown(each.part),
            "" if each.limit is None else f"{each.limit:.4g} {each.effort_unit}",
        )
        for each in robot.actuators
        if each.joint is None
    ]
    return table(("actuator", "acts on", "limit"), rows, columns=columns) if rows else []


def _range(joint: Joint) -> str:
    if joint.limits is None:
        return "unlimited"
    low, high = joint.limits
    return f"{low:.3g} to {high:.3g} {joint.unit}"


def _drive(joint: Joint, actuator: Actuator | None) -> str:
    if joint.mimic is not None:
        return f"follows {shown(joint.mimic.joint)}"
    if actuator is None:
        return ""
    kind = {"position": "servo"}.get(actuator.kind, actuator.kind)
    kind += "" if actuator.name == joint.name else f" {shown(actuator.name)}"
    return kind if actuator.limit is None else f"{kind} {actuator.limit:.4g} {joint.effort_unit}"


def _chains(robot: Robot, columns: int | None) -> list[str]:
    held = {"connect": "pinned", "weld": "welded"}
    rows = [
        (
            shown(loop.name),
            shown(loop.links[0]),
            held.get(loop.kind, loop.kind),
            shown(loop.links[1]),
        )
        for loop in robot.loops
    ]
    return table(("closed chain", "link", "is", "to"), rows, columns=columns) if rows else []


def _sensors(robot: Robot, columns: int | None) -> list[str]:
    kinds = [sensor.kind for sensor in robot.sensors]
    text = ", ".join(f"{kinds.count(kind)} {kind}" for kind in dict.fromkeys(kinds))
    return paragraph(f"sensors: {text}", 2, columns) if kinds else []


def _tally(shapes: tuple[str, ...], role: str) -> str:
    kinds = [kind for shape in shapes for first, _, kind in [shape.partition(" ")] if first == role]
    counted = {kind: kinds.count(kind) for kind in kinds}
    return ", ".join(f"{number} {kind}" for kind, number in counted.items())


def _aligned(rows: Sequence[tuple[str, ...]], at: int) -> list[tuple[str, ...]]:
    """Return rows whose numbers in one column stand with their points below each other."""
    before = max((len(row[at].partition(".")[0]) for row in rows), default=0)
    return [
        (*row[:at], " " * (before - len(row[at].partition(".")[0])) + row[at], *row[at + 1 :])
        for row in rows
    ]


def _grouped(findings: tuple[DescriptionFinding, ...]) -> list[list[DescriptionFinding]]:
    groups: dict[tuple[str, str], list[DescriptionFinding]] = {}
    for finding in findings:
        groups.setdefault((finding.severity, finding.code), []).append(finding)
    return sorted(groups.values(), key=lambda group: ORDER.index(group[0].severity))


def _group(group: list[DescriptionFinding], columns: int | None) -> Lines:
    """Return the lines of one code's findings: what is common to all of them is said once."""
    from morph.body.finding import CODES

    severity, code = group[0].severity, group[0].code
    title, *more = paragraph(f"{severity}  {code}: {CODES[code]}", 4, columns)
    alike: dict[tuple[str, str, str], list[DescriptionFinding]] = {}
    for finding in group:
        alike.setdefault((finding.what, finding.done, finding.fix), []).append(finding)
    done = {finding.done for finding in group}
    fixes = {finding.fix for finding in group}
    lines = []
    for (what, how, fix), same in list(alike.items())[:PLACES]:
        lines.append(f"    {_places(same)}: {what}")
        lines += [f"      done: {how}"] * (len(done) > 1 and how != "nothing")
        lines += [f"      fix: {fix}"] * (len(fixes) > 1)
    hidden = sum(len(same) for same in list(alike.values())[PLACES:])
    lines += [f"    ... and {hidden} more; --json lists all"] * bool(hidden)
    lines += [f"    done: {group[0].done}"] * (len(done) == 1 and group[0].done != "nothing")
    lines += [f"    fix: {group[0].fix}"] * (len(fixes) == 1)
    for line in lines:
        more += paragraph(harmless(line), 8, columns)
    return [(title, COLOURS[severity]), *_plain([*more, ""])]


def _places(findings: list[DescriptionFinding]) -> str:
    """Return where one and the same was found: `link a (line 3), b (line 9)`."""
    named = [_place(finding) for finding in findings[:PLACES]]
    kind = findings[0].where.kind
    shown = [named[0], *(name.removeprefix(f"{kind} ") for name in named[1:])]
    more = len(findings) - len(shown)
    return ", ".join(shown) + (f" and {more} more" if more else "")


def _place(finding: DescriptionFinding) -> str:
    where = finding.where
    if where.kind == "file":
        return f"{where.file}:{where.line}" if where.line else where.file
    line = f"{TIE}(line{TIE}{where.line})" if where.line else ""
    return f"{where.kind} {shown(where.name)}{line}"
