"""Everything that a verdict rests on."""

from __future__ import annotations

from dataclasses import dataclass

from morph.body.robot import Robot
from morph.model.conclude import Standing
from morph.model.episodes import Episode
from morph.model.hypothesis import Hypothesis
from morph.model.search import Contender, Search
from morph.model.segments import Segments
from morph.model.split import Split


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """Models fitted to the training runs, and the runs that were kept shut."""

    robot: Robot
    """The description as given."""
    nominal: Hypothesis
    """The description with its own figures free."""
    searched: tuple[Contender, Contender]
    """The description refitted, and with every finding, both as the search left them."""
    refitted: Contender
    """The first of these, its figures fitted to longer rollouts where those are scored."""
    best: Contender
    """The second, likewise."""
    stands: list[Standing]
    """Each finding beside its rivals; empty where the budget ended first."""
    search: Search
    """How it was found."""
    train: list[Episode]
    """What was fitted."""
    aside: list[Episode]
    """What was kept shut."""
    scored: Segments
    """Its rollouts."""
    split: Split
    """How the recordings were set apart."""
    horizon: float | None
    """Seconds of those rollouts; None for whole episodes."""
    still: tuple[str, ...]
    """Joints that no training run moves."""
    seed: int
    """Of every draw."""
    started: float
    """When the diagnosis began, s of the monotonic clock."""
