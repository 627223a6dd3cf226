"""A robot as the parts that it is made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from morph.body.robot import Robot
from morph.fabrication import off_the_shelf_parts as buying
from morph.fabrication.deduplicate_parts import made
from morph.fabrication.division import Division
from morph.fabrication.drawing import Drawing, drawing
from morph.fabrication.fused import fused
from morph.fabrication.groups import grouped
from morph.fabrication.hinges import hinges
from morph.fabrication.names import UniqueNames, safe
from morph.fabrication.off_the_shelf_parts import Item
from morph.fabrication.pieces import pieces, printed_links
from morph.fabrication.room import spared
from morph.fabrication.skeletons import skeletons
from morph.fabrication.unmatched_geometry import lost, lost_links
from morph.print.part import Part
from morph.print.printer import Profile


def divide(robot: Robot, profile: Profile) -> Division:
    """Return what of a body is printed, bought or fused, and how its parts move.

    A link drawn by meshes is those meshes, each a part; a link drawn by simple solids becomes a
    shell that holds what is bought. What cannot be made is refused in a check.

    Args:
        robot: The body; its card may say what is printed and what is bought.
        profile: How it is to be printed.
    """
    drawn = drawing(robot)
    things, notes = buying.items(drawn)
    joints = hinges(drawn)
    bones = spared(drawn, skeletons(drawn, things), joints)
    outcome = grouped(pieces(drawn, things, bones))
    names = UniqueNames()
    results = [made(drawn, group, profile, names) for group in outcome]
    printed = [part for result in results for part in result.parts]
    missing = {
        piece.link
        for group, result in zip(outcome, results, strict=True)
        if not result.parts
        for piece in group.pieces
    }
    parts = [replace(part, number=f"P-{at:02d}") for at, part in enumerate(printed, start=1)]
    return Division(
        robot=robot,
        parts=(
            *parts,
            *fused(drawn, things, parts, names),
            *_bought(drawn, things, names),
        ),
        hinges=joints,
        checks=(
            *lost(robot, drawn.shapes),
            *buying.axes(things),
            *(check for result in results for check in result.checks),
        ),
        notes=(
            *drawn.unread,
            *_taken(robot),
            *notes,
            *(note for result in results for note in result.notes),
        ),
        complete=_complete(drawn, things, missing | lost_links(robot)),
    )


def _taken(robot: Robot) -> tuple[str, ...]:
    """Return what is taken for granted where no card says what is bought."""
    if robot.card is not None and robot.card.print is not None:
        return ()
    servos = (
        [] if robot.card is None else [m.actuator for m in robot.card.motor if m.model != "ideal"]
    )
    where = f", and where the servos of {', '.join(servos[:3])} sit is not known" if servos else ""
    return (f"no card says what is bought: all that is drawn is taken to be printed{where}",)


def _bought(drawn: Drawing, things: Sequence[Item], names: UniqueNames) -> list[Part]:
    return [
        replace(part, name=names.one(safe(part.name)), number=f"B-{at:02d}")
        for at, part in enumerate(buying.parts(drawn, things), start=1)
    ]


def _complete(drawn: Drawing, things: Sequence[Item], missing: set[str]) -> frozenset[str]:
    """Return the links of which everything that weighs is known."""
    card = drawn.robot.card
    if card is None:
        return frozenset()
    if card.print is None:
        servos = any(motor.model != "ideal" for motor in card.motor)
        return frozenset() if servos else frozenset(set(printed_links(drawn)) - missing)
    held = {item.entry.link for item in things}
    return frozenset((set(printed_links(drawn)) | held) - missing)
