"""Loading a body by the name, the folder or the file that a user gives."""

from __future__ import annotations

import difflib
from itertools import chain, islice
from pathlib import Path

from morph.body import shelf
from morph.body.card import Card, load_card
from morph.body.description import read_description
from morph.body.paths import MARKS
from morph.body.postures import check_card_postures
from morph.body.robot import FREEDOMS, Robot
from morph.errors import RobotError

TOLERANCE = 1e-9
"""How near the mass must come to that of the card, kg."""

ENDINGS = (".urdf", ".xacro", ".mjcf", ".xml")
"""Files that a folder without a card is searched for."""

MOST_LOOKED_AT = 1000
"""Most files of a folder that are looked at for that."""


def load(robot: str | Path, *, base: str | None = None, folder: str | Path | None = None) -> Robot:
    """Return a robot; `robot.findings` says what was repaired in its description.

    Args:
        robot: A name on the shelf, a folder with a `card.toml`, or a URDF, xacro or
            MJCF file, or an assembly of meshes in TOML. A file's card is used if
            it names the file.
        base: `fixed`, `floating` or `board`: how it stands in the world, where a
            URDF does not say; it comes before the card's.
        folder: The folder outside which nothing is read; by default the
            description's own.

    Raises:
        RobotError: There is no such robot, its files cannot be used, or it is
            not what its card says. If it is a DescriptionRefused, its findings say
            everything that is wrong.
    """
    path, card = find(robot)
    result = read_description(path, card, base=base, folder=Path(folder) if folder else None)
    if card is not None and base is None:
        _check(result, card)
    check_card_postures(result)
    return result


def find(robot: str | Path) -> tuple[Path, Card | None]:
    """Return the description that a name, a folder or a file means, and its card.

    Raises:
        RobotError: There is no such robot, or its card cannot be used.
    """
    try:
        path = _path(robot)
        if path.is_dir():
            if not (path / "card.toml").is_file():
                raise _no_card(path)
            card = load_card(path / "card.toml")
            return path / card.description, card
        beside = path.parent / "card.toml"
        if beside.is_file() and path.is_file() and path.name != "card.toml":
            card = load_card(beside)
            if (path.parent / card.description).resolve() == path.resolve():
                return path, card
    except OSError as error:
        raise RobotError(
            f"cannot be looked for: {error.strerror or error}",
            where=str(robot),
            fix="give a file that exists, or a name that `morph list robots` shows",
        ) from error
    return path, None


def _path(robot: str | Path) -> Path:
    path = Path(robot)
    if isinstance(robot, str) and len(path.parts) == 1:
        if robot in shelf.names():
            return shelf.find(robot)
        if not path.exists() and not path.suffix:
            return shelf.find(robot)
    if not str(robot).strip():
        raise RobotError(
            "no robot is named",
            where="the robot",
            fix="give a description's file, or a name that `morph list robots` shows",
        )
    return path


def _no_card(folder: Path) -> RobotError:
    """Return what to do with a folder without a card: name a description that is in it."""
    places = chain.from_iterable(folder.glob(f"{depth}*.*") for depth in ("", "*/", "*/*/"))
    looked = islice(places, MOST_LOOKED_AT)
    known = sorted(
        str(place)
        for place in looked
        if place.suffix.lower() in ENDINGS and place.name not in MARKS
    )
    named = ", ".join(known[:3])
    return RobotError(
        "the folder has no card.toml that says which of its files is the robot",
        where=str(folder),
        fix=f"name the description itself, such as {named}" if named else "name the description",
    )


def _check(robot: Robot, card: Card) -> None:
    dof = sum(FREEDOMS[joint.kind] for joint in robot.joints)
    where = str(robot.source)
    if card.checks.mass_kg is not None and abs(robot.mass - card.checks.mass_kg) > TOLERANCE:
        raise RobotError(
            f"it weighs {robot.mass:.12g} kg, and its card says {card.checks.mass_kg:.12g} kg",
            where=where,
            fix="correct the masses, or mass_kg in the checks of card.toml",
        )
    if card.checks.dof is not None and dof != card.checks.dof:
        raise RobotError(
            f"it has {dof} degrees of freedom, and its card says {card.checks.dof}",
            where=where,
            fix="correct the joints, or dof in the checks of card.toml",
        )
    known = [actuator.name for actuator in robot.actuators] or ["none"]
    for motor in card.motor:
        if motor.actuator not in known:
            raise RobotError(
                f"its card names an actuator {motor.actuator!r}, and it has {', '.join(known)}",
                where=where,
                fix="correct the [[motor]] tables of card.toml",
            )
    _check_parameters(robot, card)


def _check_parameters(robot: Robot, card: Card) -> None:
    if not card.parameter:
        return
    from morph.body.vary import OPERATIONS

    operations = [operation.name for operation in OPERATIONS]
    parts = ["*", *(link.name for link in robot.links), *(joint.name for joint in robot.joints)]
    for parameter in card.parameter:
        for key, value, known in (
            ("operation", parameter.operation, operations),
            ("link", parameter.link, parts),
        ):
            if value not in known:
                near = difflib.get_close_matches(value, known, n=3, cutoff=0.4) or known[:8]
                raise RobotError(
                    f"the parameter {parameter.name!r} of its card names the {key} {value!r}, "
                    f"which is not there; nearest: {', '.join(near)}",
                    where=str(robot.source),
                    fix="correct the [[parameter]] tables of card.toml",
                )
