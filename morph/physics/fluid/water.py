"""A body put into water: the effects that three numbers and its shapes decide."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.errors import RobotError
from morph.physics.effect import Effect
from morph.physics.fluid.added_mass import AddedMass
from morph.physics.fluid.buoyancy import Buoyancy
from morph.physics.fluid.quadratic_drag import QuadraticDrag
from morph.physics.fluid.wet import AXES
from morph.physics.fluid.wetted.figures import Figures, figures_of
from morph.physics.fluid.wetted.fit import check_density, fit_of
from morph.physics.fluid.wetted.shapes import every_shape

FRESH, SALT = 1000.0, 1025.0
"""Densities of fresh water and of the sea, kg/m3."""

ROUND = 1e-9
"""Part of a length or an inertia below which a number is round-off."""

CLOSE = 0.1
"""How far what the shapes displace may be from what the card says, as a part, without a note."""


@dataclass(frozen=True, kw_only=True)
class Immersed:
    """A robot's effects in a fluid, and what had to be decided on the way."""

    effects: tuple[Effect, ...]
    """Added mass, buoyancy and drag of every link that has a shape."""
    notes: tuple[str, ...]
    """What was mended, replaced or does not fit, with its figures; empty where all is clear."""


def immersed(
    robot: Robot,
    *,
    density: float = FRESH,
    scale: float | None = None,
    wetted_as: str | None = None,
    volume: float | None = None,
) -> Immersed:
    """Return what a fluid does to a robot, from the shapes of its links.

    Mass, density and scale suffice (Weissmann and Pinkall 2012, section 5): the mass is the
    robot's own. Added mass comes from boundary elements on each link's surface, alone in the
    fluid; buoyancy from its volume; drag from the pressure on its panels.

    Args:
        robot: The robot.
        density: Of the fluid, kg/m3.
        scale: Factor on every wetted length; default that of the card, or 1.
        wetted_as: `mesh`, `hull` or `box`; default that of the card, or `mesh`.
        volume: What the whole robot displaces, m3; default that of the card, or of the
            shapes. Buoyancy follows it where the shapes enclose another volume.

    Raises:
        RobotError: Density, scale or volume is not a positive number, no link has a shape,
            or the robot is lighter than the air that it displaces.
    """
    where = f"robot {robot.name} in a fluid"
    check_density(density, where=where)
    _positive(where, scale=scale, volume=volume)
    card = robot.card.water if robot.card is not None else None
    scale = scale or (card.scale if card else 1.0)
    way = wetted_as or (card.wetted if card else "mesh")
    parts = {
        link: figures_of(shapes, how=way, where=f"link {link}").scaled(scale)
        for link, shapes in every_shape(robot, rigid=True).items()
    }
    if not parts:
        raise RobotError(
            "none of its links has a shape for the fluid to touch",
            where=where,
            fix="give its links collision or visual shapes",
        )
    shapes = sum(part.tensor.volume for part in parts.values())
    whole = volume or (card.displaced_volume_m3 * (scale / card.scale) ** 3 if card else shapes)
    trim = fit_of(robot.mass, whole, density, where=where)
    effects = [
        e for name, part in parts.items() for e in _effects(name, part, density, whole / shapes)
    ]
    return Immersed(
        effects=tuple(effects), notes=(*_notes(parts, shapes, whole, scale), *filter(None, [trim]))
    )


def _positive(where: str, **given: float | None) -> None:
    for name, value in given.items():
        if value is not None and not (math.isfinite(value) and value > 0.0):
            raise RobotError(
                f"its {name} is {value:g}", where=where, fix=f"give a {name} above 0, in SI units"
            )


def _effects(link: str, part: Figures, density: float, lift: float) -> tuple[Effect, ...]:
    """Return what acts on one link; `lift` is what it displaces over what its shapes enclose."""
    volume, place = part.tensor.volume, part.tensor.centre
    tidy = np.where(np.abs(place) < ROUND * volume ** (1.0 / 3.0), 0.0, place)
    centre = dict(zip(("cx", "cy", "cz"), tidy.tolist(), strict=True))
    return (
        AddedMass.of(link, density * _tidy(part.tensor.about((0, 0, 0)).matrix)),
        Buoyancy(body=link, volume=lift * volume, density=density, **centre),
        QuadraticDrag(
            body=link, **dict(zip(AXES, (density * part.drag).tolist(), strict=True)), **centre
        ),
    )


def _tidy(matrix: Array) -> Array:
    """Return a tensor without what is only round-off beside its diagonal."""
    size = np.sqrt(np.diag(matrix))
    return np.where(np.abs(matrix) < ROUND * np.outer(size, size), 0.0, matrix)


def _notes(parts: dict[str, Figures], shapes: float, whole: float, scale: float) -> tuple[str, ...]:
    message: dict[str, list[str]] = {}
    for link, part in parts.items():
        if part.reason:
            size = "" if scale == 1.0 else "; lengths and litres at scale 1"
            message.setdefault(part.reason + size + _spread(part), []).append(link)
    notes = [
        f"link{'s' if len(links) > 1 else ''} {', '.join(links)}: {note}"
        for note, links in message.items()
    ]
    if abs(shapes / whole - 1.0) > CLOSE:
        notes.append(
            f"the shapes enclose {1e3 * shapes:.4g} litres where the robot displaces "
            f"{1e3 * whole:.4g}: buoyancy follows the latter, added mass and drag the shapes"
        )
    return tuple(notes)


def _spread(part: Figures) -> str:
    if not part.spread.any():
        return ""
    along, about = part.spread
    return (
        f" (among what might stand for it, added mass differs by up to {along:.0%} along "
        f"and {about:.0%} about an axis)"
    )
