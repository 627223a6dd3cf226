"""Named worlds: the effects that put any body on a floor or into water."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from dataclasses import dataclass, replace

from morph.body.fulltext import fulltext
from morph.body.postures import described, posture_of
from morph.body.robot import Robot
from morph.body.spec import bare_spec
from morph.errors import EffectError
from morph.physics.apply import apply
from morph.physics.contact.presets import SURFACES, surface
from morph.physics.effect import Effect
from morph.physics.fluid.water import FRESH, SALT, immersed

WATERS = {"water": FRESH, "salt_water": SALT}
"""Density of each water, kg/m3."""


@dataclass(frozen=True, kw_only=True)
class World:
    """What surrounds a robot."""

    name: str
    """Its name."""
    effects: tuple[Effect, ...]
    """What it does to this robot."""
    notes: tuple[str, ...] = ()
    """What had to be decided of the robot's shapes, with its figures."""


def world_names() -> tuple[str, ...]:
    """Return the names of all worlds."""
    return (*WATERS, *(floor.name for floor in SURFACES))


def is_floor(name: str) -> bool:
    """Return whether a world is a floor."""
    return name in {floor.name for floor in SURFACES}


def start_in(robot: Robot, name: str | None) -> Mapping[str, float]:
    """Return where a robot starts in a world: on a floor, or if one was given, in its posture.

    Elsewhere it starts as it is described, but within its limits.
    """
    floor = name is not None and is_floor(name)
    return posture_of(robot) if floor or robot.posture is not None else described(robot)


def on_floor(robot: Robot, name: str) -> Robot:
    """Return a robot whose description has the floor of a named world.

    Raises:
        EffectError: There is no such world, it is water, or its floor is too stiff for the
            description's step.
    """
    if name in WATERS:
        raise EffectError(
            f"{name} is no floor",
            where="--world",
            fix="put the robot into water by `[water]` in its card",
        )
    spec, effects = bare_spec(robot), world(name, robot).effects
    try:
        apply(spec, effects)
    except EffectError as error:
        raise EffectError(
            f"{name} is no floor for this description: {error.what}",
            where="--world",
            fix="name hard_floor, which has no stiffness of its own, or describe a plane",
        ) from error
    spec.compile()
    return replace(robot, mjcf=fulltext(spec))


def world(name: str, robot: Robot) -> World:
    """Return a named world around a robot.

    Raises:
        EffectError: There is no such world.
        RobotError: The robot has no shapes that the world could act on.
    """
    if name in WATERS:
        held = immersed(robot, density=WATERS[name])
        return World(name=name, effects=held.effects, notes=held.notes)
    if name in world_names():
        return World(name=name, effects=surface(name))
    near = difflib.get_close_matches(name, world_names(), n=1)
    raise EffectError(
        f"there is no world {name!r}; there are {', '.join(world_names())}",
        where=f"world {name}",
        fix=f"did you mean {near[0]!r}?" if near else "name one of these worlds",
    )
