"""What a view shows, as data: every door that shows it (page, export, picture) reads this."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from morph.app.viewer.figure import Figure
from morph.app.viewer.motion import MotionFrames
from morph.arrays import Array

Colour = tuple[int, int, int]

MOST_UNSEEN = 3
"""Parts of a body that are told to be drawn otherwise; all others are counted."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Actor:
    """A body on the stage."""

    figure: Figure
    """What it looks like."""
    motion: MotionFrames
    """How it moves."""
    lane: int | None = None
    """Which place in the row it stands in; None for one of its own. Those of a lane overlap,
    such as a ghost and what it is compared with."""
    ghost: bool = False
    """Whether it is drawn translucent."""
    colour: Colour | None = None
    """One colour for all of it; None for its own colours."""
    tints: Mapping[str, Colour] = field(default_factory=dict)
    """Colours of single links by name, before all others."""
    title: str | None = None
    """What stands above it; None for the figure's name, empty for nothing."""


@dataclass(frozen=True, kw_only=True)
class Tie:
    """A line from a link of one actor to a link of another, which follows both."""

    source: tuple[int, str]
    """Number of an actor, and the name of its link."""
    target: tuple[int, str]
    """The same at its other end."""
    source_at: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Where on the one link it ends, in the link's frame, m."""
    target_at: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Where on the other."""
    strength: float = 1.0
    """How thick it is, 0 to 1."""
    colour: Colour = (0, 114, 178)
    """Its colour."""


@dataclass(frozen=True, kw_only=True)
class Moment:
    """A time to jump to."""

    time: float
    """On the shared clock, s."""
    title: str
    """Why, in words."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ChartLine:
    """One line of a chart."""

    name: str
    """What the legend calls it."""
    time: Array
    """On the shared clock, s, shape (points,); NaN breaks the line."""
    value: Array
    """Shape (points,)."""
    colour: str = "#0072b2"
    """As CSS has it."""
    dashed: bool = False
    """Whether it is dashed wherever it stands; others are told apart by dashes in their order."""
    leads: bool = False
    """Whether the axis is made for it, such as a measurement: where some lines lead, others may
    leave the plot, such as a model that blew up."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Chart:
    """Lines over the shared clock, with a cursor where the clock is."""

    title: str
    """What is drawn."""
    unit: str
    """Of its values."""
    lines: tuple[ChartLine, ...]
    """In the order of the legend."""


@dataclass(frozen=True, kw_only=True)
class CellTable:
    """A small table; a cell that changes with the clock is named by a series."""

    title: str
    """What stands above it."""
    head: tuple[str, ...]
    """Heads of the columns, the first over the names of the rows."""
    rows: tuple[tuple[str | LiveCell | Marked, ...], ...]
    """Cells; all text, none of it HTML."""
    words: bool = False
    """Whether its cells are sentences rather than numbers."""


@dataclass(frozen=True, kw_only=True)
class LiveCell:
    """A cell that shows a series of an actor where the clock is."""

    actor: int
    """Number of the actor."""
    series: str
    """Which of its motion's series."""
    digits: int = 3
    """Figures that are shown."""


@dataclass(frozen=True, kw_only=True)
class Marked:
    """A cell of words with a patch of colour before them; the words say it all without it."""

    text: str
    """The words."""
    colour: Colour
    """Of the patch."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Content:
    """All that is shown at one time."""

    actors: tuple[Actor, ...]
    """Bodies, in their order on the ground."""
    ties: tuple[Tie, ...] = ()
    """Lines between them."""
    charts: tuple[Chart, ...] = ()
    """Plots beside them."""
    tables: tuple[CellTable, ...] = ()
    """Tables beside them."""
    moments: tuple[Moment, ...] = ()
    """Times to jump to, marked on the clock."""
    notes: tuple[str, ...] = ()
    """What is to be known, a sentence each."""
    title: str = "morph"
    """What the page is called."""

    def __post_init__(self) -> None:
        """Note what is not as it should be, so that no view can forget to say so.

        That is what could not be drawn as described, and motions that end early.
        """
        figures = dict.fromkeys(actor.figure for actor in self.actors)
        unseen = (note for figure in figures for note in _unseen(figure))
        lost = (
            f"{actor.title or actor.figure.name}: its motion is not a number from "
            f"{actor.motion.lost:.3g} s on; it rests where it was last"
            for actor in self.actors
            if actor.motion.lost is not None
        )
        object.__setattr__(self, "notes", tuple(dict.fromkeys((*self.notes, *unseen, *lost))))

    @property
    def seconds(self) -> float:
        """How long the shared clock runs, s: as long as the longest motion."""
        return max((actor.motion.seconds for actor in self.actors), default=0.0)


def _unseen(figure: Figure) -> tuple[str, ...]:
    """Return what of a body could not be drawn as described, a sentence each."""
    given, more = figure.notes[:MOST_UNSEEN], len(figure.notes) - MOST_UNSEEN
    if more <= 0:
        return given
    return (*given, f"{figure.name}: {more} more of its parts are not drawn as described")
