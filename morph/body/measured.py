"""Masses that a scale showed, in place of those that a description states."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from morph.body.card import Card, Measured
from morph.body.inertia import DENSITY, ball
from morph.body.robot import Robot
from morph.errors import RobotError


def weigh(spec: Any, card: Card | None, where: str) -> None:
    """Give the bodies of a spec, whose inertias are explicit, the masses of its card.

    Mass and inertia are multiplied alike: the shape stays, its density changes.

    Raises:
        RobotError: A link is not there, or a mass is not positive.
    """
    bodies = {body.name: body for body in spec.bodies[1:]}
    for measured in card.measured if card else ():
        body = bodies.get(measured.link)
        if body is None or not 0 < measured.mass_kg < float("inf"):
            raise _refused(measured, tuple(bodies), where)
        if body.mass > 0:
            body.inertia = body.inertia * (measured.mass_kg / body.mass)
        else:
            body.inertia = ball(measured.mass_kg, DENSITY).diagonal()
        body.mass = measured.mass_kg


def marked(robot: Robot) -> Robot:
    """Return a robot whose weighed links say so."""
    weighed = {measured.link for measured in robot.card.measured} if robot.card else set()
    if not weighed:
        return robot
    links = (
        replace(link, inertia_from="measured") if link.name in weighed else link
        for link in robot.links
    )
    return replace(robot, links=tuple(links))


def _refused(measured: Measured, known: tuple[str, ...], where: str) -> RobotError:
    if measured.link not in known:
        return RobotError(
            f"its card weighs the link {measured.link!r}, and it has {', '.join(known)}",
            where=where,
            fix="correct the [[measured]] tables of card.toml",
        )
    return RobotError(
        f"its card says that {measured.link!r} weighs {measured.mass_kg:g} kg",
        where=where,
        fix="write the mass that the scale showed, in kg",
    )
