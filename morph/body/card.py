"""The card of a body: what the shelf knows beside its description."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

from morph.body.table import Place, read_table
from morph.errors import RobotError
from morph.toml_file import load_toml

SCHEMA = "morph.card/1"
"""The only schema of cards so far."""

BASES = ("fixed", "floating", "board")
"""How a body may stand in the world."""

MOST_BYTES, MOST_POSTURES = 2**18, 100
"""Largest card, bytes, and most postures; the longest on the shelf has a few thousand bytes."""


@dataclass(frozen=True, kw_only=True)
class Citation:
    """Where some of a body's numbers come from."""

    what: str
    """The numbers."""
    from_: str
    """The publication, file or measurement; the key is `from`."""
    licence: str = ""
    """SPDX name of the licence of a public file, `NOASSERTION` if it states none; else empty."""


@dataclass(frozen=True, kw_only=True)
class Checks:
    """What the loader must find, to 1e-9."""

    mass_kg: float | None = None
    """Mass of all links, kg."""
    dof: int | None = None
    """Degrees of freedom."""


@dataclass(frozen=True, kw_only=True)
class Water:
    """What a body that swims displaces."""

    mass_kg: float
    """Mass with everything on board, kg."""
    displaced_volume_m3: float
    """Volume of water that it pushes aside, m3."""
    scale: float = 1.0
    """Scale of its wetted shape."""
    wetted: str = "mesh"
    """What water touches: `mesh`, `hull` or `box`."""


@dataclass(frozen=True, kw_only=True)
class Motor:
    """The motor behind one actuator."""

    actuator: str
    """The actuator in the description; in a URDF, which has none, the joint."""
    model: str = "ideal"
    """`ideal`, `servo` by the figures below, or a servo's name such as `STS3215`, whose figures
    those below replace."""
    limit: float | None = None
    """Greatest effort, N m or N."""
    kp: float | None = None
    """Of a servo: effort per position error, N m/rad or N/m."""
    kv: float | None = None
    """Of a servo: effort per velocity, N m s/rad or N s/m."""
    armature: float | None = None
    """Inertia of its rotor seen at the joint, kg m2 or kg."""
    friction: float | None = None
    """Dry friction of its gears seen at the joint, N m or N."""


@dataclass(frozen=True, kw_only=True)
class Measured:
    """What a scale showed; it comes before what the description says."""

    link: str
    """The link that was weighed."""
    mass_kg: float
    """Its mass, kg; its inertia is scaled with it."""


@dataclass(frozen=True, kw_only=True)
class CardPosture:
    """A posture by name."""

    name: str
    """What it is called; a file of several postures calls it the same."""
    file: str
    """TOML or SRDF file in the card's folder."""


@dataclass(frozen=True, kw_only=True)
class Closure:
    """A closed chain, which URDF cannot hold."""

    kind: str
    """`four-bar`, `planar` (any number of hinges) or `ball` (a ball pin, anywhere)."""
    bodies: tuple[str, ...]
    """The links in it, in order; what the description lacks joins the last to the first."""
    pin: tuple[float, ...] = ()
    """The missing pin in the frame of the last link, m; found from the geometry if not given."""
    pin_on_first: tuple[float, ...] = ()
    """The same pin in the frame of the first link, m; taken from the home pose if not given."""


@dataclass(frozen=True, kw_only=True)
class CardParameter:
    """What a designer may change."""

    name: str
    """What it is called."""
    operation: str
    """The operation of `vary.py` that changes it."""
    link: str
    """The link changed."""
    low: float
    """Least value."""
    high: float
    """Greatest value."""


@dataclass(frozen=True, kw_only=True)
class Bought:
    """A part that is bought rather than printed."""

    part: str
    """What it is."""
    count: int
    """How many."""
    mass_kg: float
    """Mass of one, kg."""
    link: str
    """The link that carries it."""
    shape: str = ""
    """The shape of that link which stands for it, by its name in the description."""
    joint: str = ""
    """The joint that it turns, if it is a servo."""


@dataclass(frozen=True, kw_only=True)
class PrintTable:
    """How a body that is printed divides into parts."""

    printed: tuple[str, ...] = ()
    """Links to print."""
    bought: tuple[Bought, ...] = ()
    """Parts to buy."""
    fused: tuple[str, ...] = ()
    """Printed links that are one piece with the link that they hang from."""


@dataclass(frozen=True, kw_only=True)
class Card:
    """A body's card; field names are the keys of `card.toml`."""

    schema: str
    """`morph.card/1`."""
    name: str
    """The folder's name."""
    title: str
    """What to call it in a heading."""
    description: str
    """MJCF or URDF file beside the card."""
    base: str
    """`fixed`, `floating` or `board`."""
    source: tuple[Citation, ...]
    """Where every number comes from."""
    licence: str
    """SPDX name of its licence."""
    tasks: tuple[str, ...] = ()
    """What it is expected to do."""
    checks: Checks = Checks()
    """What the loader must find."""
    water: Water | None = None
    """Only for bodies that swim."""
    motor: tuple[Motor, ...] = ()
    """One per actuator."""
    measured: tuple[Measured, ...] = ()
    """Links that were weighed."""
    closure: tuple[Closure, ...] = ()
    """Closed chains."""
    posture: tuple[CardPosture, ...] = ()
    """Postures beside those of its description."""
    parameter: tuple[CardParameter, ...] = ()
    """What a designer may change."""
    print: PrintTable | None = None
    """Only for bodies that are printed."""


def load_card(path: Path) -> Card:
    """Return the card in a file.

    Raises:
        RobotError: The file cannot be read, is too large, is not TOML, has a key or
            value that cards do not have, or describes by a file outside its folder;
            the line is named.
    """
    try:
        table, text = load_toml(path, MOST_BYTES)
        place = Place(file=str(path), text=text)
        card = read_table(Card, table, place)
    except OSError as error:
        raise RobotError(
            f"cannot read the card: {error.strerror or error}",
            where=str(path),
            fix="put a card.toml into the robot's folder",
        ) from error
    except ValueError as error:
        raise RobotError(
            f"is not TOML: {error}", where=str(path), fix="correct the line it names"
        ) from error
    _check(card.schema, (SCHEMA,), "schema", place)
    _check(card.base, BASES, "base", place)
    _check(card.name, (path.resolve().parent.name,), "name", place)
    if card.water is not None:
        _check(
            card.water.wetted, ("mesh", "hull", "box"), "wetted", replace(place, section="water")
        )
    _check_inside(path.parent, card.description, place.key("description"))
    _check_postures(card, path.parent, place)
    _check_masses(card, place)
    return card


def _check_inside(folder: Path, name: str, where: str) -> None:
    """Refuse a file elsewhere: a stranger's card must not open files beside its own."""
    try:
        # A link may lead anywhere; only its end counts.
        inside = (folder / name).resolve().is_relative_to(folder.resolve())
        inside &= Path(name).name == name
    except (OSError, RuntimeError, ValueError):
        inside = False
    if not inside:
        raise RobotError(
            f"{name!r} is no file in the card's folder",
            where=where,
            fix="put the file beside the card, and give its name",
        )


def _check_postures(card: Card, folder: Path, place: Place) -> None:
    taken = ["rest", "standing"]
    for at, posture in enumerate(card.posture):
        here = replace(place, section="posture", index=at)
        _check_inside(folder, posture.file, here.key("file"))
        if posture.name in taken or at >= MOST_POSTURES:
            raise RobotError(
                f"its card has more than {MOST_POSTURES} postures"
                if at >= MOST_POSTURES
                else f"its card calls a posture {posture.name!r}, as another is called",
                where=here.key("name"),
                fix="keep those that tasks start in, each with a name of its own",
            )
        taken.append(posture.name)


def _check_masses(card: Card, place: Place) -> None:
    if card.checks.mass_kg is not None and not 0 < card.checks.mass_kg < math.inf:
        raise RobotError(
            f"its card says that it weighs {card.checks.mass_kg:g} kg",
            where=replace(place, section="checks").key("mass_kg"),
            fix="write the mass of all links, in kg, or leave mass_kg out",
        )
    weighed = set()
    for at, measured in enumerate(card.measured):
        here = replace(place, section="measured", index=at)
        if not 0 < measured.mass_kg < math.inf:
            raise RobotError(
                f"its card says that {measured.link!r} weighs {measured.mass_kg:g} kg",
                where=here.key("mass_kg"),
                fix="write the mass that the scale showed, in kg",
            )
        if measured.link in weighed:
            raise RobotError(
                f"its card weighs the link {measured.link!r} twice",
                where=here.key("link"),
                fix="keep one of its [[measured]] tables",
            )
        weighed.add(measured.link)


def _check(value: str, allowed: tuple[str, ...], key: str, place: Place) -> None:
    if value not in allowed:
        names = " or ".join(repr(name) for name in allowed)
        raise RobotError(
            f"{key} is {value!r}, not {names}", where=place.key(key), fix=f"set {key} to {names}"
        )
