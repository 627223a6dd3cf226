"""A law that may be left out of a description: where it acts, its figures, how it is applied."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from experiments.concealed.mechanism import Mechanism
from experiments.concealed.plant import Array, Plant
from experiments.concealed.scales import Scales

Figures = Mapping[str, float]


@dataclass(frozen=True, kw_only=True)
class Setting:
    """What the figures of one law at one place are chosen from."""

    mechanism: Mechanism
    """The nominal mechanism."""
    plant: Plant
    """The true plant without the laws left out."""
    scales: Scales
    """Sizes along its runs."""
    place: int
    """Index of the joint or body; 0 for the world."""
    chance: Array
    """Numbers in [0, 1) drawn once, so that figures change smoothly with the size."""
    vary: Mapping[str, float]
    """By how much the description's figures may be wrong."""
    seconds: float
    """Length of a run."""

    def of(self, name: str) -> float:
        """Return a scale at the place."""
        return float(getattr(self.scales, name)[self.place])

    @property
    def side(self) -> float:
        """-1 or 1."""
        return 1.0 if self.chance[7] < 0.5 else -1.0

    @property
    def mass(self) -> float:
        """Mass of the body at the place."""
        return float(self.plant.of_body("mass")[self.place])

    @property
    def tip(self) -> Array:
        """A point near the far end of the body at the place: twice its centre of mass."""
        return np.asarray(2.0 * self.plant.com[self.place])

    @property
    def lever(self) -> float:
        """Length of the body at the place, m."""
        return float(max((self.tip @ self.tip) ** 0.5, 0.02))


@dataclass(frozen=True, kw_only=True)
class Law:
    """One law. Its size is about 1 where it is as large as what moves the joint."""

    name: str
    """Its name in `effects.md`, or one of our own outside of it."""
    kind: str
    """joint, actuator, sensor, body or world."""
    figures: Callable[[float, Setting], Figures]
    """Figures for a size and a setting."""
    apply: Callable[[Plant, int, Figures], Plant]
    """The plant with the law at a place."""
    largest: float = 1.0
    """Largest size."""
    least: Callable[[Setting], float] = lambda setting: 1e-4
    """Smallest size; below it the description's own uncertain figures could stand for it."""
    acts: Callable[[Mechanism, int], bool] = lambda mechanism, place: True
    """Whether it can act at a place, and be seen there."""
    beside: Callable[[Figures, Plant, Plant, int], Figures] = lambda figures, described, true, i: (
        figures
    )
    """Figures beside what the description says of the place, whose error is a part of them where a
    law changes it; given the described plant and the true one without the law."""
    given: tuple[str, ...] = ()
    """Figures that are geometry or otherwise not scored."""
    needs: str | None = None
    """A law at the same place without which it does nothing."""
    judge: bool = False
    """Whether only the suite `judge` has it."""
    why: str = ""
    """For physics outside the library: what it is."""

    @property
    def scored(self) -> Callable[[Figures], Figures]:
        """Return the figures that a solver can be expected to state."""
        return lambda figures: {k: v for k, v in figures.items() if k not in self.given}


def fields(**names: str) -> Callable[[Plant, int, Figures], Plant]:
    """Return an `apply` that adds each figure to a field of the joint."""

    def apply(plant: Plant, place: int, figures: Figures) -> Plant:
        return plant.with_joint(place, **{names[k]: x for k, x in figures.items() if k in names})

    return apply
