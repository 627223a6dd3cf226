"""Masses that a scale showed, in place of those that a description states."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from morph.body.card import Card, Measured
from morph.body.draft import Draft
from morph.body.inertia import DENSITY, ball
from morph.body.robot import Robot
from morph.errors import RobotError


def weighed(draft: Draft, card: Card | None) -> Draft:
    """Return a draft whose links have the masses of a card, before anything is missed in them.

    Mass and inertia are multiplied alike: the shape stays, its density changes. Where a
    link had none, its inertia is still to be made from its shape.

    Raises:
        RobotError: A link is not there, or a mass is not positive.
    """
    links = {link.name: link for link in draft.links}
    changed = {}
    for measured in card.measured if card else ():
        _check(measured, tuple(links), str(draft.file.parent / "card.toml"))
        link = links[measured.link]
        factor = measured.mass_kg / link.mass if link.mass else None
        inertia = None if link.inertia is None or factor is None else link.inertia * factor
        changed[link.name] = replace(
            link, mass=measured.mass_kg, inertia=inertia, inertia_from="measured"
        )
    return draft.with_links(changed)


def weigh(spec: Any, card: Card | None, where: str) -> None:
    """Give the bodies of an MJCF, once their inertias are explicit, the masses of its card.

    Mass and inertia are multiplied alike; a body without either becomes a ball.

    Raises:
        RobotError: A link is not there, or a mass is not positive.
    """
    bodies = {body.name: body for body in spec.bodies[1:]}
    for measured in card.measured if card else ():
        _check(measured, tuple(bodies), where)
        body = bodies[measured.link]
        if body.mass > 0:
            body.inertia = body.inertia * (measured.mass_kg / body.mass)
        else:
            body.inertia = ball(measured.mass_kg, DENSITY).diagonal()
        body.mass = measured.mass_kg


def marked(robot: Robot) -> Robot:
    """Return a robot whose weighed links say so."""
    names = {measured.link for measured in robot.card.measured} if robot.card else set()
    if not names:
        return robot
    links = (
        replace(link, inertia_from="measured") if link.name in names else link
        for link in robot.links
    )
    return replace(robot, links=tuple(links))


def _check(measured: Measured, known: tuple[str, ...], where: str) -> None:
    if measured.link not in known:
        raise RobotError(
            f"its card weighs the link {measured.link!r}, and it has {', '.join(known)}",
            where=where,
            fix="correct the [[measured]] tables of card.toml",
        )
    if not 0 < measured.mass_kg < float("inf"):
        raise RobotError(
            f"its card says that {measured.link!r} weighs {measured.mass_kg:g} kg",
            where=where,
            fix="write the mass that the scale showed, in kg",
        )
