"""The card of a body: what the shelf knows beside its description."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path

from morph.body.table import Place, read_table
from morph.errors import RobotError

SCHEMA = "morph.card/1"
"""The only schema of cards so far."""

BASES = ("fixed", "floating", "board")
"""How a body may stand in the world."""


@dataclass(frozen=True, kw_only=True)
class Source:
    """Where some of a body's numbers come from."""

    what: str
    """The numbers."""
    from_: str
    """The publication, file or measurement; the key is `from`."""


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
    """`ideal`, or a servo's name such as `STS3215`."""
    limit: float | None = None
    """Greatest effort, N m or N."""


@dataclass(frozen=True, kw_only=True)
class Measured:
    """What a scale showed; it comes before what the description says."""

    link: str
    """The link that was weighed."""
    mass_kg: float
    """Its mass, kg; its inertia is scaled with it."""


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
class Parameter:
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


@dataclass(frozen=True, kw_only=True)
class Print:
    """How a body that is printed divides into parts."""

    printed: tuple[str, ...] = ()
    """Links to print."""
    bought: tuple[Bought, ...] = ()
    """Parts to buy."""


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
    source: tuple[Source, ...]
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
    parameter: tuple[Parameter, ...] = ()
    """What a designer may change."""
    print: Print | None = None
    """Only for bodies that are printed."""


def load_card(path: Path) -> Card:
    """Return the card in a file.

    Raises:
        RobotError: The file cannot be read, is not TOML, or has a key or value
            that cards do not have; the line is named.
    """
    try:
        text = path.read_bytes().decode()
        table = tomllib.loads(text)
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
    place = Place(file=str(path), text=text)
    card = read_table(Card, table, place)
    _check(card.schema, (SCHEMA,), "schema", place)
    _check(card.base, BASES, "base", place)
    _check(card.name, (path.resolve().parent.name,), "name", place)
    if card.water is not None:
        water = Place(file=str(path), text=text, section="water")
        _check(card.water.wetted, ("mesh", "hull", "box"), "wetted", water)
    return card


def _check(value: str, allowed: tuple[str, ...], key: str, place: Place) -> None:
    if value not in allowed:
        names = " or ".join(repr(name) for name in allowed)
        raise RobotError(
            f"{key} is {value!r}, not {names}", where=place.key(key), fix=f"set {key} to {names}"
        )
