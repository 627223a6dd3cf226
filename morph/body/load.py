"""Loading a body by the name, the folder or the file that a user gives."""

from __future__ import annotations

from pathlib import Path

from morph.body import shelf
from morph.body.card import Card, load_card
from morph.body.mjcf import read_mjcf
from morph.body.robot import Robot
from morph.body.urdf import read_urdf
from morph.errors import RobotError

READERS = {".xml": read_mjcf, ".mjcf": read_mjcf, ".urdf": read_urdf}
"""The reader for each suffix."""

TOLERANCE = 1e-9
"""How near the mass must come to that of the card, kg."""

FREEDOMS = {"hinge": 1, "slide": 1, "ball": 3, "free": 6}
"""Degrees of freedom of each kind of joint."""


def load(robot: str | Path) -> Robot:
    """Return a robot.

    Args:
        robot: A name on the shelf, a folder with a `card.toml`, or an `.xml`,
            `.mjcf` or `.urdf` file. A file's card is used if it names the file.

    Raises:
        RobotError: There is no such robot, its files cannot be used, or it is
            not what its card says.
    """
    path = _path(robot)
    if path.is_dir():
        card = load_card(path / "card.toml")
        return _read(path / card.description, card)
    beside = path.parent / "card.toml"
    if beside.is_file() and path.is_file():
        card = load_card(beside)
        if (path.parent / card.description).resolve() == path.resolve():
            return _read(path, card)
    return _read(path, None)


def _path(robot: str | Path) -> Path:
    path = Path(robot)
    if isinstance(robot, str) and len(path.parts) == 1:
        if robot in shelf.names():
            return shelf.find(robot)
        if not path.exists() and not path.suffix:
            return shelf.find(robot)
    return path


def _read(path: Path, card: Card | None) -> Robot:
    if path.suffix not in READERS:
        raise RobotError(
            f"files that end in {path.suffix or 'nothing'!r} cannot be read",
            where=str(path),
            fix=f"give a file that ends in {', '.join(READERS)}",
        )
    _check_text(path)
    found = READERS[path.suffix](path, card)
    if card is not None:
        _check(found, card)
    return found


def _check_text(path: Path) -> None:
    try:
        content = path.read_bytes()
    except OSError as error:
        raise RobotError(
            f"cannot be read: {error.strerror or error}",
            where=str(path),
            fix=f"give a file that exists, or a name on the shelf: {', '.join(shelf.names())}",
        ) from error
    if not content.strip():
        raise RobotError("is empty", where=str(path), fix="give a description with a body in it")
    try:
        text = content.decode()
    except UnicodeDecodeError:
        text = "\0"
    if "\0" in text:
        raise RobotError(
            "is binary, not text", where=str(path), fix="give a description in UTF-8 XML"
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
