"""A design as a new body on the user's own shelf."""

from __future__ import annotations

import os
import re
import shutil
import tempfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import morph
from morph.app.viewer.design.design_state import BodyPlan, Built
from morph.app.viewer.design.parameters import effective, usable
from morph.body.card import SCHEMA, Card, CardParameter, Checks, Citation, Motor, PrintTable
from morph.body.card_text import card_text
from morph.body.convert import convert
from morph.body.load import TOLERANCE, load
from morph.body.robot import FREEDOMS, Robot
from morph.body.shelf import names, user_shelf
from morph.body.vary import Lock, Stiffen
from morph.errors import OutputError, ViewError
from morph.files import write_whole

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,59}", re.ASCII)
"""Names of bodies: never a path."""

DEVICES = {
    "con",
    "prn",
    "aux",
    "nul",
    *(f"{port}{at}" for port in ("com", "lpt") for at in range(10)),
}
"""Names that no folder has on Windows."""


def save(plan: BodyPlan, built: Built, name: str) -> Path:
    """Write a design to the user's shelf and return its folder.

    It is written and read back beside the shelf's bodies, and moved among them when it is the
    same body: whole or not at all, and never over another.

    Args:
        plan: The body as described.
        built: The design of it.
        name: What to call it: letters, digits and _, of no body on either shelf.

    Raises:
        ViewError: The name cannot be used, or is taken.
        OutputError: The shelf cannot be written to.
        MorphError: What was written is not the same body.
    """
    check_name(name)
    shelf = user_shelf()
    try:
        shelf.mkdir(parents=True, exist_ok=True)
        # One level deeper than bodies are looked for.
        made = Path(tempfile.mkdtemp(dir=shelf, prefix=".being_saved_"))
    except OSError as error:
        raise _unwritable(shelf, error) from error
    try:
        folder = made / name
        convert(replace(built.robot, name=name), "mjcf", folder)
        write_whole(folder / "card.toml", card_text(card_of(plan, built, name)))
        _same(load(folder), built.robot)
        check_name(name)
        os.rename(folder, shelf / name)
    except OSError as error:
        raise _unwritable(shelf / name, error) from error
    finally:
        shutil.rmtree(made, ignore_errors=True)
    return shelf / name


def check_name(name: str) -> None:
    """Refuse a name that no new body can have.

    Raises:
        ViewError: It is no name, or it is taken.
    """
    if not NAME.fullmatch(name) or name.casefold() in DEVICES:
        raise ViewError(
            f"a body cannot be called {name[:60]!r}",
            where="save as a new body",
            fix="begin with a letter; go on with up to 59 letters, digits and _",
        )
    taken = {each.casefold() for each in names()}
    if name.casefold() in taken or (user_shelf() / name).exists():
        raise ViewError(
            f"there is a body called {name!r} already, and nothing is written over it",
            where="save as a new body",
            fix="choose another name; `morph list robots` shows those that are taken",
        )


def card_of(plan: BodyPlan, built: Built, name: str) -> Card:
    """Return the card of a design: where it comes from, and what still holds of the original's.

    The description holds closed chains and what was weighed; parameters count from the design.
    """
    robot, before = built.robot, robot_card(plan.robot)
    card = built.robot.card or before
    links = {link.name for link in robot.links}
    return Card(
        schema=SCHEMA,
        name=name,
        title=f"{before.title}, as designed",
        description="robot.xml",
        base=before.base,
        source=(*origins(plan, built.values), *before.source),
        licence=before.licence,
        tasks=before.tasks,
        checks=Checks(mass_kg=robot.mass, dof=sum(FREEDOMS[joint.kind] for joint in robot.joints)),
        water=card.water,
        motor=_motors(robot, card),
        parameter=_parameters(robot, plan, built.values),
        print=_print(card.print, links),
    )


def origins(plan: BodyPlan, values: Mapping[str, float]) -> tuple[Citation, ...]:
    """Return where a design's numbers come from: the original, and each parameter."""
    robot = plan.robot
    first = Citation(
        what="everything that no parameter below changed",
        from_=f"the robot {robot.name} (sha256 {robot.sha256[:16]}), by morph {morph.__version__}",
    )
    by = {parameter.name: parameter for parameter in plan.parameters}
    values = effective(plan.parameters, values)
    return (
        first,
        *(
            Citation(
                what=f"{each} = {values[each]!r}",
                from_=f"chosen in morph view: {by[each].operation} of {by[each].link}",
            )
            for each in by
            if each in values
        ),
    )


def robot_card(robot: Robot) -> Card:
    """Return a robot's card, or one that says what its description does."""
    if robot.card is not None:
        return robot.card
    first = robot.joints[0] if robot.joints else None
    floats = any(joint.kind == "free" for joint in robot.joints)
    board = first is not None and first.kind == "slide" and first.name.startswith("board")
    return Card(
        schema=SCHEMA,
        name=robot.name,
        title=robot.name,
        description="",
        base="floating" if floats else "board" if board else "fixed",
        source=(),
        licence="NOASSERTION",
    )


def _motors(robot: Robot, card: Card) -> tuple[Motor, ...]:
    known = {actuator.name for actuator in robot.actuators}
    return tuple(motor for motor in card.motor if motor.actuator in known)


def _parameters(
    robot: Robot, plan: BodyPlan, values: Mapping[str, float]
) -> tuple[CardParameter, ...]:
    """Return the card's parameters with ranges that count from the design."""
    results = []
    for parameter in usable(robot, plan.own):
        value = values.get(parameter.name)
        if value is None or parameter.operation == Lock.name:
            results.append(parameter)
        elif parameter.operation == Stiffen.name:
            low, high = max(0.0, parameter.low - value), max(0.0, parameter.high - value)
            results.append(replace(parameter, low=low, high=high))
        else:
            low, high = parameter.low / value, parameter.high / value
            results.append(replace(parameter, low=low, high=high))
    return tuple(results)


def _print(printed: PrintTable | None, links: set[str]) -> PrintTable | None:
    if printed is None:
        return None
    return PrintTable(
        printed=tuple(link for link in printed.printed if link in links),
        bought=tuple(each for each in printed.bought if each.link in links),
        fused=tuple(link for link in printed.fused if link in links),
    )


def _same(result: Robot, robot: Robot) -> None:
    """Refuse what was written if it is not the body that was designed."""
    same_joints = [joint.name for joint in result.joints] == [joint.name for joint in robot.joints]
    if abs(result.mass - robot.mass) > TOLERANCE or not same_joints:
        raise OutputError(
            f"what was written weighs {result.mass:.12g} kg, and the design {robot.mass:.12g} kg",
            where="save as a new body",
            fix="nothing was saved; tell the authors which body and which parameters it was",
        )


def _unwritable(place: Path, error: OSError) -> OutputError:
    return OutputError(
        f"the design cannot be saved: {error.strerror or error}",
        where=str(place),
        fix="let MORPH_SHELF name a folder that can be written to and has room",
    )
