"""Limbs and postures of a robot in words, as `morph inspect` prints them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from morph.app.cli.console import harmless

if TYPE_CHECKING:
    from morph.body.inspect import Inspection
    from morph.body.robot import Robot
    from morph.body.standing import StandingPosture

LONGEST_NAME = 120
"""Letters of a name that are shown; JSON has it whole."""


def shown(name: str) -> str:
    """Return a name of a description as it may be printed."""
    return harmless(name, LONGEST_NAME)


def many(number: int, one: str, more: str) -> str:
    """Return a count with its noun."""
    return f"{number} {one if number == 1 else more}"


def limbs_text(result: Inspection) -> list[str]:
    """Return limbs, mirror images and postures, and whether motors hold it on its feet."""
    said = [*_limbs(result)]
    on_feet, robot = result.standing, result.robot
    if robot is None or (on_feet is None and not result.keyframes):
        return said
    names = [*result.keyframes, *(["standing"] if on_feet else []), "rest (as described)"]
    said.append(f"postures: {', '.join(shown(name) for name in names)}")
    if on_feet is not None:
        how = "on bent legs" if on_feet.computed else "as described"
        said.append(f"standing, {how}: {_held(on_feet, robot)}")
    return said


def _limbs(result: Inspection) -> list[str]:
    found = result.limbs
    if found is None or not found.limbs:
        return []
    alike: dict[tuple[bool, int], list[str]] = {}
    for limb in found.limbs:
        alike.setdefault((limb.foot, len(limb.joints)), []).append(shown(limb.end))
    parts = []
    for (foot, count), ends in alike.items():
        number = many(len(ends), *(("foot", "feet") if foot else ("limb", "limbs")))
        parts.append(f"{number} of {many(count, 'joint', 'joints')}: {', '.join(ends)}")
    if found.twins:
        parts.append(f"{many(len(found.twins), 'joint has', 'joints have')} mirror images")
    return ["; ".join(parts)]


def _held(on_feet: StandingPosture, robot: Robot) -> str:
    if not on_feet.balanced:
        return "no forces at its feet balance it; it must step or be held"
    if not on_feet.lacking:
        return "its motors hold it"
    name, needed = max(on_feet.lacking.items(), key=lambda each: abs(each[1]))
    motor = robot.actuator(name)
    return (
        f"{shown(name)} would have to give {abs(needed):.3g} {motor.effort_unit} and gives "
        f"{motor.limit:.3g}"
    )
